"""Which lines belong together."""

import numpy as np
import pytest

from allanfit.explain.lines._harmonics import Line, families


def test_multiples_of_a_motor_are_one_family_and_a_stranger_is_not():
    lines = [Line(f, 1e-4) for f in (7.30005, 14.6, 29.2, 11.17)]
    (family,) = families(lines, 50.0)
    assert family.fundamental == pytest.approx(7.3, abs=1e-4)
    assert family.lines == (7.30005, 14.6, 29.2)
    assert family.folded == ()


def test_multiples_beyond_half_the_rate_are_known_where_they_fold_to():
    """Of 23 Hz in a log at 100 Hz the third, fourth and fifth are at 31, 8 and 15 Hz."""
    (family,) = families([Line(f, 1e-4) for f in (8.0, 15.0, 23.0, 31.0, 46.0)], 50.0)
    assert family.fundamental == pytest.approx(23)
    assert family.lines == (8.0, 15.0, 23.0, 31.0, 46.0)
    assert family.folded == (8.0, 15.0, 31.0)


def test_what_need_not_fold_does_not():
    """At 500 Hz the third multiple of 150 Hz would be seen at 50 Hz, as mains is."""
    for lines in ([50.0, 150.0], [150.0, 50.0]):
        (family,) = families([Line(f, 1e-4) for f in lines], 250.0)
        assert family.fundamental == pytest.approx(50)
        assert family.folded == ()


def test_a_fundamental_that_is_not_seen_is_found():
    (family,) = families([Line(8.2, 1e-4), Line(12.3, 1e-4)], 50.0)
    assert family.fundamental == pytest.approx(4.1, abs=1e-3)


def test_lines_by_chance_are_seldom_a_family():
    """Of 1000 draws one by the stated chance; six and more once in a thousand times."""
    rng = np.random.default_rng(1)
    draws = rng.uniform(1, 50, (1000, 4))
    found = sum(bool(families([Line(f, 1e-4) for f in each], 50.0)) for each in draws)
    assert found < 6
    # Where frequencies are hardly known nothing can be said, and is not.
    assert not any(families([Line(f, 0.5) for f in each], 50.0) for each in draws[:100])


def test_a_comb_is_one_family():
    """What comes once a second has lines at all whole Hz, of which some are seen."""
    seen = (1, 3, 6, 13, 16.999_9, 18, 27, 31, 32, 40)
    (family,) = families([Line(float(f), 1e-4) for f in seen], 50.0)
    assert family.fundamental == pytest.approx(1, abs=1e-4)
    assert len(family.lines) == len(seen)
