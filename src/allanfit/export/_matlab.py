"""A MATLAB script that makes an imuSensor with the noise of a fit.

With single-sided noise, imuSensor draws samples of deviation NoiseDensity sqrt(rate) and steps of
deviation RandomWalk/sqrt(rate): these are N and K. Its flicker is white noise of deviation
BiasInstability through the filter of fractalcoef, which is B, not 0.664 B.
"""

import math
import textwrap

from ..formatting import printable
from ._exported import Exported
from ._options import Options
from ._parts import default_band
from ._read import FitFile
from ._sensor import Sensor, sensors

_MOST_POLES = 2000
# The Allan deviation of the filter's flicker stays within 11 % of 0.664 B up to this many samples
# a pole, and falls beyond.
_SAMPLES_A_POLE = 6
_CLASS = {"gyro": "gyroparams", "accelerometer": "accelparams"}
_VARIABLE = {"gyro": "gyroscope", "accelerometer": "accelerometer"}
_PROPERTY = {"gyro": "Gyroscope", "accelerometer": "Accelerometer"}


def matlab(fit: FitFile, options: Options) -> Exported:
    """The script.

    **Raises:** `ExportError` without gyro and accelerometer, or with different rates.
    """
    found, notes = sensors(fit, "imuSensor")
    first = next(iter(found.values()))
    flat_to = (options.band_s or default_band(first.axes[0]))[1]
    needed = math.ceil(flat_to * first.rate_hz / _SAMPLES_A_POLE)
    poles = min(max(needed, 2), _MOST_POLES)
    reach = poles * _SAMPLES_A_POLE / first.rate_hz
    notes = [*notes, *_left_out(found)]
    if needed > _MOST_POLES:
        notes.append(
            f"Flicker of {poles} poles holds to {reach:.3g} s only; set numPoles to "
            f"{needed} for {flat_to:.3g} s, if the time it takes is no matter."
        )
    lines = [
        *_comment(f"IMU noise from {fit.recording}, written by allanfit. SI units."),
        *_comment(
            "Needs R2023b or newer. Older releases know double-sided noise only: leave out "
            "NoiseType and the last line of each sensor, and give sqrt(2) times NoiseDensity and "
            "RandomWalk/sqrt(2)."
        ),
        *(line for note in notes for line in _comment(note)),
        "",
        f"sampleRate = {first.rate_hz!r}; % Hz",
        f"numPoles = {poles}; % flicker within 11 % up to {reach:.3g} s",
    ]
    for kind, sensor in found.items():
        lines += ["", *_sensor_lines(kind, sensor, options)]
    arguments = "".join(f", ...\n    '{_PROPERTY[kind]}', {_VARIABLE[kind]}" for kind in found)
    lines += ["", f"imu = imuSensor('accel-gyro', 'SampleRate', sampleRate{arguments});"]
    return Exported("\n".join(lines) + "\n", notes)


def _sensor_lines(kind: str, sensor: Sensor, options: Options) -> list[str]:
    unit = sensor.axes[0].si_unit
    values = {symbol: _values(sensor, symbol, options) for symbol in "NBK"}
    return [
        *_comment(f"{_VARIABLE[kind]}: {_axes(sensor, options)}"),
        f"{_VARIABLE[kind]} = {_CLASS[kind]}( ...",
        "    'NoiseType', 'single-sided', ...",
        f"    'NoiseDensity', {values['N']}, ... % ({unit})/sqrt(Hz): N",
        f"    'BiasInstability', {values['B']}, ... % {unit}: B, whose Allan deviation is 0.664 B",
        f"    'RandomWalk', {values['K']}, ... % ({unit})*sqrt(Hz), which is {unit}/sqrt(s): K",
        "    'BiasInstabilityCoefficients', fractalcoef(numPoles, 1));",
    ]


def _axes(sensor: Sensor, options: Options) -> str:
    if len(sensor.axes) == 3:
        return f"{sensor.names}, in this order"
    which = "the worst" if options.axes == "worst" else "the root of the mean square"
    return f"{which} of {sensor.names}, for all axes"


def _values(sensor: Sensor, symbol: str, options: Options) -> str:
    if len(sensor.axes) == 3:
        return f"[{' '.join(f'{value:.6g}' for value in sensor.each(symbol))}]"
    number = sensor.one(symbol, options)
    return "0" if number is None else f"{number.value:.6g}"


def _left_out(found: dict[str, Sensor]) -> list[str]:
    notes = []
    for sensor in found.values():
        for symbol in "BK":
            names = [axis.name for axis in sensor.axes if not axis.coefficients[symbol].resolved]
            # Unless each of three axes has its own value, one that is resolved serves for all.
            zero = len(sensor.axes) in (3, len(names))
            instead = "set to zero" if zero else "taken to be that of the others"
            if names:
                notes.append(f"{symbol} of {', '.join(names)} is not resolved, and {instead}.")
        for symbol in "QR":
            names = [axis.name for axis in sensor.axes if axis.coefficients[symbol].resolved]
            if names:
                notes.append(f"imuSensor has no {symbol}, which {', '.join(names)} has.")
    return notes


def _comment(sentence: str) -> list[str]:
    return textwrap.wrap(printable(sentence), 96, initial_indent="% ", subsequent_indent="% ")
