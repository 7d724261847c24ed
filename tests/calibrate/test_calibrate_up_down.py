"""The up-down test: the paper's formulas, coverage of intervals, and what is refused."""

import dataclasses
import math

import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.calibrate import up_down

RATE_HZ, SAMPLES, GRAVITY = 10.0, 512, 9.81


def white(rng, samples=SAMPLES, coefficient=5e-3):
    return coefficient * RATE_HZ**0.5 * rng.standard_normal(samples)


def recordings(seed=0, bias=0.1, scale=0.01, samples=SAMPLES):
    rng = np.random.default_rng(seed)
    sense = (1 + scale) * GRAVITY
    return sense + bias + white(rng, samples), -sense + bias + white(rng, samples)


def test_values_are_those_of_the_two_means():
    up, down = recordings()
    found = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise={"N": 5e-3})["data"]
    a1, a2 = up.mean(), down.mean()
    assert found.bias.value == pytest.approx((a1 + a2) / 2, rel=1e-12)
    assert found.scale_factor.value == pytest.approx(
        (a1 - a2 - 2 * GRAVITY) / (2 * GRAVITY), rel=1e-9
    )
    # White noise alone: sigma over the root of the number of samples, of two means.
    error = 5e-3 / math.sqrt(2 * SAMPLES / RATE_HZ)
    low, high = found.bias.intervals["0.95"]
    assert (high - low) / 2 == pytest.approx(1.959964 * error, rel=1e-6)
    low, high = found.scale_factor.intervals["0.95"]
    assert (high - low) / 2 == pytest.approx(1.959964 * error / GRAVITY, rel=1e-6)
    assert found.to_dict()["significant"] == {"bias": True, "scale_factor": True}


def test_intervals_hold_the_truth():
    # A walk under white noise, drawn in one piece; the bias of the second half is the next one.
    # 400 trials: 380 expected, standard deviation 4.4. Beyond four of them once in 16000; this for
    # three quantities.
    walk = 2e-3
    held = np.zeros(3)
    for seed in range(400):
        rng = np.random.default_rng((1, seed))
        slow = 0.05 + walk / RATE_HZ**0.5 * np.cumsum(rng.standard_normal(4 * SAMPLES))
        up = 1.01 * GRAVITY + slow[:SAMPLES] + white(rng)
        down = -1.01 * GRAVITY + slow[SAMPLES : 2 * SAMPLES] + white(rng)
        noise = {"N": 5e-3, "K": walk}
        axis = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise=noise)["data"]
        for k, (quantity, truth) in enumerate(
            (
                (axis.bias, slow[2 * SAMPLES :].mean()),
                (axis.bias_of_these_recordings, slow[: 2 * SAMPLES].mean()),
                (axis.scale_factor, 0.01),
            )
        ):
            low, high = quantity.intervals["0.95"]
            held[k] += low <= truth <= high
    assert np.all(np.abs(held - 380) < 17.6), held


def test_a_gap_widens_what_drift_spoils():
    up, down = recordings()
    noise = {"N": 5e-3, "K": 1e-3}

    def width(gap_s, name):
        axis = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise=noise, gap_s=gap_s)["data"]
        low, high = dataclasses.asdict(axis)[name]["intervals"]["0.95"]
        return high - low

    # A walk adds K^2 times the gap to the variance of the difference of both means.
    grown = (width(600.0, "scale_factor") ** 2 - width(0.0, "scale_factor") ** 2) / 4
    expected = (1.959964 * 1e-3 / (2 * GRAVITY)) ** 2 * 600.0
    assert grown == pytest.approx(expected, rel=1e-5)
    same = "bias_of_these_recordings"
    assert width(600.0, same) == pytest.approx(width(0.0, same), rel=1e-9)


def test_fitted_noise_knows_the_white_noise_and_doubts_the_rest():
    up, down = recordings(samples=2048)
    found = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY)["data"]
    stated = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise={"N": 5e-3})["data"]

    def ratio(quantity, other):
        (low, high), (least, most) = quantity.intervals["0.95"], other.intervals["0.95"]
        return (high - low) / (most - least)

    # N is told to 2 % by 4096 samples, and to less by a posterior that grants some Q.
    recorded = ratio(found.bias_of_these_recordings, stated.bias_of_these_recordings)
    assert recorded == pytest.approx(1.0, abs=0.1)
    # Drift slower than the recordings cannot be excluded by them.
    assert 1.2 < ratio(found.scale_factor, stated.scale_factor) < 8
    assert 1.5 < ratio(found.bias, stated.bias) < 25


def test_three_axes_of_which_one_was_turned_over():
    up, down = recordings()
    rng = np.random.default_rng(3)
    # A level axis on a tilted table reads a little of gravity, turned over with it.
    level = np.stack([0.3 + white(rng), 0.2 + white(rng)], axis=1)
    other = np.stack([-0.3 + white(rng), 0.2 + white(rng)], axis=1)
    found = up_down(
        np.column_stack([level, up]),
        np.column_stack([other, down]),
        rate_hz=RATE_HZ,
        gravity=GRAVITY,
        noise={"N": 5e-3},
    )
    assert list(found.axes) == ["z"]
    assert any("not turned over: x, y" in each for each in found.findings)


def test_columns_of_the_two_recordings_may_stand_in_another_order(tmp_path):
    up, down = recordings()
    rng = np.random.default_rng(3)
    level = [0.2 + white(rng), 0.3 + white(rng)]
    np.savez(tmp_path / "up.npz", accel_x=level[0], accel_z=up, rate_hz=RATE_HZ)
    np.savez(tmp_path / "down.npz", accel_z=down, accel_x=level[1], rate_hz=RATE_HZ)
    found = up_down(tmp_path / "up.npz", tmp_path / "down.npz", gravity=GRAVITY, noise={"N": 5e-3})
    alone = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise={"N": 5e-3})
    assert list(found.axes) == ["accel_z"]
    assert found["accel_z"].bias.value == pytest.approx(alone["data"].bias.value)


def test_units_come_back_as_they_were_given():
    up, down = recordings()
    in_metres = up_down(up, down, rate_hz=RATE_HZ, gravity=GRAVITY, noise={"N": 5e-3})["data"]
    g = 9.80665
    in_g = up_down(
        up / g, down / g, rate_hz=RATE_HZ, gravity=GRAVITY, unit="g", noise={"N": 5e-3 / g}
    )["data"]
    assert in_g.bias.unit == "g"
    assert in_g.bias.value * g == pytest.approx(in_metres.bias.value, rel=1e-9)
    np.testing.assert_allclose(
        np.array(in_g.bias.intervals["0.95"]) * g, in_metres.bias.intervals["0.95"], rtol=1e-9
    )
    np.testing.assert_allclose(
        in_g.scale_factor.intervals["0.95"], in_metres.scale_factor.intervals["0.95"], rtol=1e-9
    )


@pytest.mark.parametrize("like", [list, jnp.asarray])
def test_samples_may_be_in_any_array_or_list(like):
    up, down = recordings()
    given = {"rate_hz": RATE_HZ, "gravity": GRAVITY, "noise": {"N": 5e-3}}
    bias = up_down(like(up), like(down), **given)["data"].bias
    assert bias.value == pytest.approx(up_down(up, down, **given)["data"].bias.value, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda up, down: (down, up), {}, "the two are swapped"),
        (lambda up, down: (up, up.copy()), {}, "the same recording"),
        (lambda up, down: (up, up + 0.01), {}, "was not turned over"),
        (lambda up, down: (up / 9.8, down / 9.8), {}, "give --unit g"),
        (lambda up, down: (up, down), {"unit": "rad/s"}, "test is one of accelerometers"),
        (lambda up, down: (up, np.stack([down] * 3, axis=1)), {}, "must be the same"),
        (lambda up, down: (up, down), {"gravity": 1.0}, r"not in g"),
        (lambda up, down: (up, down), {"gravity": math.nan}, "--gravity is nan"),
        (lambda up, down: (up, down), {"gap_s": -1.0}, "zero or more seconds"),
        (lambda up, down: (up, down), {"rate_hz": None}, "needs rate_hz"),
        (lambda up, down: (up, np.where(down > down.mean(), np.nan, down)), {}, "not finite"),
        (lambda up, down: (up, ["a", "b"]), {}, "must hold real numbers; got <U1"),
        (lambda up, down: (up, [[1.0], [2.0, 3.0]]), {}, "must be equally long"),
        (lambda up, down: (up, down), {"noise": {"N": -1.0}}, "noise holds N"),
        (lambda up, down: (up, down), {"noise": {"N": 0.0}}, "noise is all zero"),
    ],
)
def test_refusals(change, options, message):
    given = {"rate_hz": RATE_HZ, "noise": {"N": 5e-3}, **options}
    with pytest.raises(ValueError, match=message):
        up_down(*change(*recordings()), **given)
