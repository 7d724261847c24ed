"""Each term's two faces and its sampler, against each other and against closed forms."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.fft
from scipy.integrate import quad
from scipy.linalg import toeplitz

from allanfit.curves import allan_variance
from allanfit.physics import (
    STANDARD_TERMS,
    BiasInstability,
    QuantizationNoise,
    RateRandomWalk,
    WhiteNoise,
    coefficient_unit,
    standard_model,
)

NOISES = (QuantizationNoise, WhiteNoise, BiasInstability, RateRandomWalk)
SAMPLINGS = ("point", "averaged")
DT = 0.02


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("term", NOISES)
def test_allan_variance_is_the_integral_of_the_density(term, sampling):
    """Kernel 2 sin^4(pi f n dt)/(n^2 sin^2(pi f dt)), integrated lobe by lobe."""
    noise = term(jnp.asarray(0.7))
    for n in (1, 2, 3, 5, 10, 50):

        def integrand(f, n=n):
            density = float(noise.density(jnp.asarray(f), DT, sampling))
            kernel = 2 * np.sin(np.pi * f * n * DT) ** 4 / (n * np.sin(np.pi * f * DT)) ** 2
            return density * kernel

        edges = np.linspace(0, 0.5 / DT, max(n // 2, 1) + 1)
        edges[0] = 1e-9
        if n == 50:
            continue_at = min(len(edges), 6)  # beyond, the kernel is small; sum it on a grid
            grid = np.linspace(edges[continue_at - 1], 0.5 / DT, 20_001)
            middle = (grid[1:] + grid[:-1]) / 2
            density = np.asarray(noise.density(jnp.asarray(middle), DT, sampling))
            kernel = 2 * np.sin(np.pi * middle * n * DT) ** 4
            kernel /= (n * np.sin(np.pi * middle * DT)) ** 2
            total = np.sum(density * kernel) * (grid[1] - grid[0])
            edges = edges[:continue_at]
        else:
            total = 0.0
        total += sum(quad(integrand, a, b, limit=200)[0] for a, b in pairwise(edges))
        expected = float(noise.allan_variance(jnp.asarray(float(n)), DT, sampling))
        assert total == pytest.approx(expected, rel=2e-4), n


def test_point_sampled_flicker_over_its_floor():
    """The ratios of fractionally differenced noise at small n, known to three digits."""
    n = jnp.array([1.0, 2.0, 3.0, 5.0, 10.0, 100.0])
    found = BiasInstability(jnp.asarray(1.0)).allan_variance(n, DT, "point")
    np.testing.assert_allclose(
        found / (2 * np.log(2) / np.pi), [1.443, 1.154, 1.080, 1.034, 1.011, 1.000], atol=6e-4
    )


def test_textbook_values_of_every_term():
    tau = 4.0
    coefficients = {"Q": 2.0, "N": 3.0, "B": 5.0, "K": 7.0, "R": 11.0}
    expected = {
        "Q": 3 * 4 / tau**2,
        "N": 9 / tau,
        "B": 2 * np.log(2) / np.pi * 25,
        "K": 49 * tau / 3,
        "R": 121 * tau**2 / 2,
    }
    for symbol, value in coefficients.items():
        model = standard_model({symbol: value})
        found = model.allan_variance(jnp.asarray(tau / DT), DT, "averaged")
        assert float(found) == pytest.approx(expected[symbol], rel=1e-9)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("term", NOISES)
def test_sampler_has_the_expected_allan_variance(term, sampling):
    """400 records of 512 at n = 1, 2, 3, 10; |z| < 4.5, false alarm below 1e-4 in all."""
    noise = term(jnp.asarray(0.7))
    keys = jax.random.split(jax.random.key(1), 400)
    records = jax.vmap(lambda key: noise.sample(key, 512, DT, sampling))(keys)
    sizes = np.array([1, 2, 3, 10])
    found = np.asarray(allan_variance(records, 1 / DT, sizes))
    expected = np.asarray(noise.allan_variance(jnp.asarray(sizes, float), DT, sampling))
    error = found.std(axis=0) / np.sqrt(len(keys))
    assert np.abs((found.mean(axis=0) - expected) / error).max() < 4.5


def test_low_modes_of_flicker_from_its_covariance():
    """Cosine transform of the generalised covariance -D(k)/2, D(k) = (4/pi) sum 1/(2i - 1)."""
    size = 512
    structure = np.concatenate([[0], 4 / np.pi * np.cumsum(1 / (2 * np.arange(1, size) - 1))])
    half = scipy.fft.dct(toeplitz(-structure / 2), norm="ortho", axis=0)
    variance = np.diag(scipy.fft.dct(half, norm="ortho", axis=1))[1:]
    order = np.arange(1, size)
    noise = BiasInstability(jnp.asarray(1.0))
    density = np.asarray(noise.density(jnp.asarray(order / (2 * size)), 1.0, "point"))
    ratio = np.asarray(noise.low_mode_ratio(jnp.asarray(order[:50], float), size))
    np.testing.assert_allclose(2 * variance[:50] / density[:50], ratio, rtol=4e-4)


@pytest.mark.parametrize("term", STANDARD_TERMS)
def test_terms_are_pytrees_under_jit_vmap_and_grad(term):
    noise = term(jnp.asarray(0.7))
    leaves, structure = jax.tree.flatten(noise)
    assert jax.tree.unflatten(structure, leaves) == noise
    n = jnp.array([1.0, 4.0, 9.0])

    def face(noise, n):
        frequency = 0.4 / n / DT
        return noise.allan_variance(n, DT, "point") + noise.density(frequency, DT, "point")

    whole = face(noise, n)
    np.testing.assert_allclose(jax.jit(face)(noise, n), whole, rtol=1e-12)
    np.testing.assert_allclose(jax.vmap(face, (None, 0))(noise, n), whole, rtol=1e-12)
    gradient = jax.grad(lambda noise: jnp.sum(face(noise, n)))(noise).coefficient
    assert float(gradient) == pytest.approx(float(2 * jnp.sum(whole) / 0.7), rel=1e-9)


def test_units_of_coefficients():
    spelled = [coefficient_unit(term, "rad/s") for term in STANDARD_TERMS]
    assert spelled == ["rad", "rad/s/sqrt(Hz)", "rad/s", "rad/s/sqrt(s)", "rad/s^2"]
    spelled = [coefficient_unit(term, "m/s^2") for term in STANDARD_TERMS]
    assert spelled == ["m/s", "m/s^2/sqrt(Hz)", "m/s^2", "m/s^2/sqrt(s)", "m/s^3"]
    assert [coefficient_unit(term, "g") for term in STANDARD_TERMS][::4] == ["g s", "g/s"]


def test_unknown_coefficient_is_refused():
    with pytest.raises(ValueError, match="unknown coefficient 'n'"):
        standard_model({"n": 1.0})
