"""Kalibr's imu.yaml: white noise and random walk of one gyroscope and one accelerometer.

Keys, units and checks are those of `kalibr_common/ConfigReader.py`: all numbers above zero, in SI
and of continuous time; Kalibr divides the densities by the square root of the sampling interval.
"""

from ._exported import Exported
from ._options import Options
from ._read import FitFile
from ._sensor import KINDS, Sensor, sensors
from ._yaml_text import comment, number, rounded, text

# Kalibr's names of u/sqrt(s).
_UNIT = {"gyro": "rad/s^2/sqrt(Hz)", "accelerometer": "m/s^3/sqrt(Hz)"}


def kalibr(fit: FitFile, options: Options) -> Exported:
    """The file, with a comment on every number.

    **Raises:** `ExportError` without gyro and accelerometer, with different rates, or where no
    random walk is resolved and none was chosen.
    """
    found, notes = sensors(fit, "Kalibr")
    walks = {kind: each.required_walk(options, "Kalibr") for kind, each in found.items()}
    first = next(iter(found.values()))
    lines = [
        *comment(f"Kalibr imu.yaml from {fit.recording}, written by allanfit."),
        *comment("SI units. Continuous time: nothing here depends on the rate."),
        *(line for note in notes for line in comment(note)),
        "",
        f"rostopic: {text(options.rostopic)}",
        f"update_rate: {number(first.rate_hz)}  # Hz",
    ]
    for kind, sensor in found.items():
        density, walk = sensor.one("N", options), walks[kind]
        assert density is not None  # exports refuse a fit without N
        lines += [
            "",
            *comment(f"{KINDS[kind]}: {sensor.names}"),
            *comment(density.how),
            f"{KINDS[kind]}_noise_density: {rounded(density.value)}  # {density.unit}",
            *comment(walk.how),
            f"{KINDS[kind]}_random_walk: {rounded(walk.value)}  # {_UNIT[kind]} = {walk.unit}",
            *_flicker_comment(sensor, options),
        ]
    return Exported("\n".join(lines) + "\n", notes)


def _flicker_comment(sensor: Sensor, options: Options) -> list[str]:
    bias = sensor.one("B", options)
    if bias is None or isinstance(options.walk, float):
        return []
    return comment(
        f"B = {bias.value:.4g} {bias.unit} ({bias.how}) is not in this walk: Kalibr has no "
        "flicker. --walk SECONDS makes a walk that drifts as far as B and K together in that time."
    )
