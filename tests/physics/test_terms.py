"""The contract of every term, and its two faces against each other and against closed forms."""

from functools import partial
from itertools import product

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.physics import (
    STANDARD_TERMS,
    SYMBOLS,
    BiasInstability,
    NoiseModel,
    QuantizationNoise,
    RateRamp,
    RateRandomWalk,
    WhiteNoise,
    coefficient_unit,
    standard_model,
)

NOISES = (QuantizationNoise, WhiteNoise, BiasInstability, RateRandomWalk)
SAMPLINGS = ("point", "averaged")
DT = 0.02
SIZES = jnp.array([1.0, 2.0, 3.0, 5.0, 10.0, 100.0])
FREQUENCIES = jnp.array([1e-3, 0.5, 7.0, 24.0])

each_term = pytest.mark.parametrize("term", STANDARD_TERMS, ids=SYMBOLS)
each_noise = pytest.mark.parametrize("term", NOISES, ids=SYMBOLS[:-1])
each_sampling = pytest.mark.parametrize("sampling", SAMPLINGS)


def faces(noise, sampling, sizes, frequencies):
    """Both expectations, at a vector of sizes and one of frequencies of equal length."""
    return jnp.stack(
        [noise.allan_variance(sizes, DT, sampling), noise.density(frequencies, DT, sampling)]
    )


# Where a test is not of eager calls: the coefficient is an argument of what is compiled.
jitted_faces = eqx.filter_jit(faces)


@each_term
def test_a_term_is_a_pytree_of_its_coefficient(term):
    noise = term(jnp.asarray(0.7))
    leaves, structure = jax.tree.flatten(noise)
    assert leaves == [0.7]
    assert jax.tree.unflatten(structure, leaves) == noise


@each_sampling
@each_term
def test_jit_and_vmap_change_nothing(term, sampling):
    both = partial(faces, term(jnp.asarray(0.7)), sampling)
    sizes, frequencies = SIZES[:4], FREQUENCIES
    eager = both(sizes, frequencies)
    loop = jnp.stack(
        [both(n[None], f[None])[:, 0] for n, f in zip(sizes, frequencies, strict=True)], axis=1
    )
    np.testing.assert_allclose(jax.jit(both)(sizes, frequencies), eager, rtol=1e-12)
    np.testing.assert_allclose(jax.vmap(both, out_axes=1)(sizes, frequencies), eager, rtol=1e-12)
    np.testing.assert_allclose(loop, eager, rtol=1e-12)


@each_sampling
@each_term
def test_the_gradient_is_a_finite_difference(term, sampling):
    """By the coefficient, the sizes and the frequencies, in one random direction."""

    @jax.jit
    def curve(coefficient, sizes, frequencies):
        return jnp.sum(jnp.sinh(faces(term(coefficient), sampling, sizes, frequencies)))

    at = (jnp.asarray(0.07), SIZES[:3], FREQUENCIES[1:])
    direction = (jnp.asarray(0.1), jnp.array([0.3, -0.2, 0.5]), jnp.array([0.01, 0.2, -0.3]))
    _, slope = jax.jit(partial(jax.jvp, curve))(at, direction)
    step = 1e-5
    ahead, behind = (
        curve(*(x + sign * step * v for x, v in zip(at, direction, strict=True)))
        for sign in (1, -1)
    )
    assert float(slope) == pytest.approx(float(ahead - behind) / (2 * step), rel=1e-6, abs=1e-9)
    backwards = jax.jit(jax.grad(curve, argnums=(0, 1, 2)))(*at)
    total = sum(float(jnp.vdot(g, v)) for g, v in zip(backwards, direction, strict=True))
    assert total == pytest.approx(float(slope), rel=1e-9)


@each_sampling
@each_term
def test_the_coefficient_enters_squared(term, sampling):
    once = jitted_faces(term(jnp.asarray(0.7)), sampling, SIZES[:4], FREQUENCIES)
    thrice = jitted_faces(term(jnp.asarray(2.1)), sampling, SIZES[:4], FREQUENCIES)
    np.testing.assert_allclose(thrice, 9 * once, rtol=1e-12)


@each_sampling
@each_term
def test_float32_is_enough(term, sampling):
    wide = np.asarray(jitted_faces(term(jnp.asarray(0.7)), sampling, SIZES[:4], FREQUENCIES))
    with jax.enable_x64(False):
        sizes, frequencies = (jnp.asarray(x, jnp.float32) for x in (SIZES[:4], FREQUENCIES))
        narrow = jitted_faces(term(jnp.float32(0.7)), sampling, sizes, frequencies)
        assert narrow.dtype == jnp.float32
        np.testing.assert_allclose(np.asarray(narrow, np.float64), wide, rtol=2e-5)


def lobes(n):
    """Gauss-Legendre nodes and weights in every lobe of the kernel, in cycles per sample."""
    node, weight = np.polynomial.legendre.leggauss(24)
    edges = np.arange(0, n // 2 + 1) / n
    edges = np.unique(np.append(edges, 0.5))
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


@each_sampling
@each_noise
def test_the_allan_variance_is_the_integral_of_the_density(term, sampling):
    """AVAR(n) = int S(f) 2 sin^4(pi f n dt)/(n sin(pi f dt))^2 df up to the Nyquist frequency."""
    noise = term(jnp.asarray(0.7))
    for n in np.asarray(SIZES, int):
        cycles, weight = lobes(n)
        density = np.asarray(eqx.filter_jit(noise.density)(cycles / DT, DT, sampling))
        kernel = 2 * np.sin(np.pi * cycles * n) ** 4 / (n * np.sin(np.pi * cycles)) ** 2
        expected = float(eqx.filter_jit(noise.allan_variance)(jnp.asarray(float(n)), DT, sampling))
        assert np.sum(density * kernel * weight) / DT == pytest.approx(expected, rel=1e-9), n


def test_a_ramp_has_no_density():
    noise = RateRamp(jnp.asarray(0.7))
    assert not np.any(noise.density(FREQUENCIES, DT, "point"))


@pytest.mark.parametrize(
    ("term", "sampling", "power", "scale"),
    [
        (BiasInstability, "averaged", 1, 1 / np.pi),
        (RateRandomWalk, "averaged", 2, 0.5 / np.pi**2),
        (RateRandomWalk, "point", 2, 0.5 / np.pi**2),
    ],
    ids=["B averaged", "K averaged", "K point"],
)
def test_the_density_is_the_sum_of_all_aliases(term, sampling, power, scale):
    """Of the continuous density scale/|f|^power, times sinc^2 when the sensor averages."""
    cycles = np.array([1e-4, 0.01, 0.2, 0.37, 0.5])
    alias = np.abs(cycles[:, None] + np.arange(-50_000, 50_001))
    filtered = np.sinc(alias) ** 2 if sampling == "averaged" else 1.0
    continuous = np.sum(scale * filtered / alias**power, axis=1)
    found = eqx.filter_jit(term(jnp.asarray(1.0)).density)(cycles, 1.0, sampling)
    # What the sum leaves out: at most 2 scale/50000 of a density that is 0.5 or more.
    np.testing.assert_allclose(found, continuous, rtol=1e-5)


def test_point_sampled_flicker_over_its_floor():
    """The ratios of fractionally differenced noise at small n, known to three digits."""
    found = BiasInstability(jnp.asarray(1.0)).allan_variance(SIZES, DT, "point")
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
        found = eqx.filter_jit(model.allan_variance)(jnp.asarray(tau / DT), DT, "averaged")
        assert float(found) == pytest.approx(expected[symbol], rel=1e-9)
    together = standard_model(coefficients)
    found = eqx.filter_jit(together.allan_variance)(jnp.asarray(tau / DT), DT, "averaged")
    assert float(found) == pytest.approx(sum(expected.values()), rel=1e-9)


@each_sampling
def test_low_frequency_densities_are_those_of_the_textbook(sampling):
    """One-sided, far below the Nyquist frequency: twice what IEEE Std 952 prints."""
    f = 1e-3
    expected = {
        "Q": 8 * np.pi**2 * f**2 * DT,
        "N": 2.0,
        "B": 1 / (np.pi * f),
        "K": 1 / (2 * np.pi**2 * f**2),
    }
    for symbol, value in expected.items():
        found = eqx.filter_jit(standard_model({symbol: 1.0}).density)(jnp.asarray(f), DT, sampling)
        assert float(found) == pytest.approx(value, rel=1e-6), symbol


def test_a_model_without_terms_is_silent():
    model = NoiseModel(())
    assert not np.any(model.density(FREQUENCIES, DT, "point"))
    assert not np.any(model.allan_variance(SIZES, DT, "point"))
    assert not np.any(model.sample(jax.random.key(0), 9, DT, "point"))


@pytest.mark.parametrize(
    ("unit", "spelled"),
    [
        ("rad/s", ["rad", "rad/s/sqrt(Hz)", "rad/s", "rad/s/sqrt(s)", "rad/s^2"]),
        ("m/s^2", ["m/s", "m/s^2/sqrt(Hz)", "m/s^2", "m/s^2/sqrt(s)", "m/s^3"]),
        ("g", ["g s", "g/sqrt(Hz)", "g", "g/sqrt(s)", "g/s"]),
        ("", ["1 s", "1/sqrt(Hz)", "", "1/sqrt(s)", "1/s"]),
    ],
)
def test_units_of_coefficients(unit, spelled):
    assert [coefficient_unit(term, unit) for term in STANDARD_TERMS] == spelled


def test_unknown_coefficient_is_refused():
    with pytest.raises(ValueError, match="unknown coefficient 'n'; the five are Q, N, B, K, R"):
        standard_model({"N": 2.0, "n": 1.0})


def test_a_model_is_the_sum_of_its_terms():
    values = dict(zip(SYMBOLS, (0.1, 0.2, 0.3, 0.4, 0.5), strict=True))
    for sampling, face in product(SAMPLINGS, (0, 1)):
        alone = [
            jitted_faces(standard_model({symbol: value}), sampling, SIZES[:4], FREQUENCIES)[face]
            for symbol, value in values.items()
        ]
        whole = jitted_faces(standard_model(values), sampling, SIZES[:4], FREQUENCIES)[face]
        np.testing.assert_allclose(whole, sum(alone), rtol=1e-12)
