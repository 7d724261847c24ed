"""How rates and units are called in files that have no rule for it."""

import re

_RATE = re.compile(
    r"f_?s(_?hz)?|odr(_?hz)?|(sampl(e|ing)_?)?(rate|freq(uency)?)(_?hz)?", re.IGNORECASE
)


def is_rate(name: str) -> bool:
    """Whether a single number of this name is a sampling rate in Hz, as `Fs` or `rate_hz`."""
    return _RATE.fullmatch(name) is not None


def is_unit(name: str) -> bool:
    """Whether a text of this name is a unit, or several."""
    return name.lower() in ("unit", "units")
