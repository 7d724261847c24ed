"""Units as they are set in print."""

_RAISED = str.maketrans(
    "-0123456789",
    "\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT ZERO}\N{SUPERSCRIPT ONE}\N{SUPERSCRIPT TWO}"
    "\N{SUPERSCRIPT THREE}\N{SUPERSCRIPT FOUR}\N{SUPERSCRIPT FIVE}\N{SUPERSCRIPT SIX}"
    "\N{SUPERSCRIPT SEVEN}\N{SUPERSCRIPT EIGHT}\N{SUPERSCRIPT NINE}",
)


def squared_per_hertz(unit: str) -> str:
    """The unit of a power spectral density, `(deg/s)^2/Hz` for a channel in deg/s."""
    if not unit:
        return "1/Hz"
    return f"{unit}^2/Hz" if unit.isalnum() else f"({unit})^2/Hz"


def typeset(unit: str) -> str:
    """A unit as it is set in print: roots, powers and micro as signs, `deg/\N{SQUARE ROOT}h`."""
    for root in ("Hz", "s", "h"):
        unit = unit.replace(f"sqrt({root})", f"\N{SQUARE ROOT}{root}")
    unit = unit.replace("^2", "\N{SUPERSCRIPT TWO}").replace("^3", "\N{SUPERSCRIPT THREE}")
    return f"\N{MICRO SIGN}{unit[1:]}" if unit.startswith("ug") else unit


def in_brackets(power: int, unit: str) -> str:
    """What stands behind the name along an axes: " [10^-3 deg/s]", or "" where there is nothing."""
    ten = f"10{str(power).translate(_RAISED)}" if power else ""
    parts = " ".join(part for part in (ten, typeset(unit)) if part)
    return f" [{parts}]" if parts else ""
