"""Units as they are set in print."""


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
