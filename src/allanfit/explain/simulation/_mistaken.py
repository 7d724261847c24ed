"""What a coefficient of a simulation was mistaken for, if the factor by which it is off tells."""

import numpy as np

# One of these times as large, within such a part, is a number in another unit: of time, or of what
# such a channel measures.
_OF_TIME = {60.0: ("1/sqrt(h)", "1/sqrt(s)"), 3600.0: ("1/h", "1/s")}
_OF_KIND = {"gyro": {180 / np.pi: ("deg", "rad")}, "accelerometer": {9.80665: ("m/s^2", "g")}}
_ALIKE = 0.03


def as_if(symbol: str, kind: str, factor: float, own_rate_hz: float, their_rate_hz: float) -> str:
    """What it seems to be by mistake, after a comma; "" where the factor tells nothing.

    The coefficient of that `symbol`, of a channel of that `kind`, is so many times the recording's,
    and the two have such rates.
    Samples scatter by N sqrt(rate), and each adds K/sqrt(rate) to the last: a simulator that has
    them otherwise is off by the root of a rate, or of two.
    """
    said = {}
    for size, (unit, due) in {**_OF_TIME, **_OF_KIND.get(kind, {})}.items():
        said[size] = f"as if it were in {unit} and not in {due}"
        said[1 / size] = f"as if it were in {due} and not in {unit}"
    root, roots = their_rate_hz**0.5, (own_rate_hz / their_rate_hz) ** 0.5
    if symbol == "N":
        said[1 / root] = "as if samples scattered by N and not by N sqrt(rate)"
        said[root] = "as if it were how samples scatter, which is N sqrt(rate)"
        said[roots] = "as if samples scattered as the recording's do, at another rate"
    if symbol == "K":
        said[root] = "as if each sample added K and not K/sqrt(rate)"
        said[1 / root] = "as if it were what each sample adds, which is K/sqrt(rate)"
        said[1 / roots] = (
            "as if each sample added what one of the recording's does, at another rate"
        )
    nearest = min(said, key=lambda size: abs(np.log(factor / size)))
    # What is as near to no mistake at all is none.
    apart = abs(np.log(factor / nearest))
    return f", {said[nearest]}" if apart < min(_ALIKE, abs(np.log(factor))) else ""
