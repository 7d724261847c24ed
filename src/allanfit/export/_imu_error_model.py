"""A profile for the simulator imu-error-model (PyPI, checked against 0.1.3).

It is the configuration alone, without the envelope of names and sources, which a fit has not. The
simulator makes flicker of relaxations of equal variance, evenly spaced in the logarithm of their
times, and takes the Allan deviation in the middle of the band as their size.
"""

from typing import NamedTuple

import numpy as np

from ._errors import ExportError
from ._exported import Exported
from ._gauss_markov import ALLOWED_ERROR, allan_variance
from ._options import Options
from ._parts import default_band, flicker_variance
from ._read import FitFile
from ._sensor import KINDS, Sensor, sensors
from ._yaml_text import comment, rounded

_MOST_COMPONENTS = 32
# How far relaxation times reach beyond the band, tried in turn.
_REACHES = np.geomspace(0.5, 30, 60)


def imu_error_model(fit: FitFile, options: Options) -> Exported:
    """The profile, YAML.

    **Raises:** `ExportError` without gyro and accelerometer, or with different rates.
    """
    found, notes = sensors(fit, "imu-error-model")
    rate_hz = next(iter(found.values())).rate_hz
    lines = [
        *comment(f"imu-error-model profile from {fit.recording}, written by allanfit."),
        *comment(f"SI units. Read it with load_profile, sample it every {1 / rate_hz:g} s."),
        *comment("Q and R are not in it: quantization_step rounds samples, which Q is not."),
        *(line for note in notes for line in comment(note)),
    ]
    for kind, sensor in found.items():
        lines += ["", f"{KINDS[kind]}:", *_sensor_lines(sensor, options)]
    return Exported("\n".join(lines) + "\n", notes)


def _sensor_lines(sensor: Sensor, options: Options) -> list[str]:
    lines = []
    density, walk = sensor.one("N", options), sensor.walk(options)
    assert density is not None  # exports refuse a fit without N
    lines += [
        *comment(density.how, "  "),
        f"  white_noise_density: {rounded(density.value)}  # {density.unit}",
    ]
    if walk is not None:
        lines += [
            *comment(f"{walk.how}; a random walk, since there is no bias_correlation_time", "  "),
            f"  bias_std: {rounded(walk.value)}  # {walk.unit}",
        ]
    bias = sensor.one("B", options)
    # A walk that covers B takes its place.
    if bias is not None and not isinstance(options.walk, float):
        band_s = options.band_s or default_band(sensor.axes[0])
        flicker = _equal_relaxations(sensor.axes[0].dt, band_s, sensor.axes[0].sampling)
        lines += [
            *comment(
                f"{bias.how}: B = {bias.value:.6g} {bias.unit}, Allan deviation right within "
                f"{flicker.worst_error:.1%} from {band_s[0]:.4g} s to {band_s[1]:.4g} s",
                "  ",
            ),
            f"  flicker_bias_std: {rounded(flicker.deviation * bias.value)}  # {bias.unit}",
            f"  flicker_min_correlation_time: {rounded(flicker.shortest_s)}  # s",
            f"  flicker_max_correlation_time: {rounded(flicker.longest_s)}  # s",
            f"  flicker_components: {flicker.components}",
        ]
    return lines


class _Flicker(NamedTuple):
    deviation: float
    shortest_s: float
    longest_s: float
    components: int
    worst_error: float


def _equal_relaxations(dt: float, band_s: tuple[float, float], sampling: str) -> _Flicker:
    """The fewest equal relaxations that keep to flicker of B = 1 within the band."""
    low, high = band_s
    sizes = np.geomspace(low, high, 100) / dt
    wanted = flicker_variance(dt, sampling)(sizes)
    for components in range(2, _MOST_COMPONENTS + 1):
        tried = [_trial(sizes, dt, wanted, band_s, components, reach) for reach in _REACHES]
        best = min(tried, key=lambda each: each.worst_error)
        if best.worst_error <= ALLOWED_ERROR:
            return best
    raise ExportError(
        f"imu-error-model cannot make flicker from {low:g} s to {high:g} s; give a narrower band."
    )


def _trial(
    sizes: np.ndarray,
    dt: float,
    wanted: np.ndarray,
    band_s: tuple[float, float],
    components: int,
    reach: float,
) -> _Flicker:
    # A relaxation peaks at 1.89 times its time.
    times = np.geomspace(band_s[0] / 1.89 / reach, band_s[1] / 1.89 * reach, components)
    error = np.log(allan_variance(sizes, dt, times).sum(axis=1) / wanted) / 2
    # Equal errors above and below make the largest the smallest.
    middle = (error.max() + error.min()) / 2
    centre = np.sqrt(times[0] * times[-1])
    deviation = np.sqrt(_averaged_allan_variance(centre / times).sum()) * np.exp(-middle)
    worst = np.expm1((error.max() - error.min()) / 2)
    return _Flicker(float(deviation), float(times[0]), float(times[-1]), components, float(worst))


def _averaged_allan_variance(ratio: np.ndarray) -> np.ndarray:
    """Allan variance of a continuous relaxation of variance 1, at `ratio` of its time.

    2/r - (3 - 4 exp(-r) + exp(-2 r))/r^2: what the simulator scales its flicker by.
    """
    return 2 / ratio - (3 - 4 * np.exp(-ratio) + np.exp(-2 * ratio)) / ratio**2
