"""The regression, the noise that is left, and both on simulated records."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import norm

import allanfit
from allanfit.curves import cosine_coefficients, design, mode_variances, slow_part
from allanfit.physics import standard_model
from allanfit.temperature import temperature_sensitivity
from allanfit.temperature._band import believable, error_power, highest_mode
from allanfit.temperature._regression import Modes, effects, explained, regress, share_of_ramp
from allanfit.temperature._removal import remove

RATE_HZ, SAMPLES = 10.0, 3000
TIME = np.arange(SAMPLES) / RATE_HZ
NOISE = {"N": 5e-3, "B": 1e-3, "K": 5e-4}
WARM_UP = 25 - 2 * np.exp(-TIME / 60) + 0.4 * np.sin(2 * np.pi * TIME / 90)


@jax.jit
def drawn(key, model):
    return model.sample(key, SAMPLES, 1 / RATE_HZ, "point")


def noise(seed):
    return np.asarray(drawn(jax.random.key(seed), standard_model(NOISE)))


slow_columns = jax.jit(jax.vmap(partial(slow_part, modes=60), 1, 1))


@pytest.fixture(scope="module")
def moved():
    """A record that temperature moves, its fit and the effect."""
    step = WARM_UP - WARM_UP.mean()
    data = noise(1) + 0.05 * step + 0.01 * step**2
    fit = allanfit.fit(data, RATE_HZ)
    return data, fit, temperature_sensitivity(fit, data, WARM_UP)


def test_single_precision_gives_the_effect_of_the_same_values(moved):
    data, fit, _ = moved
    x = data.astype(np.float32)
    found = [temperature_sensitivity(fit, each, WARM_UP).draws for each in (x, x.astype(float))]
    np.testing.assert_array_equal(*found)


def test_the_sensitivities_are_found(moved):
    _, fit, effect = moved
    (low, high), (low_2, high_2) = np.asarray(effect.interval(0.95))
    assert low < 0.05 < high
    assert low_2 < 0.01 < high_2
    assert low < effect.linear < high
    assert low_2 < effect.quadratic < high_2
    assert effect.resolved.tolist() == [True, True]
    assert effect.p_value < 1e-6
    assert effect.explained > 0.7 > effect.explained_by_chance
    assert (effect.low_degC, effect.high_degC) == (WARM_UP.min(), WARM_UP.max())
    assert effect.removed.coefficients["K"] < 0.6 * fit.coefficients["K"]
    low, high = effect.removed.intervals["K"]
    assert low < NOISE["K"] < high


def test_the_curve_passes_zero_at_the_mean_and_widens_away_from_it(moved):
    effect = moved[2]
    middle, band = effect.curve(np.array([effect.mean_degC, 26.0, 27.0]))
    width = np.asarray(band[:, 1] - band[:, 0])
    assert middle[0] == 0
    assert 0 == width[0] < width[1] < width[2]


def test_what_is_left_does_not_depend_on_the_sensitivity(moved):
    data, fit, _ = moved
    step = WARM_UP - WARM_UP.mean()
    column = slow_columns(np.stack([step, step**2], axis=1))
    variance = jnp.asarray(mode_variances(SAMPLES, 64))
    power = jnp.asarray([0.0, 1.0, 0.1, 1e-2])
    more = data + column @ jnp.asarray([0.3, -0.1]) + 2.0 + 1e-3 * TIME
    one, other = (
        remove((jnp.asarray(x),), (column,), (variance,), fit.design, power) for x in (data, more)
    )
    np.testing.assert_allclose(other.slopes - one.slopes, [0.3, -0.1], rtol=1e-6)
    np.testing.assert_allclose(other.statistics.density, one.statistics.density, rtol=1e-6)
    assert jax.tree.all(jax.tree.map(np.array_equal, one.design, other.design))


def test_the_same_seed_gives_the_same_numbers(moved):
    data, fit, effect = moved
    again = temperature_sensitivity(fit, data, WARM_UP)
    assert jax.tree.all(jax.tree.map(np.array_equal, effect, again))


def test_the_drift_is_what_was_taken_out(moved):
    data, _, effect = moved
    rest = allanfit.allan_variance(data - np.asarray(effect.drift), RATE_HZ)
    np.testing.assert_allclose(effect.removed.estimate.statistics.allan, rest, rtol=1e-9)


def test_gaps_divide_the_record(moved):
    data, _, effect = moved
    # Of one length, for one compilation.
    stretches = ((0, 1450), (1550, 3000))
    broken, temperature = data.copy(), WARM_UP.copy()
    broken[1450:1550] = temperature[1450:1550] = np.nan
    pieces = np.where(np.isfinite(broken), broken, 0.0)
    fit = allanfit.fit(pieces, RATE_HZ, stretches=stretches)
    found = temperature_sensitivity(fit, pieces, temperature, stretches)
    assert found.p_value < 0.01
    width = np.diff(np.asarray(effect.interval(0.95))[0])
    assert abs(found.linear - effect.linear) < 2 * width


def test_an_unrelated_walk_is_hardly_ever_blamed():
    claimed = held = 0
    for seed in range(16):
        rng = np.random.default_rng(seed)
        temperature = 25 + np.cumsum(rng.normal(size=SAMPLES)) / np.sqrt(SAMPLES)
        data = noise(100 + seed)
        fit = allanfit.fit(data, RATE_HZ)
        effect = temperature_sensitivity(fit, data, temperature)
        claimed += int(effect.p_value < 0.05)
        low, high = np.asarray(effect.interval(0.95))[0]
        held += int(low <= 0 <= high)
    # Three or fewer of 16 at 5 % in 99 of 100 studies; least squares with white noise claims 15.
    assert claimed <= 3
    assert held >= 13


def test_a_straight_rise_is_refused_and_a_nearly_straight_one_is_confounded():
    data = noise(3)
    fit = allanfit.fit(data, RATE_HZ)
    with pytest.raises(ValueError, match="evenly with time alone"):
        temperature_sensitivity(fit, data, 20 + TIME / 100)
    effect = temperature_sensitivity(fit, data, 20 + TIME / 100 + 0.05 * np.sin(TIME / 20))
    assert effect.share_of_ramp > 0.9
    wide, narrow = (np.diff(effect.interval(0.95, ramp=ramp)[0])[0] for ramp in (True, False))
    assert wide > 3 * narrow


@pytest.mark.parametrize(
    ("temperature", "message"),
    [
        (np.full(SAMPLES, 21.5), "constant at 21.5 degC"),
        (np.where(TIME < 100, 21.5, 22.0), "either 21.5 or 22 degC"),
        (np.where(TIME < 1, np.nan, WARM_UP), "not finite at 10 of 3000 samples"),
        (WARM_UP[1:], r"shape \(3000,\); got shape \(2999,\)"),
        (np.random.default_rng(0).normal(20, 0.1, SAMPLES), "own noise and rounding"),
    ],
)
def test_a_temperature_that_tells_nothing_is_refused(moved, temperature, message):
    data, fit, _ = moved
    with pytest.raises(ValueError, match=message):
        temperature_sensitivity(fit, data, temperature)
    with pytest.raises(ValueError, match="the one series that was fitted"):
        temperature_sensitivity(fit, data[:-1], WARM_UP[:-1])


def test_the_band_ends_where_the_thermometer_is_lost_in_noise():
    rng = np.random.default_rng(0)
    calm = highest_mode([WARM_UP])
    noisy = [highest_mode([WARM_UP + s * rng.normal(size=SAMPLES)]) for s in (0.01, 0.1)]
    rounded = highest_mode([np.round(WARM_UP / 0.1) * 0.1])
    assert calm > noisy[0] > noisy[1] >= 4
    assert 4 <= rounded < calm
    # Of noise, and of noise that is held.
    white = 0.1 * rng.normal(size=SAMPLES)
    assert error_power([white]) == pytest.approx(0.01, rel=0.1)
    assert error_power([np.repeat(white, 5)]) == pytest.approx(0.05, rel=0.1)


def test_a_thermometer_is_believed_as_far_as_it_is_clear_of_its_noise():
    """Some three times nearer to the truth, and no noise that would make a sensitivity small."""
    read = WARM_UP + 0.05 * np.random.default_rng(1).normal(size=SAMPLES)
    stretches = ((0, 1000), (1200, SAMPLES))
    inside = np.r_[:1000, 1200:SAMPLES]
    found = believable(read, stretches)[inside]
    assert np.std(found - WARM_UP[inside] + WARM_UP[inside].mean()) < 0.02
    # A line and its noise stay as they are.
    line = 25 + 1e-3 * TIME
    np.testing.assert_allclose(believable(line, ((0, SAMPLES),)), line - line.mean(), atol=1e-12)


def test_the_regression_is_generalised_least_squares():
    rng = np.random.default_rng(0)
    columns, variance = rng.normal(size=(30, 3)), rng.uniform(0.1, 2, (30, 4))
    power = np.array([0.1, 1.0, 2.0, 0.5])
    response = columns @ [1.0, -2.0, 0.5] + rng.normal(size=30) * np.sqrt(variance @ power)
    modes = Modes(*map(jnp.asarray, (response, columns, variance)))
    mean, covariance = map(np.asarray, jax.jit(regress)(modes, jnp.asarray(power)))
    weight = np.diag(1 / (variance @ power))
    expected = np.linalg.inv(columns.T @ weight @ columns)
    np.testing.assert_allclose(covariance, expected, rtol=1e-10)
    np.testing.assert_allclose(mean, expected @ columns.T @ weight @ response, rtol=1e-10)
    # One noise alone: the draws are normal, and tails are those of a normal variate.
    known = effects(jax.random.key(0), modes, jnp.tile(jnp.asarray(power), (4000, 1)))
    np.testing.assert_allclose(np.cov(known.draws.T), covariance[1:, 1:], rtol=0.05)
    z = mean[1:] / np.sqrt(np.diag(covariance)[1:])
    np.testing.assert_allclose(known.p_values, 2 * norm.sf(np.abs(z)), rtol=1e-9)
    same = modes._replace(columns=modes.columns.at[:, 1].set(modes.columns[:, 0] + 1e-3))
    assert share_of_ramp(same, jnp.asarray(power)) > 0.99


def test_what_is_explained_is_beside_the_straight_line_in_time():
    """A slope that makes a line, which the free ramp takes back, explains what it bends alone."""
    rng = np.random.default_rng(1)
    ramp, bend, other = rng.normal(size=(3, 40))
    columns = np.stack([ramp, 5 * ramp + bend, other], axis=1)
    variance = np.ones((40, 4))
    power = jnp.asarray([0.0, 1e-4, 0.0, 0.0])
    slow = jnp.ones(40)

    def fraction(response):
        modes = Modes(*map(jnp.asarray, (response, columns, variance)))
        part, chance = explained(jax.random.key(0), modes, slow, jnp.asarray([2.0, 0.0]), power)
        # Two of 39 modes, of white noise: rarely more than a sixth.
        assert 0.02 < chance < 0.25
        return float(part)

    assert fraction(2 * bend - 7 * ramp) == pytest.approx(1.0)
    noise = rng.normal(size=40)
    straight = np.stack([ramp], axis=1)

    def rest(x):
        return x - straight @ np.linalg.lstsq(straight, x, rcond=None)[0]

    expected = 1 - np.sum(rest(noise) ** 2) / np.sum(rest(noise + 2 * bend) ** 2)
    assert fraction(noise + 2 * bend) == pytest.approx(expected)
    assert fraction(-bend) == 0.0


def test_the_noise_left_is_expected_with_the_power_it_has():
    layout = design((1000,))
    variance = mode_variances(1000, 80)
    power = np.array([0.0, 1.0, 0.0, 3e-3])
    step = np.sin(np.arange(1000) / 90.0) + np.arange(1000) / 500
    column = slow_columns(np.stack([step, step**2], axis=1))
    # Weights for another noise than there is: efficiency suffers, expectations do not.
    weights = jnp.asarray([0.0, 1.0, 0.1, 1e-2])
    draws = np.random.default_rng(0).normal(size=(800, 1000))
    walk = np.cumsum(np.random.default_rng(1).normal(size=(800, 1000)), axis=1)
    data = jnp.asarray(draws * np.sqrt(power[1]) + walk * np.sqrt(power[3]))

    @jax.jit
    @jax.vmap
    def densities(x):
        return remove((x,), (column,), (jnp.asarray(variance),), layout, weights).statistics.density

    left = remove((data[0],), (column,), (jnp.asarray(variance),), layout, weights).design
    found = densities(data)
    error = np.std(found, axis=0) / np.sqrt(len(found))
    used = left.ordinates > 0.1
    distance = np.asarray((np.mean(found, axis=0) - left.density @ power) / error)[used]
    assert np.sqrt(np.mean(distance**2)) < 1.25
    assert np.max(np.abs(distance)) < 4.5
    assert np.sum(left.ordinates) == pytest.approx(np.sum(layout.ordinates) - 2, abs=0.05)


def test_mode_variances_and_the_slow_part():
    x = jnp.asarray(np.random.default_rng(0).normal(size=500))
    modes = jax.jit(lambda x: cosine_coefficients(slow_part(x, 20)))(x)
    np.testing.assert_allclose(modes[:20], jax.jit(cosine_coefficients)(x)[:20], atol=1e-12)
    np.testing.assert_allclose(modes[20:], 0, atol=1e-12)
    odd = design((500,)).ramp_variance[0]
    np.testing.assert_allclose(mode_variances(500, 64)[::2], odd, rtol=1e-12)
