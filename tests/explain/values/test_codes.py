"""What coarse codes do to the noise that is logged."""

import numpy as np
import pytest

from allanfit.explain.values._codes import rounding

SAMPLES = 160_000


@pytest.mark.parametrize(("codes", "offset"), [(2.5, 0.0), (3.0, 0.5), (4.0, 0.0), (4.0, 0.3)])
def test_noise_beside_coarse_codes_is_told_wherever_its_mean_is(codes, offset):
    """A twelfth of a squared code would be wrong by 10 to 60 % of N, or hide it."""
    noise = np.random.default_rng(int(10 * codes)).standard_normal(SAMPLES)
    logged = codes * np.round(noise / codes + offset)
    found = rounding(logged, codes, float(logged.std()))
    assert np.sqrt(logged.var() - found.added) == pytest.approx(1, abs=0.03)
    assert abs(logged.var() - found.added - 1) < 3 * np.hypot(found.deviation, np.sqrt(2 / SAMPLES))


def test_codes_of_a_mean_that_moves_add_a_twelfth():
    """Over many codes the error is uniform whatever the noise."""
    rng = np.random.default_rng(5)
    logged = np.round(0.2 * rng.standard_normal(SAMPLES) + np.linspace(0, 50, SAMPLES))
    found = rounding(logged, 1.0, 0.3)
    assert found.added == pytest.approx(1 / 12, abs=0.01)
