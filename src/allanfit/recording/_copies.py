"""Rows that a logger wrote twice."""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Bool, Num

from ._wording import count, percent

# Where a coarse clock repeats itself, values beside equal stamps differ as a rule.
_NEARLY_ALL = 0.9


def copies(
    stamps: Num[np.ndarray, " rows"], columns: Iterable[Num[np.ndarray, " rows"]]
) -> Bool[np.ndarray, " rows"]:
    """Which rows are equal to the one before in everything, the time stamp among it.

    None, unless nearly all rows with the stamp of the one before are.
    """
    # Compared, not subtracted: infinite stamps are refused later, by name.
    again = stamps[1:] == stamps[:-1]
    equal = again.copy()
    for column in columns:
        if not equal.any():
            break
        equal &= column[1:] == column[:-1]
    if np.count_nonzero(equal) <= _NEARLY_ALL * np.count_nonzero(again):
        equal[:] = False
    return np.concatenate([[False], equal])


def about_copies(number: int, rows: int) -> tuple[str, ...]:
    """A finding on so many copies among all rows."""
    if not number:
        return ()
    return (
        f"Left out as copies of the row before, time stamp and all: {count(number, 'row')} "
        f"({percent(number / rows)}).",
    )
