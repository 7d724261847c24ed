"""What is drawn against what is expected of it, and how keys and sampling enter."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.curves import allan_variance, psd
from allanfit.physics import STANDARD_TERMS, SYMBOLS, standard_model
from allanfit.physics._stationary import sample_from_autocovariance

DT = 0.02
SAMPLES = 512
RECORDS = 2000
SIZES = np.array([1, 2, 3, 10])
EXAMPLE = dict(zip(SYMBOLS, (0.1, 0.2, 0.3, 0.4, 0.5), strict=True))


def sample(coefficients, key, samples, sampling):
    """The coefficients are arguments of what is compiled: one program serves them all."""
    draw = eqx.filter_jit(standard_model(coefficients).sample)
    return np.asarray(draw(key, samples, DT, sampling))


@pytest.mark.parametrize("sampling", ["point", "averaged"])
@pytest.mark.parametrize("symbol", SYMBOLS[:-1])
def test_draws_have_the_expected_curves(symbol, sampling):
    """Allan variance at four sizes, mirror spectrum in 18 bins, 2000 records.

    Standard errors from the records; |z| < 4.5 in all eight cases, 176 statistics: false alarm
    about 1e-3, the key being fixed.
    """
    noise = standard_model({symbol: 0.7}).terms[SYMBOLS.index(symbol)]
    keys = jax.random.split(jax.random.key(1), RECORDS)
    records = jax.jit(jax.vmap(lambda key: noise.sample(key, SAMPLES, DT, sampling)))(keys)

    found = np.asarray(allan_variance(records, 1 / DT, SIZES))
    expected = np.asarray(eqx.filter_jit(noise.allan_variance)(SIZES.astype(float), DT, sampling))
    error = found.std(axis=0) / np.sqrt(RECORDS)
    assert np.abs((found.mean(axis=0) - expected) / error).max() < 4.5

    binned = psd(records, 1 / DT, bins_per_decade=8)
    order = np.arange(1.0, SAMPLES)
    density = eqx.filter_jit(noise.density)(order / (2 * SAMPLES * DT), DT, sampling)
    ordinates = np.asarray(density * eqx.filter_jit(noise.low_mode_ratio)(order, SAMPLES))
    ends = np.cumsum(np.asarray(binned.ordinates, int))
    expected = np.add.reduceat(ordinates, np.append(0, ends[:-1])) / np.asarray(binned.ordinates)
    found = np.asarray(binned.density)
    error = found.std(axis=0) / np.sqrt(RECORDS)
    assert np.abs((found.mean(axis=0) - expected) / error).max() < 4.5


def test_a_drawn_ramp_is_a_ramp():
    drawn = sample({"R": 3.0}, jax.random.key(0), 50, "point")
    np.testing.assert_allclose(np.diff(drawn), 3.0 * DT, rtol=1e-12)


@pytest.mark.parametrize("sampling", ["point", "averaged"])
@pytest.mark.parametrize("term", STANDARD_TERMS, ids=SYMBOLS)
def test_jit_and_vmap_draw_the_same(term, sampling):
    noise = term(jnp.asarray(0.7))
    keys = jax.random.split(jax.random.key(2), 3)

    def draw(key):
        return noise.sample(key, 33, DT, sampling)

    eager = jnp.stack([draw(key) for key in keys])
    assert eager.shape == (3, 33)
    np.testing.assert_allclose(jax.vmap(draw)(keys), eager, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(jax.jit(draw)(keys[0]), eager[0], rtol=1e-10, atol=1e-12)
    if term.symbol != "R":
        assert float(jnp.max(jnp.abs(eager[0] - eager[1]))) > 0


def test_adding_a_term_leaves_the_others_alone():
    key = jax.random.key(3)
    both = sample({"N": 1.0, "K": 0.1}, key, 100, "point")
    alone = [sample(c, key, 100, "point") for c in ({"N": 1.0}, {"K": 0.1})]
    np.testing.assert_allclose(both, sum(alone), rtol=1e-12, atol=1e-13)
    assert abs(np.corrcoef(alone[0], np.diff(alone[1], prepend=0))[0, 1]) < 0.4


def test_flicker_increments_have_the_autocovariance_of_their_density():
    """Lags on both sides of 32, where the averaged one changes its formula.

    The integral of S(f) 4 sin^2(pi f) cos(2 pi f k) over the band, by Gauss-Legendre.
    """
    from allanfit.physics._bias_instability import _averaged_increment_autocovariance

    node, weight = np.polynomial.legendre.leggauss(400)
    cycles, weight = (node + 1) / 4, weight / 4
    unit = standard_model({"B": 1.0}).terms[SYMBOLS.index("B")]
    density = np.asarray(eqx.filter_jit(unit.density)(cycles, 1.0, "averaged"))
    lag = np.array([0.0, 1, 2, 5, 31, 32, 33, 60])
    wave = 4 * np.sin(np.pi * cycles) ** 2 * np.cos(2 * np.pi * cycles * lag[:, None])
    expected = np.sum(density * wave * weight, axis=1)
    np.testing.assert_allclose(
        _averaged_increment_autocovariance(lag), expected, rtol=1e-6, atol=1e-9
    )


def test_circulant_embedding_draws_the_covariance_that_it_is_given():
    """Exponential of 0.8^k: 4000 draws of 6; |z| < 4.5 of 21 products, false alarm 1e-4."""
    wanted = 0.8 ** np.arange(64.0)
    keys = jax.random.split(jax.random.key(4), 4000)
    draw = jax.jit(jax.vmap(lambda key: sample_from_autocovariance(key, wanted)))
    drawn = np.asarray(draw(keys))[:, -6:]
    products = drawn[:, :, None] * drawn[:, None, :]
    error = products.std(axis=0) / np.sqrt(len(keys))
    lag = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    assert np.abs((products.mean(axis=0) - wanted[lag]) / error).max() < 4.5


def test_an_impossible_autocovariance_is_refused():
    with pytest.raises(ValueError, match="no non-negative circulant embedding"):
        sample_from_autocovariance(jax.random.key(0), np.array([1.0, 0.9, -0.9, 0.9]))


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_a_coefficient_scales_its_draw(symbol):
    key = jax.random.key(5)
    once = sample({symbol: EXAMPLE[symbol]}, key, 20, "averaged")
    twice = sample({symbol: 2 * EXAMPLE[symbol]}, key, 20, "averaged")
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-12)
