"""How rates and units are called in files that have no rule for it."""

import json
import re

import numpy as np

from ._recording import RecordingError

_RATE = re.compile(
    r"f_?s(_?hz)?|odr(_?hz)?|(sampl(e|ing)_?)?(rate|freq(uency)?)(_?hz)?", re.IGNORECASE
)

UNITS_EXAMPLE = '{"gyro_x": "deg/s"}'


def is_rate(name: str) -> bool:
    """Whether a single number of this name is a sampling rate in Hz, as `Fs` or `rate_hz`."""
    return _RATE.fullmatch(name) is not None


def is_unit(name: str) -> bool:
    """Whether a text of this name is a unit, or several."""
    return name.lower() in ("unit", "units")


def units_by_channel(file: str, text: str | np.ndarray | None) -> dict[str, str]:
    """The unit of each channel from a JSON object, none without one.

    **Raises** `RecordingError` when the text, or array of one text, is no such object.
    """
    if text is None:
        return {}
    try:
        units = json.loads(text if isinstance(text, str) else text.item())
    except (ValueError, TypeError, RecursionError):
        units = None
    if not isinstance(units, dict) or not all(isinstance(unit, str) for unit in units.values()):
        raise RecordingError(
            f"{file}: `units` must be a JSON string that gives each channel a unit, such as "
            f"'{UNITS_EXAMPLE}'."
        )
    return units
