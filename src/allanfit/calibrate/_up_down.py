"""The up-down test of an accelerometer: bias and scale factor from two still recordings."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..formatting import duration, significant
from ..physics import Sampling
from ..recording import Channel, Recording
from ..recording._units import parse_unit
from ._data import Data, as_recording
from ._gravity import checked_gravity, refuse_wrong_unit
from ._intervals import Intervals, mixture_intervals
from ._means import drift_weights, white_weights
from ._noise import Noise, StatedNoise, fitted_noise, mean, stated_noise
from ._result import AxisCalibration, Calibration, Quantity, Residuals

# An axis was turned over if half its difference is this much of the largest.
_VERTICAL = 0.5
_BLOCKS = 60
# What a degree from the vertical takes from gravity.
_TILT = 1.5e-4
_MEANING = (
    "The bias interval says where the bias will be, averaged over another {length} right after "
    "these recordings, by the noise in them. As recorded (bias_of_these_recordings) it is blurred "
    "by white noise alone. The scale-factor interval allows for white noise and for drift of the "
    "bias between the two. None knows what changes when the sensor is switched off."
)


class _Axis(NamedTuple):
    up: Channel
    down: Channel


def up_down(
    up: Data,
    down: Data,
    *,
    gravity: float | None = None,
    rate_hz: float | None = None,
    channels: Sequence[str] | None = None,
    unit: str | None = None,
    topic: str | None = None,
    noise: StatedNoise | None = None,
    gap_s: float = 0.0,
    sampling: Sampling = "point",
    seed: int = 0,
) -> Calibration:
    """Bias and scale factor of accelerometer axes held still upward, then downward.

    With the means a1 (up) and a2 (down), and measured = a + S a + B + noise,

        B = (a1 + a2)/2,    S = (a1 - a2)/(2 g) - 1.

    The mean of coloured noise is worse than its standard deviation over the root of the number
    of samples, and what its error is depends on what is asked. Three answers, each from the noise
    N, B, K, Q of the axis (one fit to both recordings, draws of whose posterior are averaged
    over, or `noise`) by the generalised variance of means:

    - `bias` has the interval of the bias that will be met next: B less the mean of the wandering
      bias over another run as long as both recordings together, right after them.
    - `bias_of_these_recordings` has the interval of the bias as it was, which is blurred by N and
      Q alone.
    - `scale_factor` has the interval that N, Q and the drift from the one mean to the other
      allow: of neighbouring recordings of T, Allan variance (T)/(2 g^2).

    A fit to two recordings cannot exclude drift that is slower than they are long: where B or K
    is not resolved the first and last are wide. Noise from a longer recording makes them sharp.

    **Arguments:**

    - `up`, `down`: files, `Recording`s or arrays of shape (samples,) or (samples, 3) with
      `rate_hz`. Axes that lay level in both are left out. Up is where the axis reads +g.
    - `gravity`: where the test was made [m/s^2]; the standard one if not given.
    - `rate_hz`, `channels`, `unit`, `topic`: as in `allanfit.load`; without any unit, m/s^2.
    - `noise`: coefficients by symbol in the unit of the channels, or a file of them.
    - `gap_s`: time between the end of `up` and the start of `down` [s].
    - `sampling`, `seed`: as in `allanfit.fit`.

    **Raises:** `ValueError` when the files are one and the same, were swapped, or do not belong
    together, when no axis was turned over, and when the unit cannot be right.
    """
    if not gap_s >= 0:
        raise ValueError(f"gap_s must be zero or more seconds; got {gap_s}.")
    local, findings = checked_gravity(gravity)
    first, second = (
        _in_metres(as_recording(data, rate_hz, channels, unit, topic)) for data in (up, down)
    )
    second = _in_order_of(first, second)
    _refuse_unlike(first, second)
    findings += _about_recordings(first, second)
    pairs, left_out = _turned_over(first, second, local, asked=bool(channels))
    findings += left_out
    rate = first.rate_hz
    axes = {}
    for pair in pairs:
        for recording, channel in zip((first, second), pair, strict=True):
            findings += tuple(
                f"{recording.name}, {channel.name}: {each}" for each in channel.findings
            )
        found = (
            fitted_noise(pair, rate, sampling, seed)
            if noise is None
            else stated_noise(noise, pair.up)
        )
        findings += found.findings
        axes[pair.up.name] = _calibrate(pair, found, local, gap_s, rate)
    lengths = [_length(channel) / rate for channel in pairs[0]]
    if any(_half_width(axis.scale_factor) < _TILT for axis in axes.values()):
        findings += (
            "The scale factor is only as good as the alignment: an axis held 1 degree from the "
            "vertical reads 0.015 % too little, which is more than an interval here says.",
        )
    return Calibration(
        procedure="up-down",
        source=f"{first.name}, {second.name}",
        description=(
            f"up {duration(lengths[0])}, down {duration(lengths[1])} at "
            f"{significant(rate)} Hz, gravity {significant(local, 6)} m/s^2, noise "
            f"{'fitted' if noise is None else 'as stated'}"
        ),
        intervals=_MEANING.format(length=duration(sum(lengths))),
        conditions={
            "gravity": local,
            "up_s": lengths[0],
            "down_s": lengths[1],
            "gap_s": float(gap_s),
            "rate_hz": rate,
            "sampling": sampling,
            "noise": "fitted" if noise is None else "stated",
        },
        axes=axes,
        findings=findings,
    )


def _calibrate(
    pair: _Axis, noise: Noise, gravity: float, gap_s: float, rate_hz: float
) -> AxisCalibration:
    """One axis, from its two means and its noise."""
    a1, a2 = mean(pair.up), mean(pair.down)
    t1, t2 = (_length(channel) / rate_hz for channel in pair)
    starts = (0.0, t1 + gap_s, t1 + gap_s + t2)
    white = white_weights((t1, t2), (0.5, 0.5))
    ahead = white + drift_weights(starts, (t1, t2, t1 + t2), (0.5, 0.5, -1.0))
    apart = white + drift_weights(starts[:2], (t1, t2), (0.5, -0.5))
    bias, half = (a1 + a2) / 2, (a1 - a2) / 2

    def intervals(value: float, weights: np.ndarray) -> Intervals:
        return mixture_intervals(value, noise.powers @ weights, noise.weights)

    unit, factor = pair.up.unit, pair.up.factor
    # A scale factor is a ratio to gravity; its interval is that of half the difference.
    ratio = Quantity(half / gravity - 1, "1", {})
    scaled = Quantity(half, "", intervals(half, apart)).scaled(1 / gravity, "1")
    ends = {
        level: None if each is None else (each[0] - 1, each[1] - 1)
        for level, each in scaled.intervals.items()
    }
    return AxisCalibration(
        bias=Quantity(bias, "", intervals(bias, ahead)).scaled(1 / factor, unit),
        scale_factor=replace(ratio, intervals=ends),
        bias_of_these_recordings=Quantity(bias, "", intervals(bias, white)).scaled(
            1 / factor, unit
        ),
        residuals=_residuals(pair, rate_hz),
    )


def _in_metres(recording: Recording) -> Recording:
    """Channels without a unit in m/s^2, which `refuse_wrong_unit` then checks."""
    default = parse_unit("m/s^2")
    made = []
    for channel in recording.channels:
        if not channel.unit:
            channel = replace(
                channel, unit=default.name, si_unit=default.si_unit, kind=default.kind
            )
        made.append(channel)
    return replace(recording, channels=tuple(made))


def _in_order_of(up: Recording, down: Recording) -> Recording:
    """The channels of `down` as those of `up` stand, whatever columns its file begins with."""
    place = {channel.name: at for at, channel in enumerate(up.channels)}
    ordered = sorted(down.channels, key=lambda channel: place.get(channel.name, len(place)))
    return replace(down, channels=tuple(ordered))


def _about_recordings(up: Recording, down: Recording) -> tuple[str, ...]:
    """The recordings' own findings; for a missing unit, what became of it."""
    findings = ()
    for recording in (up, down):
        for each in recording.findings:
            if each.startswith("No unit is known"):
                each = "No unit is known: taken as m/s^2, which gravity confirms."
            findings += (f"{recording.name}: {each}",)
    return findings


def _refuse_unlike(up: Recording, down: Recording) -> None:
    same = up is down or (bool(up.checksum) and up.checksum == down.checksum)
    if same or _equal_samples(up, down):
        raise ValueError(
            "UP and DOWN are the same recording; give one with the axis up and one with it down."
        )
    if abs(up.rate_hz / down.rate_hz - 1) > 1e-2:
        raise ValueError(
            f"UP has {up.rate_hz:.6g} Hz and DOWN {down.rate_hz:.6g} Hz; give two recordings of "
            "the same sensor at one rate."
        )
    ours, theirs = ([channel.name for channel in each.channels] for each in (up, down))
    if ours != theirs:
        raise ValueError(
            f"UP has the axes {', '.join(ours)} and DOWN {', '.join(theirs)}; they must be the "
            "same: choose some with --channel."
        )
    for first, second in zip(up.channels, down.channels, strict=True):
        if first.factor != second.factor or first.kind != second.kind:
            raise ValueError(
                f"{first.name} is in {first.unit} in UP and in {second.unit} in DOWN; give both in "
                "one unit, or the unit with --unit."
            )


def _equal_samples(up: Recording, down: Recording) -> bool:
    return len(up.channels) == len(down.channels) and all(
        np.array_equal(first.samples, second.samples)
        for first, second in zip(up.channels, down.channels, strict=True)
    )


def _turned_over(
    up: Recording, down: Recording, gravity: float, asked: bool
) -> tuple[list[_Axis], tuple[str, ...]]:
    """The axes that were held up and then down, and findings on those that were not."""
    axes = [
        pair for pair in map(_Axis, up.channels, down.channels) if pair.up.kind == "accelerometer"
    ]
    if not axes or (asked and len(axes) < len(up.channels)):
        odd = next(channel for channel in up.channels if channel.kind != "accelerometer")
        raise ValueError(
            f"{odd.name} is in {odd.unit}, and the up-down test is one of accelerometers: choose "
            "them with --channel, or correct the unit with --unit m/s^2 or --unit g."
        )
    largest = max(axes, key=lambda axis: abs(mean(axis.up)))
    turned = max(axes, key=lambda axis: abs(_half_difference(axis)))
    if abs(_half_difference(turned)) < _VERTICAL * abs(mean(largest.up)):
        raise ValueError(_not_turned(largest))
    kept, level = [], []
    for axis in axes:
        half = _half_difference(axis)
        # Against the most vertical axis, and not gravity: the unit may yet be wrong.
        if abs(half) < _VERTICAL * abs(_half_difference(turned)):
            if asked:
                raise ValueError(_not_turned(axis))
            level.append(axis.up.name)
            continue
        if half < 0:
            raise ValueError(
                f"{axis.up.name} reads {_reading(axis.up)} in UP and {_reading(axis.down)} in "
                "DOWN: the two are swapped (up is where the axis reads +g); give them the other "
                "way round."
            )
        refuse_wrong_unit(axis.up.name, axis.up.unit, half, gravity)
        kept.append(axis)
    return kept, (f"Left out, since not turned over: {', '.join(level)}.",) if level else ()


def _half_difference(axis: _Axis) -> float:
    return (mean(axis.up) - mean(axis.down)) / 2


def _not_turned(axis: _Axis) -> str:
    return (
        f"{axis.up.name} was not turned over: it reads {_reading(axis.up)} in UP and "
        f"{_reading(axis.down)} in DOWN, where +g and -g are needed."
    )


def _reading(channel: Channel) -> str:
    return f"{mean(channel) / channel.factor:.4g} {channel.unit}"


def _length(channel: Channel) -> int:
    return sum(stop - start for start, stop in channel.stretches)


def _half_width(quantity: Quantity) -> float:
    low, high = quantity.intervals["0.95"] or (0.0, np.inf)
    return (high - low) / 2


def _residuals(pair: _Axis, rate_hz: float) -> Residuals:
    """Means of blocks of either recording, less the recording's mean."""
    times, values, groups = [], [], []
    for name, channel in zip(("up", "down"), pair, strict=True):
        size = max(1, -(-len(channel.samples) // _BLOCKS))
        usable = np.zeros(len(channel.samples), bool)
        for start, stop in channel.stretches:
            usable[start:stop] = True
        for start in range(0, len(usable), size):
            block = channel.samples[start : start + size][usable[start : start + size]]
            if 2 * len(block) >= size:
                times.append((start + size / 2) / rate_hz)
                values.append((block.mean() - mean(channel)) / channel.factor)
                groups.append(name)
    return Residuals(
        np.array(times), "time in the recording [s]", np.array(values), pair.up.unit, tuple(groups)
    )
