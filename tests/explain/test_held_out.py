"""Scores on data held out: amplitudes that are turned into one another keep what they say."""

import numpy as np
import pytest

from allanfit.explain import _held_out
from allanfit.explain._held_out import _products, _share, _turn


@pytest.mark.parametrize("at_a_time", [64, 2**18])
def test_turning_keeps_what_courses_and_noise_say_together(monkeypatch, at_a_time):
    monkeypatch.setattr(_held_out, "_AT_A_TIME", at_a_time)
    rng = np.random.default_rng(0)
    variance = np.geomspace(1e4, 1e-2, 5000)
    columns = rng.standard_normal((5000, 3)) * np.sqrt(variance)[:, None]
    turned = columns.copy()
    _turn(turned, variance, seed=1)
    assert not np.allclose(turned, columns)
    # A rotation of white amplitudes, whatever the course: all inner products stay.
    white, same = (each / np.sqrt(variance)[:, None] for each in (columns, turned))
    np.testing.assert_allclose(same.T @ same, white.T @ white, rtol=1e-12)
    np.testing.assert_allclose(_products(turned, 1 / variance), white.T @ white, rtol=1e-12)


def test_both_halves_hear_a_course_that_is_in_one_ordinate():
    variance = np.ones(5000)
    columns = np.zeros((5000, 2))
    columns[4321, 1] = 1.0
    _turn(columns, variance, seed=1)
    fold = np.arange(2, 5002) // 2 % 2
    share = [float(np.sum(columns[fold == half, 1] ** 2)) for half in (0, 1)]
    np.testing.assert_allclose(share, [0.5, 0.5], rtol=1e-12)


def test_a_half_that_knows_each_course_may_not_know_them_together():
    """Two columns that are alike in the first half are told apart in the second alone."""
    alike = np.array([[1.0, 0.999], [0.999, 1.0]])
    apart = np.eye(2)
    low, high = _share(alike, apart)
    assert low == pytest.approx(0.001 / 1.001, rel=1e-2)
    assert high == pytest.approx(1.999 / 2.999, rel=1e-5)
    np.testing.assert_allclose(_share(np.zeros((2, 2)), np.zeros((2, 2))), 0.5)
    np.testing.assert_allclose(_share(3 * apart, apart), 0.75, rtol=1e-5)
