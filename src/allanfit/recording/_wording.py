"""Numbers in the sentences of findings."""


def percent(fraction: float) -> str:
    """A fraction as a percentage of two digits, such as `63 %`."""
    if 0.995 <= fraction < 1:
        return "over 99 %"
    rounded = 100 * float(f"{fraction:.2g}")
    return f"{rounded:.3g} %"
