"""`fit` and `fit_many` on simulated records: truth, batches, derivatives, bad input."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import allanfit
from allanfit.curves import design, unit_scale
from allanfit.identify import _estimate
from allanfit.physics import SYMBOLS, check_sampling, standard_model

GYRO = {"N": 5e-3, "B": 2e-3, "K": 1e-3}
# One length, that of test_many, so that all is compiled once; a quarter of an hour, in which
# flicker noise and walk show.
SAMPLES, RATE_HZ = 8192, 10.0


@jax.jit
def record(key, model):
    return model.sample(key, SAMPLES, 1 / RATE_HZ, "point")


def records(coefficients, count, seed=0):
    model = standard_model(coefficients)
    return jnp.stack([record(key, model) for key in jax.random.split(jax.random.key(seed), count)])


@pytest.fixture(scope="module")
def fits():
    """Of 120 records of 14 min."""
    return allanfit.fit_many(records(GYRO, 120), RATE_HZ)


def test_intervals_hold_the_truth_and_absent_terms_are_not_seen(fits):
    """Of 120 records each 95 % interval misses at most 14 times.

    With honest intervals more than 14 misses of 120 happen with probability 1e-3 a coefficient.
    """
    assert bool(jnp.all(fits.converged))
    for symbol, truth in GYRO.items():
        low, high = fits.intervals[symbol].T
        assert int(jnp.sum((truth < low) | (truth > high))) <= 14, symbol
    # Of 120, 3 % false claims exceed 11 with probability 1e-3.
    assert int(jnp.sum(fits.resolved["Q"])) <= 11
    assert int(jnp.sum(fits.resolved["R"])) <= 4
    np.testing.assert_allclose(jnp.median(fits.coefficients["N"]), GYRO["N"], rtol=0.01)


def test_errors_are_at_the_bound_of_who_knows_that_there_is_no_quantization(fits):
    """120 records: errors relative to the Cramer-Rao bound have a standard error of 0.065.

    The bound by its definition, from the derivatives of the Gamma log-likelihood of the bins. The
    limit is passed by chance once in 1e4; a prior that hardly believes in Q = 0 gives 1.4 for N.
    """
    layout = design((SAMPLES,))
    scale = unit_scale(1 / RATE_HZ)[1:4]
    truth = jnp.array(list(GYRO.values()))
    expected, ordinates = jnp.asarray(layout.density)[:, 1:], jnp.asarray(layout.ordinates)

    def log_mean(coefficients):
        return jnp.log(expected @ (coefficients / scale) ** 2)

    slope = jax.jacfwd(log_mean)(truth)
    bound = jnp.sqrt(jnp.diag(jnp.linalg.inv(slope.T @ (ordinates[:, None] / 2 * slope))))
    for symbol, one, true in zip(GYRO, bound, truth, strict=True):
        error = jnp.sqrt(jnp.mean((fits.coefficients[symbol] - true) ** 2))
        assert error / one < 1.27, symbol


def test_a_value_lies_within_its_interval_and_an_unresolved_one_is_bounded():
    fits = allanfit.fit_many(records({"N": 5e-3, "B": 5e-4}, 16, seed=3), RATE_HZ)
    for symbol in SYMBOLS:
        low, high = fits.interval(0.68)[symbol].T
        assert bool(
            jnp.all((low <= fits.coefficients[symbol]) & (fits.coefficients[symbol] <= high))
        )
        seen = fits.resolved[symbol]
        assert bool(jnp.all(jnp.where(seen, low > 0, low == 0)))
        assert bool(jnp.all(fits.upper_limits[symbol] > 0))


def test_a_ramp_is_found_with_its_size():
    """With honest intervals more than 4 of 16 miss once in 1000 runs."""
    samples = records(GYRO | {"K": 0.0, "R": 1e-4}, 16, seed=1)
    fits = allanfit.fit_many(samples, RATE_HZ)
    assert bool(jnp.all(fits.resolved["R"]))
    low, high = fits.intervals["R"].T
    assert int(jnp.sum((low < 1e-4) & (high > 1e-4))) >= 12
    # What is left of the record knows nothing of the ramp.
    plain = allanfit.fit_many(samples - 1e-4 * jnp.arange(SAMPLES) / RATE_HZ, RATE_HZ)
    np.testing.assert_allclose(fits.least_squares["B"], plain.least_squares["B"], rtol=1e-5)


def test_rate_and_unit_scale_the_coefficients():
    x = records(GYRO, 1)[0]
    one = allanfit.fit(x, RATE_HZ)
    other = allanfit.fit(1000 * x, 4 * RATE_HZ)
    for symbol, power in zip(SYMBOLS, (1, 0.5, 0, -0.5, -1), strict=True):
        np.testing.assert_allclose(
            other.least_squares[symbol], 1000 * 0.25**power * one.least_squares[symbol], rtol=1e-5
        )


def test_gradient_with_respect_to_the_samples_is_the_finite_difference():
    x = records(GYRO, 1, seed=4)[0]
    direction = x * jnp.sin(jnp.arange(SAMPLES) / RATE_HZ)

    def coefficients(series):
        found = allanfit.fit(series, RATE_HZ).coefficients
        return jnp.stack([found["N"], found["B"]])

    def least_squares(series):
        found = allanfit.fit(series, RATE_HZ).least_squares
        return np.stack([found["N"], found["B"]])

    slopes = jax.jacrev(coefficients)(x) @ direction
    step = 1e-3
    forward, backward = least_squares(x + step * direction), least_squares(x - step * direction)
    np.testing.assert_allclose(slopes, (forward - backward) / (2 * step), rtol=1e-3)


def test_fit_works_under_jit_and_is_repeatable():
    x = records(GYRO, 1)[0]
    jitted = jax.jit(lambda series: allanfit.fit(series, RATE_HZ).least_squares["N"])(x)
    np.testing.assert_allclose(jitted, allanfit.fit(x, RATE_HZ).least_squares["N"], rtol=1e-6)
    again = allanfit.fit(x, RATE_HZ, seed=0)
    assert bool(jnp.all(again.estimate.draws == allanfit.fit(x, RATE_HZ).estimate.draws))


def test_gaps_are_left_out_and_do_not_bias():
    """A jump across a gap is not seen; what each stretch says is.

    Limits of more than three standard errors, which are 0.6 % of N and 10 % of B.
    """
    x = np.array(records(GYRO | {"K": 0.0}, 2, seed=2))
    x[1] += 5.0
    x = np.concatenate([x[0], np.full(20, np.nan), x[1]])
    stretches = ((0, SAMPLES), (SAMPLES + 20, len(x)))
    fit = allanfit.fit(x, RATE_HZ, stretches=stretches)
    assert bool(fit.converged)
    np.testing.assert_allclose(fit.coefficients["N"], GYRO["N"], rtol=0.02)
    np.testing.assert_allclose(fit.coefficients["B"], GYRO["B"], rtol=0.35)


@pytest.mark.parametrize("unit", [1.0, 1e-7, 1e6])
def test_float32_agrees_with_float64(unit):
    """In any unit: without its own, float32 has no squares of the powers of rad/s."""
    x = np.asarray(records(GYRO, 1)[0])
    wide = allanfit.fit(x, RATE_HZ)
    widths = {symbol: float(jnp.diff(wide.intervals[symbol])[0]) for symbol in "NBK"}
    values = {symbol: float(wide.coefficients[symbol]) for symbol in "NBK"}
    solved = {symbol: float(wide.least_squares[symbol]) for symbol in "NBK"}
    with jax.enable_x64(False):
        narrow = allanfit.fit((unit * x).astype(np.float32), RATE_HZ)
        assert narrow.estimate.draws.dtype == jnp.float32
        for symbol in "NBK":
            width = float(jnp.diff(narrow.intervals[symbol])[0]) / unit
            median = float(narrow.coefficients[symbol]) / unit
            assert abs(median - values[symbol]) < 0.1 * width, symbol
            assert abs(width / widths[symbol] - 1) < 0.2, symbol
            # Least squares has no chance in it: within a twentieth of a standard error.
            apart = abs(float(narrow.least_squares[symbol]) / unit - solved[symbol])
            assert apart < 0.05 * width / 3.92, symbol


@pytest.mark.parametrize("kind", [np.asarray, jnp.asarray])
def test_single_precision_is_computed_in_double_where_that_is_on(kind):
    """To the last digit, or the values would have been rounded on the way."""
    x = (np.asarray(records(GYRO, 1)[0]) + 9.81).astype(np.float32)
    given, wide = (allanfit.fit(kind(each), RATE_HZ) for each in (x, x.astype(float)))
    for a, b in zip(jax.tree.leaves(given), jax.tree.leaves(wide), strict=True):
        np.testing.assert_array_equal(a, b)
    shares = [allanfit.influence(wide, kind(each)).share for each in (x, x.astype(float))]
    np.testing.assert_array_equal(*shares)


def test_large_mean_survives_without_x64():
    x = np.asarray(records(GYRO, 1)[0])
    with jax.enable_x64(False):
        biased = allanfit.fit(x + 1e6, RATE_HZ).least_squares["N"]
        plain = allanfit.fit(x, RATE_HZ).least_squares["N"]
    np.testing.assert_allclose(biased, plain, rtol=1e-4)


@pytest.mark.parametrize(
    ("data", "rate_hz", "message"),
    [
        (np.zeros((2, 3, 4)), 100.0, "shape"),
        (np.zeros((2, 300)), 100.0, "fit_many"),
        (np.zeros(100), 100.0, "at least 256 samples"),
        (np.zeros(1000), -1.0, "positive"),
        (np.zeros(1000), None, "needs rate_hz"),
        (np.zeros(1000, complex), 100.0, "real numbers"),
    ],
)
def test_bad_arrays_are_refused(data, rate_hz, message):
    with pytest.raises(ValueError, match=message):
        allanfit.fit(data, rate_hz)


def test_words_and_numbers_that_mean_nothing_are_refused():
    with pytest.raises(ValueError, match="sampling must be 'point' or 'averaged'; got 'Point'"):
        check_sampling("Point")
    found = allanfit.fit(np.random.default_rng(1).standard_normal(512), 100.0)
    for probability in (95.0, 0.0, -1.0):
        with pytest.raises(ValueError, match="between 0 and 1"):
            found.interval(probability)
    # As of traced data, which is not refused.
    failed = eqx.tree_at(lambda fit: fit.estimate.converged, found, jnp.zeros((), bool))
    with pytest.raises(ValueError, match="did not converge"):
        allanfit.sample(failed)


def _changed(value, *, of=slice(None)):
    data = np.random.default_rng(1).standard_normal(600)
    data[of] = value
    return data


@pytest.mark.parametrize(
    ("data", "stretches", "message"),
    [
        (_changed(np.nan, of=[7, 9]), None, "2 of 600 values .* NaN or infinite, .* at index 7:"),
        (_changed(np.inf, of=420), ((0, 300), (350, 600)), "1 of 250 values .* at index 420:"),
        (_changed(0.1), None, "data is constant"),
        (_changed(0.0), ((0, 300), (350, 600)), "data is constant"),
        (_changed(9.81).tolist(), None, "data is constant"),
    ],
)
def test_values_without_noise_are_refused(data, stretches, message):
    with pytest.raises(ValueError, match=message):
        allanfit.fit(data, 100.0, stretches=stretches)
    with pytest.raises(ValueError, match=message):
        allanfit.fit(jnp.asarray(data), 100.0, stretches=stretches)


def test_values_that_are_not_used_or_not_known_are_not_refused():
    stretches = ((0, 300), (350, 600))
    data = _changed(np.nan, of=slice(300, 350))
    assert bool(allanfit.fit(data, 100.0, stretches=stretches).converged)
    traced = jax.eval_shape(lambda x: allanfit.fit(x, 100.0).least_squares["N"], data)
    assert traced.shape == ()


def test_a_batch_has_no_document():
    fits = allanfit.fit_many(np.random.default_rng(0).standard_normal((2, 512)), 10.0)
    with pytest.raises(ValueError, match="the fit of 2 sensors, and a document is of one"):
        fits.to_dict()


def test_document_and_table_of_an_array(monkeypatch):
    fit = allanfit.fit(records(GYRO, 1)[0], RATE_HZ)
    document = fit.to_dict("gyro_x", "deg/s")
    (channel,) = document["channels"]
    assert document["schema"] == "allanfit.fit/1"
    assert channel["channel"] == "gyro_x"
    assert channel["coefficients"]["N"]["unit"] == "deg/s/sqrt(Hz)"
    assert channel["coefficients"]["Q"]["intervals"]["0.95"][0] == 0.0
    assert channel["coefficients"]["Q"]["upper_limit_95"] > 0
    sizes = np.round(np.array(channel["curves"]["allan"]["tau_s"]) * RATE_HZ).astype(int)
    assert {2**k for k in range(12)} <= set(sizes)
    # A notebook shows each result that ends a cell: no advice for that, which takes seconds.
    monkeypatch.delattr("allanfit.identify._recording_fit.ChannelFit.advice")
    assert "data, 10 Hz, 13.7 min: 95 % intervals" in fit._repr_html_()


def test_a_fit_on_the_host_is_that_of_a_compiled_program(monkeypatch):
    (data,) = records(GYRO, 1)
    host = allanfit.fit(data, RATE_HZ)
    monkeypatch.setattr(_estimate, "_MOST_ON_HOST", SAMPLES - 1)
    compiled = allanfit.fit(data, RATE_HZ)
    # Two ways to sum, and not one of them twice.
    assert not np.array_equal(
        compiled.estimate.statistics.density, host.estimate.statistics.density
    )
    for symbol, value in compiled.least_squares.items():
        assert float(host.least_squares[symbol]) == pytest.approx(float(value), rel=1e-6)
