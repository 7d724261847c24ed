"""Whether lines are the sidebands of one whose strength or frequency swings."""

import numpy as np

#: As many lines have a middle.
FEWEST = 3
# Equal distances are known to such a part.
_FINE = 0.1
# Sidebands are mirrored to so many ordinates; their strengths differ by so many standard errors of
# one, and such a part. What is not seen has as many standard errors.
_BESIDE, _ALIKE, _PART, _UNSEEN = 1.0, 4.5, 0.05, 4.0


def are_sidebands(lines: list[float], strengths: list[float], samples: int) -> bool:
    """Whether lines [cycles per sample], in rising order, belong to one that swings.

    `strengths` are amplitudes over their standard errors.
    """
    if len(lines) < FEWEST or not even(lines, samples):
        return False
    return symmetric(lines, strengths, samples)


def even(lines: list[float], samples: int) -> bool:
    """Whether lines are at equal distances, or at multiples of one."""
    gaps = np.diff(lines)
    multiples = gaps / gaps.min()
    # Each line is known to a fraction of 1/T, and so is their distance; closer ones fit any comb.
    slack = 0.7 / samples / gaps.min() * multiples
    return bool(np.all(np.abs(multiples - np.round(multiples)) < slack) and slack.min() < _FINE)


def symmetric(lines: list[float], strengths: list[float], samples: int) -> bool:
    """Whether strengths are alike to either side of one frequency.

    Whatever the course of its strength, one line has sidebands that are. Harmonics that fold to
    one place are as evenly spaced, but not as even in strength.
    """
    near = _BESIDE / samples
    for centre in [*lines, (lines[0] + lines[-1]) / 2]:
        mirrored = [
            next(
                (
                    strengths[place]
                    for place, other in enumerate(lines)
                    if abs(2 * centre - line - other) < near
                ),
                _UNSEEN,
            )
            for line in lines
        ]
        allowed = _ALIKE + _PART * np.array(strengths)
        if np.all(np.abs(np.array(strengths) - mirrored) < allowed):
            return True
    return False
