"""Loud and quiet times of a record."""

import itertools

import numpy as np
import pytest
from scipy.stats import gamma

from allanfit.explain.strength._modulation import modulation
from allanfit.explain.strength._paths import climbed

WINDOWS, SAMPLES, PRICE = 11, 32.0, 2.0
LOUD = np.arange(WINDOWS) // 3 == 1
PATHS = np.array(list(itertools.product([False, True], repeat=WINDOWS)))


@pytest.mark.parametrize("seed", range(8))
def test_no_path_between_two_levels_is_likelier(seed):
    """Of all 2048, given the levels that it led to, each change at its price."""
    rng = np.random.default_rng(seed)
    power = np.where(LOUD, 3.0, 1.0) * rng.chisquare(SAMPLES, WINDOWS) / SAMPLES
    path, quiet, loud, score = climbed(power, SAMPLES, PRICE, 1.0, 2.0)
    likelihood = [
        gamma.logpdf(power, SAMPLES / 2, scale=2 * level / SAMPLES) for level in (quiet, loud)
    ]
    scores = np.where(PATHS, likelihood[1], likelihood[0]).sum(axis=1)
    scores -= PRICE * np.count_nonzero(np.diff(PATHS, axis=1), axis=1)
    assert path.any()
    np.testing.assert_array_equal(path, PATHS[np.argmax(scores)])
    # A density of mean squares, and one of samples: what depends on no level is between them.
    alone = -SAMPLES / 2 * np.sum(np.log(quiet) + power / quiet)
    assert score - alone == pytest.approx(scores.max() - likelihood[0].sum())


def test_what_is_louder_for_long_is_found_though_it_is_little_louder():
    """Two stretches five standard deviations louder, to one who knew when: 17 of 40 are found.

    By chance as odd a record is one of 1250; where they begin is right to some per cent.
    """
    samples = 100_000
    time = np.arange(samples) / samples
    loud = ((time > 0.15) & (time < 0.4)) | ((time > 0.7) & (time < 0.85))
    share = loud.mean()
    excess = 5 / np.sqrt(samples * share * (1 - share) / 2)
    right = []
    for seed in range(40):
        white = np.random.default_rng(seed).standard_normal(samples) * np.sqrt(1 + excess * loud)
        found = modulation(white / white.std(), 0)
        if found.p_value < 8e-4 and found.loud.any():
            right.append(np.mean(found.loud == loud))
    assert len(right) >= 14
    assert np.mean(right) > 0.7
