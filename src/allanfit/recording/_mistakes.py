"""The likeliest mistakes in a recording that can be read, told where the evidence is strong.

Each limit lies where no sensor on the market comes near: silence proves nothing.
"""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from ._checks import code_width, usable
from ._gravity import about_swapped
from ._recording import Channel
from ._wording import quantity

_RADIANS = math.pi / 180
# Slower than any inertial sensor is read, and faster than any gives samples [Hz].
_SLOWEST, _FASTEST = 0.2, 5e4
# Noise of the worst gyros is a tenth of this [rad/s/sqrt(Hz)]; of the best a thousandth of a
# thousandth.
_LOUDEST = 3e-3
# The bias of the worst gyros is a third of this [rad/s].
_LARGEST_BIAS = 1.0
# Code widths of gyros [deg/s]: a range over 2^15 codes, or the makers' own numbers. Those that
# rounding to decimals makes as well are left out.
_CODES = tuple(
    base * 2**power
    for base, powers in ((125 / 32768, range(5)), (1 / 131, range(4)), (4.375e-3, range(6)))
    for power in powers
)
# How far still sensors may wander within a recording: a warm-up is a tenth of it [SI].
_WANDER = {"gyro": 5 * _RADIANS, "accelerometer": 0.5}
_WINDOW_S = 1.0
_FEWEST = 64


def about_mistakes(channels: Sequence[Channel], rate_hz: float) -> tuple[str, ...]:
    """Findings on channels that are not what they are said to be, or not at rest."""
    swapped = about_swapped(channels)
    moved = _about_motion(channels, rate_hz)
    return (
        *_about_rate(rate_hz),
        *(
            finding
            for channel in channels
            for finding in (
                _about_counts(channel)
                # The unit of gyros that are accelerometers is not the mistake.
                or (() if swapped else _about_angle_unit(channel, rate_hz))
                # The changes of what moved grow like those of a sum.
                or (() if moved else _about_sums(channel, rate_hz))
            )
        ),
        *moved,
    )


def _about_rate(rate_hz: float) -> tuple[str, ...]:
    if rate_hz < _SLOWEST:
        return (
            f"The rate is {rate_hz:.4g} Hz, a sample every {1 / rate_hz:.4g} s, and inertial "
            "sensors are read far more often: is it in kHz, is it the interval in s, or are time "
            "stamps in ms taken for s?",
        )
    if rate_hz > _FASTEST:
        return (
            f"The rate is {rate_hz:.4g} Hz, more than inertial sensors give: is it in mHz, or are "
            "time stamps in s or ms taken for something shorter?",
        )
    return ()


def _about_counts(channel: Channel) -> tuple[str, ...]:
    """Whole numbers in a unit of which sensors give small parts."""
    least = {"gyro": _RADIANS, "accelerometer": 1.0}.get(channel.kind, math.inf)
    if channel.factor < 0.999 * least:
        return ()
    values = usable(channel.samples, channel.stretches) / channel.factor
    if np.abs(values - np.round(values)).max() > 1e-9 * np.abs(values).max():
        return ()
    return (
        f"All samples of {channel.name} are whole numbers of {channel.unit}, as raw counts are: if "
        f"so, give the scale factor of the data sheet before the unit, as in --unit '1/131 "
        f"{channel.unit}', or --unit counts.",
    )


def _about_angle_unit(channel: Channel, rate_hz: float) -> tuple[str, ...]:
    """Degrees called radians, told by noise, bias or code width, or the reverse, by code width."""
    if channel.kind != "gyro":
        return ()
    values = usable(channel.samples, channel.stretches)
    radians = "rad" in channel.unit.lower()
    other, ratio = ("deg/s", _RADIANS) if radians else ("rad/s", 1 / _RADIANS)
    advice = f"if the samples are in {other}, give --unit {other}."
    width = code_width(values[:20_000]) / _RADIANS
    if width and not _is_code(width) and _is_code(width * ratio) and _on_grid(values, width):
        return (
            f"The codes of {channel.name} are {quantity(width * _RADIANS / channel.factor, '')} "
            f"{channel.unit} apart, which of common gyros is the width in {other}: {advice}",
        )
    noise = 1.4826 * float(np.median(np.abs(np.diff(values)))) / math.sqrt(2 * rate_hz)
    bias = abs(float(np.median(values)))
    if radians and noise > _LOUDEST:
        size = quantity(noise / channel.factor, f"{channel.unit}/sqrt(Hz)")
        return (
            f"The noise of {channel.name}, about {size}, is ten times that of the worst gyros: "
            f"{advice}",
        )
    if bias > _LARGEST_BIAS:
        return (
            f"{channel.name} reads {quantity(bias / channel.factor, channel.unit)} on average, "
            "which no gyro does at rest: is the unit another, the column that of another sensor, "
            "or was it turning?",
        )
    return ()


def _is_code(width: float) -> bool:
    return any(abs(width / known - 1) < 5e-4 for known in _CODES)


def _on_grid(values: Float64[np.ndarray, " usable"], width: float) -> bool:
    """Whether the steps between samples are whole codes."""
    codes = np.diff(values[:20_000]) / (width * _RADIANS)
    return float(np.quantile(np.abs(codes - np.round(codes)), 0.99)) < 0.05


def _about_sums(channel: Channel, rate_hz: float) -> tuple[str, ...]:
    """Angles called rates, or velocities called accelerations.

    The mean squared change of a sum of white noise grows with the time between two samples, from
    the first sample on. That of a sensor stays what its noise makes it, until it drifts; where a
    filter makes it grow it ends at the filter's time.
    """
    start, stop = max(channel.stretches, key=lambda pair: pair[1] - pair[0])
    values = channel.samples[start:stop]
    lags = [2**k for k in range(20) if 2**k <= values.size // 32]
    if len(lags) < 6 or np.mean(np.diff(values) == 0) > 0.1:
        return ()
    change = np.array([np.mean(np.square(values[lag:] - values[:-lag])) for lag in lags])
    if (change[1:] < 1.4 * change[:-1]).any() or change[-1] < lags[-1] ** 0.8 * change[0]:
        return ()
    what = {"gyro": "an angle", "accelerometer": "a velocity"}.get(
        channel.kind, "an angle or a velocity"
    )
    return (
        f"The changes of {channel.name} grow with the time between two samples from the first "
        f"sample to {lags[-1] / rate_hz:.3g} s, as those of {what} do: if it is one, give its "
        "differences divided by the sampling interval.",
    )


def _place(stretches: Sequence[tuple[int, int]], usable: int) -> int:
    """The index in a channel of one of its usable samples."""
    for start, stop in stretches:
        if usable < stop - start:
            return start + usable
        usable -= stop - start
    return stretches[-1][1]


def _about_motion(channels: Sequence[Channel], rate_hz: float) -> tuple[str, ...]:
    """The channel, and the second, in which a sensor was turned or shaken most."""
    worst, told = 1.0, ()
    for channel in channels:
        # What another sensor measures may well change by itself.
        if channel.kind not in _WANDER:
            continue
        values = usable(channel.samples, channel.stretches)
        length = max(_FEWEST, round(_WINDOW_S * rate_hz))
        windows = values[: values.size // length * length].reshape(-1, length)
        if len(windows) < 4:
            continue
        # Medians, so that a damaged packet is no motion.
        level = np.median(windows, axis=1)
        spread = np.median(np.abs(windows - level[:, None]), axis=1)
        away = np.abs(level - np.median(level))
        usual = float(np.median(spread))
        limit = max(_WANDER[channel.kind], 20 * float(np.median(away)))
        for excess, how in (
            (away / limit, "reads something else"),
            (spread / (10 * usual or math.inf), "is far noisier"),
        ):
            if excess.max() > worst:
                worst = float(excess.max())
                at = _place(channel.stretches, int(np.argmax(excess)) * length) / rate_hz
                told = (
                    f"The sensor was not at rest all the time: {channel.name} {how} "
                    f"{at:.4g} s after the start than in most of the recording: give a part in "
                    "which nothing touched it.",
                )
    return told
