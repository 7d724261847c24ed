"""What a knock leaves behind."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate
from allanfit.explain.courses._jumps import _differences, jumps

SAMPLES = 60_000


@pytest.mark.parametrize("height", [0.0, 0.3, -2.0])
def test_another_mean_behind_a_knock_is_told(height):
    rng = np.random.default_rng(4)
    values = rng.standard_normal(SAMPLES) + 2e-4 * np.cumsum(rng.standard_normal(SAMPLES))
    time = np.arange(400)
    values[25_000:25_400] += 40 * np.exp(-time / 80) * np.sin(0.7 * time)
    values[25_000:] += height
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 0.5, 0.0, 0.0]))
    assert state.knocks
    found = jumps(state)
    assert len(found) == (height != 0)
    for jump in found:
        assert abs(jump.height - height) < 4 * jump.deviation
        assert 25_000 < jump.after < 27_000


def test_differences_are_those_of_means_with_a_gap_between():
    x = np.random.default_rng(1).standard_normal(1_000)
    found = _differences(x, 64, 10)
    at = 32 * 5
    assert found[5] == pytest.approx(x[at + 74 : at + 138].mean() - x[at : at + 64].mean())
    assert len(found) == (1_000 - 138) // 32 + 1
