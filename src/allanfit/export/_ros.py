"""Parameters for ROS: covariances of sensor_msgs/Imu, and of two estimators that read its topics.

Each has a convention of its own. VINS-Mono and VINS-Fusion take deviations of one sample: their
midpoint rule gives a step of the velocity acc_n^2 dt^2/2 and a step of the bias acc_w^2 dt^2,
where the sensor has N^2 dt and K^2 dt. GTSAM takes covariances of continuous time.
"""

import math

from ._exported import Exported
from ._options import Options
from ._read import FitFile
from ._sensor import Number, Sensor, sensors
from ._yaml_text import comment, number, rounded

_MESSAGE = {"gyro": "angular_velocity", "accelerometer": "linear_acceleration"}
_VINS = {"gyro": "gyr", "accelerometer": "acc"}
_GTSAM = {
    "gyro": ("gyroscopeCovariance", "biasOmegaCovariance"),
    "accelerometer": ("accelerometerCovariance", "biasAccCovariance"),
}


def ros(fit: FitFile, options: Options) -> Exported:
    """The file, a section for each reader.

    **Raises:** `ExportError` without gyro and accelerometer, with different rates, or where no
    random walk is resolved and none was chosen.
    """
    what = "a ROS estimator"
    found, notes = sensors(fit, what)
    walks = {kind: each.required_walk(options, what) for kind, each in found.items()}
    rate_hz = next(iter(found.values())).rate_hz
    lines = [
        *comment(f"IMU noise from {fit.recording}, written by allanfit. SI units."),
        *(line for note in notes for line in comment(note)),
        *comment("Q and B are in no number below unless its comment says so."),
        "",
        f"imu_rate_hz: {number(rate_hz)}",
        *_messages(found, options),
        *_vins(found, walks, options, rate_hz),
        *_gtsam(found, walks, options),
    ]
    return Exported("\n".join(lines) + "\n", notes)


def _messages(found: dict[str, Sensor], options: Options) -> list[str]:
    lines = [
        "",
        *comment(
            "sensor_msgs/Imu, row by row; robot_localization reads them there. Discrete time: "
            "variance of one sample, N^2 times the rate. Three axes are taken in the order of the "
            "file."
        ),
        "sensor_msgs_imu:",
    ]
    for kind, sensor in found.items():
        density = _density(sensor, options)
        each = sensor.each("N") if len(sensor.axes) == 3 else [density.value] * 3
        diagonal = [rounded(value**2 * sensor.rate_hz) for value in each]
        flat = [
            diagonal[row] if row == column else "0.0" for row in range(3) for column in range(3)
        ]
        unit = sensor.axes[0].si_unit
        lines.append(f"  {_MESSAGE[kind]}_covariance: [{', '.join(flat)}]  # ({unit})^2")
    return lines


def _vins(
    found: dict[str, Sensor], walks: dict[str, Number], options: Options, rate_hz: float
) -> list[str]:
    lines = [
        "",
        *comment(
            f"VINS-Mono and VINS-Fusion. Discrete time, for samples at {rate_hz:g} Hz: n is "
            "sqrt(2 rate) N, w is sqrt(rate) times the walk, since their code multiplies both by "
            "the time step."
        ),
        "vins:",
    ]
    for kind, sensor in found.items():
        density, walk = _density(sensor, options), walks[kind]
        unit, name = sensor.axes[0].si_unit, _VINS[kind]
        lines += [
            *comment(density.how, "  "),
            f"  {name}_n: {rounded(density.value * math.sqrt(2 * rate_hz))}  # {unit}",
            *comment(walk.how, "  "),
            f"  {name}_w: {rounded(walk.value * math.sqrt(rate_hz))}  # {unit}/s",
        ]
    return lines


def _gtsam(found: dict[str, Sensor], walks: dict[str, Number], options: Options) -> list[str]:
    lines = [
        "",
        *comment(
            "GTSAM PreintegrationCombinedParams. Continuous time: two-sided densities N^2 and the "
            "square of the walk, each times the unit matrix."
        ),
        "gtsam:",
    ]
    for kind, sensor in found.items():
        density, walk = _density(sensor, options), walks[kind]
        white, bias = _GTSAM[kind]
        lines += [
            f"  {white}: {rounded(density.value**2)}  # ({density.unit})^2",
            f"  {bias}: {rounded(walk.value**2)}  # ({walk.unit})^2",
        ]
    return lines


def _density(sensor: Sensor, options: Options) -> Number:
    density = sensor.one("N", options)
    assert density is not None  # exports refuse a fit without N
    return density
