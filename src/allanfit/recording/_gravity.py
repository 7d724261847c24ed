"""Gravity: what accelerometers at rest feel and gyros do not."""

import re
from collections.abc import Sequence

import numpy as np

from ._recording import Channel

_GRAVITY = 9.80665
_UNITS = {"m/s^2": 1.0, "g": _GRAVITY, "mg": 1e-3 * _GRAVITY}
# What gravity in another unit is taken for: of accelerometers, and of gyros, which it is not of.
_IN_UNIT, _IN_GYROS = 0.05, 0.03
# Scale factors and biases of the worst accelerometers are off by half of this together.
_OFF = 0.2
# What a filter leaves that takes gravity out [m/s^2].
_LEFT = 0.5
# As many samples are averaged, so that their noise is no acceleration.
_WINDOW = 64


def about_gravity(channels: Sequence[Channel]) -> tuple[str, ...]:
    """Findings on gravity in gyros, or what accelerometers feel that is none or in another unit."""
    axes = [channel for channel in channels if channel.kind == "accelerometer"]
    findings = about_swapped(channels) or (_about_unit(axes) if len(axes) == 3 else ())
    return findings or tuple(each for triad in _triads(axes) for each in _about_none(triad))


def about_swapped(channels: Sequence[Channel]) -> tuple[str, ...]:
    """A finding when three gyros read gravity, and as many accelerometers do not."""
    gyros = [channel for channel in channels if channel.kind == "gyro"]
    if len(gyros) != 3 or len({channel.unit for channel in gyros}) != 1:
        return ()
    read = _felt(gyros)
    size = read / gyros[0].factor
    unit = next((u for u, si in _UNITS.items() if abs(size * si / _GRAVITY - 1) < _IN_GYROS), None)
    others = [channel for channel in channels if channel.kind == "accelerometer"]
    weightless = len(others) == 3 and not _is_gravity(_felt(others))
    if unit is None or not (weightless or read > 0.5):
        return ()
    return (
        f"The three gyros read {size:.4g} {gyros[0].unit} in all, which would be gravity in "
        f"{unit}: are the columns of gyros and accelerometers swapped?",
    )


def _about_unit(axes: Sequence[Channel]) -> tuple[str, ...]:
    """A finding when three accelerometers feel gravity, but in another unit than the stated."""
    felt = _felt(axes) / axes[0].factor
    for name, factor in _UNITS.items():
        if factor != axes[0].factor and abs(felt * factor / _GRAVITY - 1) < _IN_UNIT:
            return (
                f"The three accelerometers feel {felt:.4g} {axes[0].unit} in all, which would be "
                f"gravity in {name}: if so, give --unit {name}.",
            )
    return ()


def _about_none(axes: Sequence[Channel]) -> tuple[str, ...]:
    """A finding when the three axes of an accelerometer feel nothing, or what is no gravity."""
    felt, factor, unit = _felt(axes), axes[0].factor, axes[0].unit
    if _is_gravity(felt):
        return ()
    first, second, third = (axis.name for axis in axes)
    what = f"{first}, {second} and {third} feel {felt / factor:.3g} {unit} in all"
    if felt < _LEFT:
        return (
            f"{what}: gravity was taken out, as of a linear acceleration or in a simulation; what "
            "takes it out of a measurement may change its noise too.",
        )
    return (
        f"{what}, and at rest they would feel gravity, {_GRAVITY / factor:.3g} {unit}: is the unit "
        "or a scale factor another, or a column not what its name says?",
    )


def _is_gravity(felt: float) -> bool:
    """Whether it may be; so it may where nothing is known."""
    return np.isnan(felt) or abs(felt / _GRAVITY - 1) < _OFF


def _triads(axes: Sequence[Channel]) -> list[list[Channel]]:
    """Those in one unit whose names differ in x, y and z alone."""
    found: dict[tuple[str, str], dict[str, Channel]] = {}
    for axis in axes:
        # The last, as in `xyz_accel_x` and `ax_mps2`.
        name = re.fullmatch(r"(.*)([xyz])([^xyz]*)", axis.name, re.IGNORECASE | re.DOTALL)
        if name is not None:
            found.setdefault((f"{name[1]}.{name[3]}", axis.unit), {})[name[2].lower()] = axis
    return [list(triad.values()) for triad in found.values() if len(triad) == 3]


def _felt(axes: Sequence[Channel]) -> float:
    """Length of the vector of three axes at most times, however they turn in between, in SI.

    NaN where the axes have no samples in common.
    """
    good = np.ones(axes[0].samples.size, bool)
    for axis in axes:
        edges = np.array([(0, 0), *axis.stretches, (good.size, good.size)]).ravel()[1:-1]
        for stop, start in edges.reshape(-1, 2):
            good[stop:start] = False
    length = min(_WINDOW, int(good.sum()))
    if length == 0:
        return np.nan
    means = []
    for axis in axes:
        samples = axis.samples if good.all() else axis.samples[good]
        means.append(samples[: samples.size // length * length].reshape(-1, length).mean(axis=1))
    return float(np.median(np.linalg.norm(means, axis=0)))
