"""A fit in the form of a filter or a simulator: one function a format."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from ..formatting import printable
from ._doubts import no_white_noise
from ._errors import ExportError
from ._exported import Exported
from ._held import at_low_frequency
from ._imu_error_model import imu_error_model
from ._kalibr import kalibr
from ._kalman import kalman
from ._matlab import matlab
from ._options import Options
from ._read import FitFile, read_fit
from ._ros import ros
from ._yaml import coefficients_yaml

#: Writers by format. A writer takes the channels and the options, and touches no file.
FORMATS: dict[str, Callable[[FitFile, Options], Exported]] = {
    "kalman": kalman,
    "kalibr": kalibr,
    "ros": ros,
    "matlab": matlab,
    "yaml": coefficients_yaml,
    "imu-error-model": imu_error_model,
}
_USED: dict[str, set[str]] = {
    "kalman": {"band_s", "walk"},
    "kalibr": {"axes", "walk", "rostopic"},
    "ros": {"axes", "walk"},
    "matlab": {"axes", "band_s"},
    "yaml": set(),
    "imu-error-model": {"axes", "band_s", "walk"},
}
# Coefficients as they were found, which are of use whatever was resolved.
_AS_FOUND = {"yaml"}


def export(
    fit: str | Path,
    target: str,
    options: Options | None = None,
    *,
    channels: list[str] | None = None,
) -> Exported:
    """A fit's or explain's JSON file as the text of another program's file.

    **Arguments:**

    - `fit`: path of a JSON that `allanfit fit --json` or `allanfit explain --json` wrote; of the
      latter, the coefficients beside its effects.
    - `target`: kalman, kalibr, ros, matlab, yaml or imu-error-model.
    - `options`: choices, see `Options`.
    - `channels`: those to export; all unless given.

    **Returns:** the text, and warnings, one sentence each.

    **Raises:** `ExportError` for an unknown format, a file that is no fit, a white noise that is
    not resolved, and what the format cannot express.
    """
    writer = FORMATS.get(target)
    if writer is None:
        raise ExportError(f"The format {target!r} is not known; known are {', '.join(FORMATS)}.")
    options = options or Options()
    found = read_fit(fit, channels)
    held: list[str] = []
    if target not in _AS_FOUND:
        _refuse_without_white_noise(found)
        found, held = at_low_frequency(found)
    exported = writer(found, options)
    warnings = [*exported.warnings, *held, *_without_effect(target, options)]
    return Exported(exported.text, [printable(each) for each in warnings])


def _without_effect(target: str, options: Options) -> list[str]:
    """A sentence for each option that the format has no use for, so that nobody counts on it."""
    return [
        f"--{choice.name.removesuffix('_s')} has no effect on the format {target}."
        for choice in fields(Options)
        if getattr(options, choice.name) != choice.default and choice.name not in _USED[target]
    ]


def _refuse_without_white_noise(fit: FitFile) -> None:
    for channel in fit.channels:
        term = channel.coefficients["N"]
        if not (term.resolved and term.value > 0):
            raise ExportError(no_white_noise(fit, channel))
