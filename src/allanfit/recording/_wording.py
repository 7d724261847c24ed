"""Numbers in the sentences of findings."""


def count(number: int, noun: str) -> str:
    """A number of things, such as `1 sample` or `12 samples`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def quantity(value: float, unit: str) -> str:
    """A value with its unit, such as `0.05 deg/s`, or alone when the unit is not known."""
    return f"{value:.3g} {unit}".rstrip()


def percent(fraction: float) -> str:
    """A fraction as a percentage of two digits, such as `63 %`."""
    if 0.995 <= fraction < 1:
        return "over 99 %"
    rounded = 100 * float(f"{fraction:.2g}")
    return f"{rounded:.3g} %"
