import jax
import jax.numpy as jnp
import numpy as np
import pytest

import allanfit
from allanfit.curves import read_slopes, slope_reading

TAU = 0.01 * 2.0 ** np.arange(25)  # a point lies at no time that a standard reads at
# IEEE Std 952-1997, annex C: Allan variances of the five terms.
VARIANCES = {
    "Q": lambda c, tau: 3 * c**2 / tau**2,
    "N": lambda c, tau: c**2 / tau,
    "B": lambda c, tau: c**2 * 2 * np.log(2) / np.pi * np.ones_like(tau),
    "K": lambda c, tau: c**2 * tau / 3,
    "R": lambda c, tau: c**2 * tau**2 / 2,
}


def read(**coefficients: float) -> dict[str, float]:
    variance = sum(VARIANCES[symbol](value, TAU) for symbol, value in coefficients.items())
    found = read_slopes(jnp.asarray(TAU), jnp.sqrt(jnp.asarray(variance)))
    return {symbol: float(value) for symbol, value in found.items()}


@pytest.mark.parametrize("symbol", VARIANCES)
def test_the_curve_of_one_term_gives_its_coefficient_and_no_other(symbol):
    found = read(**{symbol: 0.037})
    assert found.pop(symbol) == pytest.approx(0.037, rel=1e-9)
    assert np.isnan(list(found.values())).all()


def test_terms_far_apart_are_read_within_a_few_per_cent():
    found = read(Q=1e-3, N=5e-3, K=1e-5)
    assert found["Q"] == pytest.approx(1e-3, rel=0.05)
    assert found["N"] == pytest.approx(5e-3, rel=0.02)
    assert found["K"] == pytest.approx(1e-5, rel=0.05)


def test_neighbours_lift_the_flat_part_by_half():
    # At the floor of N and K alone, 2 N K/sqrt(3), there is no bias instability at all.
    n, k = 5e-3, 1e-4
    floor = np.sqrt(2 * n * k / np.sqrt(3))
    assert read(N=n, K=k)["B"] == pytest.approx(floor / np.sqrt(2 * np.log(2) / np.pi), rel=0.03)
    assert read(N=n, B=1e-3, K=k)["B"] > 1.3e-3


def read_of_slopes(*slopes):
    """The reading of a curve from 1 at the first time, of these slopes from each time to the next.

    A local slope is the mean of both beside it.
    """
    deviation = 2.0 ** np.concatenate([[0.0], np.cumsum(slopes)])
    found = read_slopes(jnp.asarray(TAU[: len(deviation)]), jnp.asarray(deviation))
    return {symbol: float(value) for symbol, value in found.items()}


def test_a_fall_right_of_the_white_noise_is_no_quantization_noise():
    white = [-0.5] * 6
    flat = [-0.2, 0.0, 0.0]
    found = read_of_slopes(*white, *flat, -1.0, -1.0)
    assert found["N"] == pytest.approx(np.sqrt(TAU[0]), rel=1e-9)
    assert found["B"] == pytest.approx(2.0**-3.2 / np.sqrt(2 * np.log(2) / np.pi), rel=1e-9)
    assert np.isnan([found["Q"], found["K"], found["R"]]).all()
    # Not even if white noise follows again, or nothing is in between.
    assert read_of_slopes(*white, -1.0, -1.0, -0.5, -0.5)["N"] == found["N"]
    for end in ([-1.0, -1.0, -0.5, -0.5], [-1.0, -1.0]):
        assert np.isnan(read_of_slopes(*white, *end)["Q"])


def test_lines_are_read_in_the_order_of_their_slopes():
    white, walk = [-0.5] * 6, [0.5] * 4
    # The flat part at the end is flatter than that between the two, which is B's.
    found = read_of_slopes(*white, -0.3, 0.1, *walk, 0.0, 0.0)
    assert found["B"] == pytest.approx(2.0**-3.3 / np.sqrt(2 * np.log(2) / np.pi), rel=1e-9)
    place = 2.0 ** (-3.2 + 0.5)
    assert found["K"] == pytest.approx(place * np.sqrt(3 / TAU[9]), rel=1e-9)
    # A rise before the white noise, as a filter makes, is no walk.
    found = read_of_slopes(*walk, *white, *white)
    assert np.isnan([found["B"], found["K"], found["R"]]).all()


def test_simulated_sensors_show_the_bias():
    truth = {"N": 5e-3, "B": 1e-3, "K": 1e-4}
    records = np.stack(
        [allanfit.simulate(truth, duration_s=1800.0, rate_hz=10.0, seed=seed) for seed in range(12)]
    )
    found = {symbol: np.asarray(value) for symbol, value in slope_reading(records, 10.0).items()}
    # N is good to 2 % here: 12 means miss it by more in 1 of 1e5 runs.
    assert found["N"] == pytest.approx(5e-3, rel=0.1)
    assert np.mean(found["N"]) == pytest.approx(5e-3, rel=0.02)
    # B is read 1.2 to 2 times too high in nearly every record, K often not at all.
    assert np.nanmedian(found["B"]) > 1.2e-3
    assert np.nanmax(found["B"]) < 3e-3
    assert np.isnan(found["Q"]).all()


def test_a_batch_is_its_sensors_one_by_one_also_in_jit():
    data = np.random.default_rng(0).standard_normal((3, 500)).cumsum(axis=1)
    together = jax.jit(slope_reading, static_argnums=1)(jnp.asarray(data), 50.0)
    for sensor in range(3):
        alone = slope_reading(data[sensor], 50.0)
        for symbol in VARIANCES:
            np.testing.assert_allclose(together[symbol][sensor], alone[symbol], rtol=1e-9)


def test_a_dead_channel_has_no_slope():
    assert np.isnan(list(slope_reading(np.full(200, 3.0), 10.0).values())).all()


def test_bad_input_is_refused_with_a_sentence():
    with pytest.raises(ValueError, match="at least 40 samples; got 39"):
        slope_reading(np.zeros(39), 10.0)
    with pytest.raises(ValueError, match="rate_hz must be a positive"):
        slope_reading(np.zeros(100), -1.0)
    with pytest.raises(ValueError, match=r"got shape \(2, 2, 50\)"):
        slope_reading(np.zeros((2, 2, 50)), 1.0)
