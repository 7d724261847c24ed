"""The cosine transform against SciPy's."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.fft
from jax.test_util import check_grads

from allanfit.curves._cosine import dct, folded_sums, idct, idct_folded


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 100, 4097])
def test_it_is_scipys_and_its_inverse(count):
    x = np.random.default_rng(count).standard_normal(count)
    expected = scipy.fft.dct(x, type=2, norm="ortho")
    np.testing.assert_allclose(dct(jnp.asarray(x)), expected, atol=1e-13)
    np.testing.assert_allclose(idct(jnp.asarray(expected)), x, atol=1e-13)


@pytest.mark.parametrize("count", [8, 9, 100])
def test_sums_of_pieces_need_no_order(count):
    x = np.random.default_rng(count).standard_normal(count)
    folded = idct_folded(dct(jnp.asarray(x)))
    edges = np.array([0, 1, 2, 5, count - 1, count])
    expected = [x[a:b].sum() for a, b in itertools.pairwise(edges)]
    np.testing.assert_allclose(folded_sums(folded, jnp.asarray(edges)), expected, atol=1e-13)


def test_float32_stays_so_and_is_as_good():
    x = np.random.default_rng(0).standard_normal(100_001)
    with jax.enable_x64(False):
        found = dct(jnp.asarray(x, jnp.float32))
        back = idct(found)
    assert found.dtype == back.dtype == jnp.float32
    assert np.max(np.abs(found - scipy.fft.dct(x, type=2, norm="ortho"))) < 1e-5
    assert np.max(np.abs(back - x)) < 1e-5


def test_transformations_of_jax():
    x = jnp.asarray(np.random.default_rng(1).standard_normal((3, 8)))
    np.testing.assert_allclose(jax.vmap(jax.jit(dct))(x)[1], dct(x[1]), atol=1e-13)
    for transform in (dct, idct):
        check_grads(
            lambda v, transform=transform: transform(jnp.asarray(v)),
            (x[0],),
            order=1,
            modes=["fwd", "rev"],
            atol=1e-6,
        )
