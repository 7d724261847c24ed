"""The tools that are compared, each behind the same two functions.

`read` takes records, shape (records, samples), in u at `rate_hz`, and gives the coefficients
Q [u s], N [u/sqrt(Hz)], B [u], K [u/sqrt(s)], R [u/s] in that order. NaN stands for what a tool
does not give. Each tool is called as its documentation says and converted here, nowhere else.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanfit

from . import generators

SYMBOLS = "QNBKR"


class Reading(NamedTuple):
    """Coefficients, shape (records, 5), and 95 % intervals, shape (records, 5, 2)."""

    value: np.ndarray
    interval: np.ndarray | None


@dataclass(frozen=True)
class Tool:
    """One tool; a tool with several estimates of the same run has several rows."""

    name: str
    distribution: str
    rows: tuple[str, ...]
    read: Callable[[np.ndarray, float], tuple[Reading, ...]]
    from_curve: Callable[[np.ndarray, np.ndarray, float], np.ndarray] | None = None
    """Coefficients from averaging times [s], Allan variances [u^2] and a rate [Hz]."""
    batched: bool = False
    """Whether it works on many records at once, so that a block is its unit of time."""

    @property
    def installed(self) -> str | None:
        """The version that is there, or None."""
        try:
            return version(self.distribution)
        except PackageNotFoundError:
            return None

    @cached_property
    def fingerprint(self) -> str:
        """Changes whenever the tool's numbers may; allanfit's with its code too.

        Taken once: code that is edited during a run is not the code that runs.
        """
        files = [Path(__file__), Path(generators.__file__)]
        if self.distribution == "allanfit":
            for stage in ("physics", "curves", "identify"):
                files += sorted((Path(allanfit.__file__).parent / stage).glob("*.py"))
        digest = hashlib.sha256(b"".join(file.read_bytes() for file in files))
        return f"{self.installed}-{digest.hexdigest()[:8]}"


def tools(resamples: int) -> tuple[Tool, ...]:
    """All tools; ntpstats' bootstrap intervals only where `resamples` is not 0."""
    ntpstats = partial(Tool, distribution="ntpstats", from_curve=_ntpstats_from_curve)
    found = [
        Tool(
            "allanfit",
            "allanfit",
            ("allanfit, posterior median", "allanfit, least squares"),
            _allanfit,
            batched=True,
        ),
        ntpstats("ntpstats", rows=("ntpstats, Allan curve",), read=_ntpstats),
        ntpstats(
            "ntpstats-spectrum",
            rows=("ntpstats, Allan curve and spectrum",),
            read=partial(_ntpstats, spectrum=True),
        ),
        Tool(
            "allan-variance",
            "allan-variance",
            ("allan-variance, five terms by NNLS",),
            _nnls,
            _nnls_from_curve,
        ),
        Tool("slopes", "allantools", ("slopes read from allantools",), _slopes, _slopes_from_curve),
    ]
    if resamples:
        found.append(
            ntpstats(
                f"ntpstats-bootstrap-{resamples}",
                rows=(f"ntpstats, Allan curve, {resamples} resamples",),
                read=partial(_ntpstats, resamples=resamples),
            )
        )
    return tuple(found)


def _allanfit(records: np.ndarray, rate_hz: float) -> tuple[Reading, Reading]:
    fits = allanfit.fit_many(records, rate_hz)

    def stacked(by_symbol):
        return np.stack([np.asarray(by_symbol[symbol]) for symbol in SYMBOLS], axis=1)

    median = Reading(stacked(fits.coefficients), stacked(fits.interval(0.95)))
    return median, Reading(stacked(fits.least_squares), None)


def _nnls(records: np.ndarray, rate_hz: float) -> tuple[Reading]:
    compute_avar = import_module("allan_variance").compute_avar
    values = []
    for record in records:
        # "mean": samples in u, not increments of the integral; all other settings are its own.
        tau, variance = compute_avar(record, dt=1 / rate_hz, input_type="mean")
        values.append(_nnls_from_curve(tau, variance, rate_hz))
    return (Reading(np.array(values), None),)


def _nnls_from_curve(tau: np.ndarray, variance: np.ndarray, rate_hz: float) -> np.ndarray:
    found, _ = import_module("allan_variance").estimate_parameters(tau, variance)
    return found[["quantization", "white", "flicker", "walk", "ramp"]].to_numpy(dtype=float)


def _slopes(records: np.ndarray, rate_hz: float) -> tuple[Reading]:
    oadev = import_module("allantools").oadev
    longest = records.shape[1] // 9  # beyond this a curve has too few clusters to be read
    sizes = np.unique(np.geomspace(1, longest, 12 * int(np.log10(longest)) + 1).astype(int))
    values = []
    for record in records:
        tau, deviation, _, _ = oadev(record, rate_hz, data_type="freq", taus=sizes / rate_hz)
        values.append(_slopes_from_curve(tau, deviation**2, rate_hz))
    return (Reading(np.array(values), None),)


def _slopes_from_curve(tau: np.ndarray, variance: np.ndarray, rate_hz: float) -> np.ndarray:
    """N at 1 s, B from the minimum, K at 3 s on a +1/2 line through where the slope is nearest.

    IEEE Std 952-1997, annex C. Without a point right of the minimum there is no K.
    """
    log_tau, deviation = np.log(tau), np.sqrt(variance)
    lowest = int(np.argmin(deviation))
    slope = np.gradient(np.log(deviation), log_tau)
    n = np.exp(np.interp(0.0, log_tau, np.log(deviation)))
    b = deviation[lowest] / 0.664
    k = np.nan
    if lowest + 1 < len(tau):
        rising = lowest + 1 + int(np.argmin(np.abs(slope[lowest + 1 :] - 0.5)))
        k = deviation[rising] * np.sqrt(3 / tau[rising])
    return np.array([np.nan, n, b, k, np.nan])


# ntpstats describes clocks: y [1] is a fractional frequency with S_y(f) = sum of h_a f^a, one
# sided, and its integral x [s] the phase. A rate in u takes the place of y. Flicker of phase,
# a = 1, is no inertial term and is left out, which makes ntpstats' N a little better.
_ALPHAS = {"Q": 2, "N": 0, "B": -1, "K": -2}


def _ntpstats(
    records: np.ndarray, rate_hz: float, *, spectrum: bool = False, resamples: int = 0
) -> tuple[Reading]:
    fit_phase = import_module("ntpstats.noisefit").fit_phase
    values, intervals = [], []
    for seed, record in enumerate(records):
        # Its own `detrend` takes out the mean rate too; it changes no difference of differences.
        phase = np.concatenate([[0.0], np.cumsum(record - record.mean())]) / rate_hz
        fit = fit_phase(
            phase, 1 / rate_hz, spectrum=spectrum, ci=0.95, bootstrap=resamples, seed=seed,
            alphas=tuple(_ALPHAS.values()), drift=True,
        )  # fmt: skip
        values.append(_from_power_laws(fit.h, fit.drift, rate_hz))
        limits = [_from_power_laws(h, np.nan, rate_hz) for h in (fit.lo, fit.hi)]
        intervals.append(np.stack(limits, axis=-1))
    return (Reading(np.array(values), np.array(intervals)),)


def _ntpstats_from_curve(tau: np.ndarray, variance: np.ndarray, rate_hz: float) -> np.ndarray:
    even = np.full(len(tau), 1000.0)
    deviation = np.sqrt(variance)
    curve = import_module("ntpstats.stability").StabilityResult(
        "oadev", 1 / rate_hz, tau, deviation, deviation, even, edf=even
    )
    found = import_module("ntpstats.noisefit").fit(
        [curve], alphas=tuple(_ALPHAS.values()), drift=True
    )
    return _from_power_laws(found.h, found.drift, rate_hz)


def _from_power_laws(h: dict[int, float], drift: float, rate_hz: float) -> np.ndarray:
    """Q, N, B, K, R of h_2, h_0, h_-1, h_-2 and the drift (IEEE Std 1139-2008).

    White phase has variance Q^2, so S_x = 2 Q^2 dt; S_y is 2 N^2, B^2/(pi f), K^2/(2 pi^2 f^2).
    """
    squares = {
        "Q": h[_ALPHAS["Q"]] * rate_hz / (8 * np.pi**2),
        "N": h[_ALPHAS["N"]] / 2,
        "B": h[_ALPHAS["B"]] * np.pi,
        "K": h[_ALPHAS["K"]] * 2 * np.pi**2,
    }
    return np.append(np.sqrt(list(squares.values())), drift)
