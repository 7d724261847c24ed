"""The likeliest path between two levels, against all paths there are."""

from itertools import product

import numpy as np
import pytest

from allanfit.explain.courses._decoded import likeliest

PATHS = np.array(list(product((0, 1), repeat=10)))


@pytest.mark.parametrize("leave", [0.02, 0.2, 0.5])
@pytest.mark.parametrize("variance", [0.1, 1.0])
def test_no_path_is_likelier(leave, variance):
    rng = np.random.default_rng(3)
    for _ in range(50):
        path = PATHS[rng.integers(len(PATHS))]
        means = path + np.sqrt(variance) * rng.standard_normal(10)
        switches = np.count_nonzero(np.diff(PATHS, axis=1), axis=1)
        logs = switches * np.log(leave) + (9 - switches) * np.log1p(-leave)
        logs -= np.sum((means - PATHS) ** 2, axis=1) / (2 * variance)
        best = PATHS[np.argmax(logs)].astype(bool)
        np.testing.assert_array_equal(likeliest(means, variance, leave), best)
