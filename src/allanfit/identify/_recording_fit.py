"""A whole recording: every channel fitted, with findings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, overload

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..coefficients import CONVERGED, NOT_CONVERGED
from ..curves import octaves, read_slopes
from ..datasheet import Datasheet, Judged, Measured, Shown, datasheet_document, judge
from ..formatting import finite
from ..physics import STANDARD_TERMS, SYMBOLS, Sampling
from ..recording import Channel, Recording
from ..temperature import (
    ChannelTemperature,
    Treatment,
    beside,
    effect_beside,
    sentences,
    temperature_document,
)
from ._curves_document import curves_document
from ._fit import Fit, fit_series
from ._fit_document import channel_header, coefficients_document, recording_document
from ._goodness import MISFIT
from ._influence import Influence, influence
from ._influence_document import influence_document, influence_findings
from ._nyquist import nyquist_score
from ._sample import Posterior, sample

SCHEMA = "allanfit.fit/1"
LEFT_OUT = (
    "Something is left out of the five-term model, and the coefficients carry its mark: their "
    "intervals are only as good as the model."
)
# Standard deviations by which the spectrum must fall short near the Nyquist frequency.
_DEFICIT = 3.0
# Pieces whose influence is told, if each has as many samples.
_PIECES = 60
_SAMPLES_A_PIECE = 16


@dataclass(frozen=True)
class ChannelFit:
    """One channel's fit, with what the recording says about the channel."""

    channel: Channel
    fit: Fit
    posterior: Posterior | None
    influence: Influence | None = None
    temperature: ChannelTemperature | None = None
    remarks: tuple[str, ...] = ()
    """What else is to be said, such as why the effect of temperature is not known."""
    datasheet: Datasheet | None = None

    @property
    def judged(self) -> tuple[Judged, ...]:
        """What the fit says about each line of the data sheet that concerns this channel."""
        if self.datasheet is None:
            return ()
        fit, design = self.fit, self.fit.design
        shown = Shown(
            np.asarray(fit.estimate.draws),
            _measured(fit),
            {symbol: bool(seen) for symbol, seen in fit.resolved.items()},
            bool(fit.goodness_of_fit >= MISFIT),
            1 / float(fit.rate_hz),
            np.asarray(design.cluster_sizes, float),
            np.sqrt(np.asarray(fit.estimate.statistics.allan, float)),
            sum(design.lengths),
        )
        lines = self.datasheet.of(self.channel.name, self.channel.kind)
        return judge(lines, shown if bool(fit.converged) else None)

    @property
    def findings(self) -> tuple[str, ...]:
        """What the reader should know before trusting the numbers, one sentence each."""
        found = list(self.channel.findings)
        if not bool(self.fit.converged):
            found.append("The fit did not converge; its numbers mean nothing.")
            return tuple(found)
        if float(self.fit.goodness_of_fit) < MISFIT:
            found.append(LEFT_OUT)
        if nyquist_score(self.fit) < -_DEFICIT:
            found.append(
                "The spectrum falls toward the Nyquist frequency, which would take a negative Q^2: "
                "a low-pass filter or repeated samples. N is then read too low, and B and K are "
                "not to be trusted."
            )
        if self.posterior is not None and not self.posterior.converged:
            worst = max(self.posterior.r_hat.values())
            found.append(f"The sampler has not settled (R-hat {worst:.3f}): intervals are rough.")
        if self.influence is not None:
            found += influence_findings(
                self.influence, self.fit, self.channel.unit, self.channel.factor
            )
        found += self.remarks
        heat = self.temperature
        if heat is not None and (heat.claimed or heat.confounded or heat.removed):
            found += sentences(heat, self.channel, *self._both())
        return tuple(found)

    @property
    def advice(self) -> tuple[str, ...]:
        """How much longer to record for narrower intervals, a sentence for each wide one."""
        # A plan is made of a fit's likelihood, and so knows this package.
        from ..plan import advice

        result = self.fit
        if not bool(result.converged):
            return ()
        rate_hz = float(result.rate_hz)
        return advice(
            {symbol: float(value) for symbol, value in result.coefficients.items()},
            {symbol: bool(seen) for symbol, seen in result.resolved.items()},
            sum(result.design.lengths) / rate_hz,
            rate_hz,
            result.design.sampling,
            {s: (float(low), float(high)) for s, (low, high) in result.intervals.items()},
        )

    def table_entry(self) -> dict[str, Any]:
        """The part of the JSON entry that a table shows; the whole takes seconds to compute."""
        channel, result = self.channel, self.fit
        return {
            **channel_header(channel, result),
            "status": CONVERGED if bool(result.converged) else NOT_CONVERGED,
            "coefficients": coefficients_document(result, channel),
            "goodness_of_fit": {
                "p_value": finite(result.goodness_of_fit),
                "consistent": bool(result.goodness_of_fit >= MISFIT),
            },
            "curves": curves_document(result, channel.factor),
            "findings": list(self.findings),
        }

    def to_dict(self) -> dict[str, Any]:
        """This channel's entry in the fit JSON, in the unit that the user gave."""
        channel, result = self.channel, self.fit
        return {
            **self.table_entry(),
            "posterior": None if self.posterior is None else self.posterior.to_dict(),
            "slope_reading": self._slope_reading(),
            "influence": None
            if self.influence is None
            else influence_document(self.influence, result),
            "temperature": None
            if self.temperature is None
            else temperature_document(self.temperature, channel, *self._both()),
            "datasheet": None
            if self.datasheet is None
            else datasheet_document(
                self.datasheet,
                self.judged,
                self.datasheet.left_out_of(channel.name, channel.kind),
            ),
            "advice": list(self.advice),
        }

    def _slope_reading(self) -> dict[str, float | None]:
        """What a ruler reads off the Allan deviation, in the unit that the user gave."""
        design = self.fit.design
        sizes = np.intersect1d(octaves(sum(design.lengths)), design.cluster_sizes)
        shown = np.searchsorted(design.cluster_sizes, sizes)
        deviation = jnp.sqrt(self.fit.estimate.statistics.allan[shown])
        tau_s = jnp.asarray(sizes / float(self.fit.rate_hz), deviation.dtype)
        reading = read_slopes(tau_s, deviation / self.channel.factor)
        return {symbol: finite(value) for symbol, value in reading.items()}

    def _both(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """The coefficients with the effect of temperature in the data, and without it."""
        if self.temperature is None:
            raise ValueError(f"there is no temperature beside {self.channel.name}")
        # The main fit has the better draws of the two.
        kept, removed = self.fit, self.temperature.effect.removed
        if self.temperature.removed:
            kept, removed = self.temperature.plain, self.fit
        channel = self.channel
        return coefficients_document(kept, channel), coefficients_document(removed, channel)


@dataclass(frozen=True)
class RecordingFit:
    """The fits of all channels of a recording."""

    recording: Recording
    channels: tuple[ChannelFit, ...]

    def __getitem__(self, name: str) -> ChannelFit:
        """The fit of the channel of that name; `KeyError` if there is none."""
        return {channel.channel.name: channel for channel in self.channels}[name]

    def to_dict(self) -> dict[str, Any]:
        """The fit JSON, schema allanfit.fit/1."""
        return recording_document(SCHEMA, self.recording, self.channels)

    def _repr_html_(self) -> str:
        """Coefficients with intervals, for a notebook."""
        # Formatting comes after fitting, and is not loaded with it.
        from ..report import fit_html

        entries = [channel.table_entry() for channel in self.channels]
        return fit_html({"findings": self.recording.findings, "channels": entries})


def fit_recording(
    recording: Recording,
    *,
    posterior: bool = True,
    sampling: Sampling = "point",
    temperature: Treatment = "show",
    datasheet: Datasheet | None = None,
    pieces: Literal["all", "misfits"] = "all",
    seed: int = 0,
    announce: Callable[[str], None] = lambda channel: None,
    done: Callable[[], None] = lambda: None,
) -> RecordingFit:
    """Fit every channel of a recording.

    **Arguments:**

    - `recording`: from `allanfit.load`.
    - `posterior`: sample with emcee and report its diagnostics; otherwise intervals come from
      the posterior that `fit` samples in JAX, the same to within a few per cent of their width.
    - `temperature`: what to do with a temperature in the recording. "show" estimates its effect
      and keeps the coefficients of the samples as they are, which is what a filter meets that
      does not compensate; "remove" gives those with the effect taken out; "ignore" does neither.
    - `datasheet`: from `allanfit.read_datasheet`, to be compared with each channel it is about.
    - `pieces`: which channels are told the influence of their pieces, "all" or the "misfits" that
      the five terms do not fit. It takes several times as long as the fit.
    - `sampling`: whether samples are values at a time ("point") or means since the one before
      ("averaged").
    - `seed`: the same seed gives the same intervals.
    - `announce`, `done`: called with each channel's name before its fit, and after it.

    **Raises:** `DatasheetError` if the data sheet does not go with the recording, `ValueError` if
    no stretch of a channel is long enough for a fit.
    """
    if datasheet is not None:
        datasheet.check(recording.name, recording.channels)
    fits = []
    for channel in recording.channels:
        announce(channel.name)
        result = fit_series(
            channel.samples,
            recording.rate_hz,
            sampling=sampling,
            seed=seed,
            stretches=channel.stretches,
        )
        found, remarks, samples = None, (), channel.samples
        thermometer = None if temperature == "ignore" else beside(channel, recording)
        if thermometer is not None and bool(result.converged):
            try:
                found = effect_beside(channel, thermometer, result, temperature == "remove", seed)
            except ValueError as error:
                remarks = (f"The effect of temperature is not known: {error}.",)
        if found is not None and found.removed:
            result = found.effect.removed
            samples = samples - np.asarray(found.effect.drift, float)
        drawn = None
        if posterior and bool(result.converged):
            drawn = sample(result, seed=seed)
            result = result.with_draws(drawn.draws.reshape(-1, len(STANDARD_TERMS)))
        parts = None
        if pieces == "all" or float(result.goodness_of_fit) < MISFIT:
            parts = _influence(samples, channel.stretches, result)
        fits.append(ChannelFit(channel, result, drawn, parts, found, remarks, datasheet))
        done()
    return RecordingFit(recording, tuple(fits))


@overload
def fit(data: Recording, **options: Any) -> RecordingFit: ...
@overload
def fit(
    data: Float[Array, " samples"] | np.ndarray | Sequence, rate_hz: float, **options: Any
) -> Fit: ...
def fit(
    data: Recording | Float[Array, " samples"] | np.ndarray | Sequence,
    rate_hz: float | None = None,
    **options: Any,
) -> RecordingFit | Fit:
    """Identify the five noise coefficients of a still sensor, with intervals.

    An array of one sensor's samples goes with its `rate_hz` to a `Fit`, in pure JAX, with the
    options of `fit_series`. A `Recording` from `allanfit.load` goes to a `RecordingFit` of all
    its channels, with the options of `fit_recording`.

    **Raises:** `ValueError` for a wrong shape, too few samples, a rate that is missing, and for an
    array whose values are not finite or all alike, unless JAX traces it: see `fit_series`.
    """
    if isinstance(data, Recording):
        if rate_hz is not None:
            raise ValueError("a Recording knows its rate; give rate_hz to allanfit.load instead")
        return fit_recording(data, **options)
    if rate_hz is None:
        raise ValueError("an array needs rate_hz, in samples per second")
    return fit_series(data, rate_hz, **options)


def series_fit(result: Fit, name: str = "data", unit: str = "") -> RecordingFit:
    """The fit of an array, as that of a recording with one channel."""
    samples = np.zeros(sum(result.design.lengths))
    channel = Channel(name, unit, 1.0, unit, "other", samples, ((0, len(samples)),), ())
    recording = Recording(name, float(result.rate_hz), (channel,), (), (), "")
    return RecordingFit(recording, (ChannelFit(channel, result, None),))


def _measured(fit: Fit) -> dict[str, Measured]:
    middles, intervals, limits = fit.coefficients, fit.intervals, fit.upper_limits
    found = {}
    for symbol in SYMBOLS:
        low, high = intervals[symbol].tolist()
        found[symbol] = Measured(float(middles[symbol]), low, high, float(limits[symbol]))
    return found


def _influence(
    samples: np.ndarray, stretches: tuple[tuple[int, int], ...], result: Fit
) -> Influence | None:
    if not bool(result.converged):
        return None
    pieces = min(_PIECES, sum(result.design.lengths) // _SAMPLES_A_PIECE)
    return influence(result, samples, stretches, pieces=pieces)
