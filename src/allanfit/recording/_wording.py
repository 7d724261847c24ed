"""Numbers and names in the sentences of findings."""

from collections.abc import Mapping, Sequence

# So many names are told one by one.
_TOLD = 3


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


def left_out(reasons: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """A sentence for each reason why channels are left out, however many they are."""
    said = []
    for why, names in reasons.items():
        if len(names) == 1:
            said.append(f"The channel {names[0]} is left out: {why}.")
        else:
            more = f" and {len(names) - _TOLD} more" if len(names) > _TOLD else ""
            told = ", ".join(names[:_TOLD]) if more else " and ".join(names)
            said.append(f"The channels {told}{more} are left out, each since {why}.")
    return tuple(said)
