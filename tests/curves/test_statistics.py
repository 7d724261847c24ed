"""The statistics that are fitted: expectation, independence, and how they vary together."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import allanfit
from allanfit.curves import design, joint_covariance, statistics, statistics_on_host
from allanfit.physics import standard_model

SAMPLES = 2048
RECORDS = 3000
# Compiled as a whole, which takes a tenth of compiling its operations one by one.
compiled = jax.jit(statistics)
# The layout is an argument, which the records of all models share.
of_records = jax.jit(jax.vmap(lambda x, layout: statistics((x,), layout), (0, None)))


@pytest.fixture(
    scope="module",
    params=[({"N": 1.0, "B": 0.3, "K": 0.02}, "point"), ({"Q": 1.0, "N": 0.2}, "averaged")],
    ids=["white, flicker, walk", "quantization"],
)
def simulated(request):
    coefficients, sampling = request.param
    layout = design((SAMPLES,), sampling)
    model = standard_model(coefficients)
    draw = jax.jit(jax.vmap(lambda key: model.sample(key, SAMPLES, 1.0, sampling)))
    found = of_records(draw(jax.random.split(jax.random.key(0), RECORDS)), layout)
    power = np.array([coefficients.get(symbol, 0.0) for symbol in "QNBK"]) ** 2
    return model, layout, power, np.asarray(found.allan), np.asarray(found.density)


def test_expectations(simulated):
    """About 80 statistics; |z| < 4.5, false alarm below 1e-3."""
    _, layout, power, allan, density = simulated
    for found, expected in (
        (density, layout.density @ power),
        (allan, layout.allan[:, :4] @ power),
    ):
        error = found.std(axis=0) / np.sqrt(RECORDS)
        assert np.abs((found.mean(axis=0) - expected) / error).max() < 4.5


def test_bins_are_independent_with_their_degrees_of_freedom(simulated):
    """Relative error of a variance of a chi-square with one degree is 7 %; four of them."""
    _, layout, _, _, density = simulated
    freedom = 2 * density.mean(axis=0) ** 2 / density.var(axis=0)
    np.testing.assert_allclose(freedom / layout.ordinates, 1.0, atol=0.28)
    correlation = np.corrcoef(density.T)
    assert np.abs(correlation - np.eye(len(correlation))).max() < 0.1


def test_joint_covariance(simulated):
    """Correlations to 0.08, four standard errors; standard deviations to 10 %."""
    model, layout, _, allan, density = simulated
    matrix = np.asarray(joint_covariance(model, layout).matrix())
    found = np.cov(np.hstack([allan, density]).T)
    deviation, expected = np.sqrt(np.diag(found)), np.sqrt(np.diag(matrix))
    np.testing.assert_allclose(deviation / expected, 1.0, atol=0.13)
    difference = found / np.outer(deviation, deviation) - matrix / np.outer(expected, expected)
    assert np.abs(difference).max() < 0.09


def test_a_ramp_changes_no_bin():
    layout = design((SAMPLES,))
    draw = eqx.filter_jit(standard_model({"N": 1.0, "K": 0.1}).sample)
    x = draw(jax.random.key(3), SAMPLES, 1.0, "point")
    plain = compiled((x,), layout).density
    steep = compiled((x + 10.0 * jnp.arange(SAMPLES),), layout).density
    np.testing.assert_allclose(steep, plain, rtol=1e-6)


def test_stretches_pool_their_sums():
    lengths = (700, 300)
    layout = design(lengths)
    x = jax.random.normal(jax.random.key(4), (1000,))
    pieces = (x[:700], x[700:])
    found = compiled(pieces, layout)
    singles = [compiled((piece,), design((len(piece),))) for piece in pieces]
    sizes = np.asarray(layout.cluster_sizes)
    n = 5
    sums = [
        float(single.allan[np.flatnonzero(design((length,)).cluster_sizes == n)[0]])
        * (length - 2 * n + 1)
        for single, length in zip(singles, lengths, strict=True)
    ]
    expected = sum(sums) / sum(length - 2 * n + 1 for length in lengths)
    np.testing.assert_allclose(found.allan[np.flatnonzero(sizes == n)[0]], expected, rtol=1e-9)
    assert int(np.sum(layout.ordinates)) == 1000 - 2 * 2


def test_many_stretches_leave_the_same_behind_without_being_compiled():
    """On the host as by JAX: a random walk, with a stretch too short for most sizes."""
    rng = np.random.default_rng(12)
    lengths = (1000, 16, 4001, 2500, 37)
    stretches = tuple(np.cumsum(rng.standard_normal(length)) + 5 for length in lengths)
    layout = design(lengths)
    known = compiled(stretches, layout)
    for one, other in zip(statistics_on_host(stretches, layout), known, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())


def test_a_record_with_gaps_gives_its_coefficients():
    """N of white noise in nine stretches, no two alike; 1.5 per cent are 4 deviations."""
    rng = np.random.default_rng(13)
    edges = np.cumsum([0, *rng.integers(2000, 9000, 9)])
    stretches = tuple(zip(edges[:-1].tolist(), (edges[1:] - 7).tolist(), strict=True))
    found = allanfit.fit(rng.standard_normal(edges[-1]), 1.0, stretches=stretches)
    assert found.coefficients["N"] == pytest.approx(1, rel=0.015)
