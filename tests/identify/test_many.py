"""`fit_many`: groups, devices, arrays on disk, broken sensors."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import allanfit
from allanfit.identify import _many
from allanfit.physics import SYMBOLS, standard_model

SAMPLES, RATE_HZ = 8192, 50.0


@pytest.fixture(scope="module")
def batch():
    """Eighteen sensors, so that a second group is begun and not filled."""
    model = standard_model({"N": 5e-3, "B": 2e-3, "K": 1e-3})
    keys = jax.random.split(jax.random.key(11), 18)
    sample = jax.jit(jax.vmap(lambda key: model.sample(key, SAMPLES, 1 / RATE_HZ, "point")))
    return np.asarray(sample(keys))


@pytest.fixture(scope="module")
def together(batch):
    return allanfit.fit_many(batch, RATE_HZ)


def assert_same(one, other, rows=slice(None)):
    for a, b in zip(jax.tree.leaves(one.estimate), jax.tree.leaves(other.estimate), strict=True):
        np.testing.assert_array_equal(np.asarray(a)[rows], np.asarray(b)[rows])


def test_a_sensor_has_the_same_coefficients_alone(batch, together):
    """The last sensor, from the group that was filled up."""
    alone = allanfit.fit(batch[-1], RATE_HZ)
    for symbol in SYMBOLS:
        found = together.least_squares[symbol][-1]
        np.testing.assert_allclose(found, alone.least_squares[symbol], rtol=1e-6, atol=1e-12)
    assert together.estimate.draws.shape[0] == 18


def test_quantiles_are_those_of_numpy(together):
    """Of all draws, and of those in which what is not resolved is small, whichever lie wider."""
    draws = np.abs(np.asarray(together.estimate.draws))
    seen = np.asarray(together.estimate.resolved)
    ends = np.quantile(draws, [0.16, 0.84], axis=1)
    for sensor, unseen in zip(range(len(draws)), ~seen, strict=True):
        for i in range(5):
            used = np.ones(draws.shape[1], bool)
            for other in {0, 1, 2, 3} - {i}:
                column = draws[sensor, :, other]
                used &= ~unseen[other] | (column <= np.quantile(column, 1 / 3))
            low, high = np.quantile(draws[sensor, used, i], [0.16, 0.84])
            ends[0, sensor, i] = min(low, ends[0, sensor, i])
            ends[1, sensor, i] = max(high, ends[1, sensor, i])
    assert np.any(~seen[:, :4])
    unresolved_q = ~seen[:, :1]
    half = np.where(
        draws[..., :1] <= np.median(draws[..., :1], axis=1, keepdims=True), draws, np.nan
    )
    value = np.where(unresolved_q, np.nanmedian(half, axis=1), np.median(draws, axis=1))
    value[:, 0] = np.median(draws[..., 0], axis=1)
    for i, symbol in enumerate(SYMBOLS):
        low, high = together.interval(0.68)[symbol].T
        np.testing.assert_allclose(high, ends[1, :, i], rtol=1e-12)
        np.testing.assert_allclose(low, np.where(seen[:, i], ends[0, :, i], 0.0), rtol=1e-12)
        np.testing.assert_allclose(together.coefficients[symbol], value[:, i], rtol=1e-9)


def test_only_groups_at_work_leave_an_array_on_disk(batch, together, tmp_path, monkeypatch):
    """A mapped file gives the numbers of the array, and no more than a group is asked of it."""
    path = tmp_path / "batch.npy"
    np.save(path, batch)
    asked = []

    def as_series(data, rate_hz):
        asked.append(len(data))
        return original(data, rate_hz)

    original = _many.as_series
    monkeypatch.setattr(_many, "as_series", as_series)
    assert_same(allanfit.fit_many(np.load(path, mmap_mode="r"), RATE_HZ), together)
    assert max(asked) == 16


def test_single_precision_on_disk_is_computed_in_double_group_by_group(
    batch, tmp_path, monkeypatch
):
    path = tmp_path / "batch.npy"
    np.save(path, batch.astype(np.float32))
    asked = []
    original = _many.as_series
    monkeypatch.setattr(
        _many, "as_series", lambda *given: asked.append(given[0]) or original(*given)
    )
    found = allanfit.fit_many(np.load(path, mmap_mode="r"), RATE_HZ)
    assert {(each.dtype.name, len(each)) for each in asked} == {("float32", 1), ("float32", 16)}
    assert_same(found, allanfit.fit_many(batch.astype(np.float32).astype(float), RATE_HZ))


@pytest.mark.parametrize("kind", [np.float32, np.int16])
def test_codes_of_any_kind_are_as_good_where_quantization_rules(kind):
    """The ends are evened by parts of a code."""
    steps = 0.37 + 0.01 * np.random.default_rng(3).standard_normal((2, SAMPLES))
    codes = np.diff(np.rint(np.cumsum(steps, axis=1)), axis=1, prepend=0.0)
    evened = allanfit.fit_many(codes, RATE_HZ)
    assert evened.resolved["Q"].all()
    assert_same(allanfit.fit_many(codes.astype(kind), RATE_HZ), evened)


@pytest.mark.parametrize("broken", [np.nan, np.inf])
def test_a_broken_sensor_leaves_the_others(batch, together, broken):
    spoilt = batch.copy()
    spoilt[3, 100] = broken
    spoilt[5] = 0.1
    found = allanfit.fit_many(spoilt, RATE_HZ)
    whole = ~np.isin(np.arange(18), (3, 5))
    assert found.converged.tolist() == whole.tolist()
    assert np.isfinite(found.coefficients["N"]).tolist() == whole.tolist()
    assert_same(found, together, whole)


def test_a_batch_may_be_traced(batch):
    def coefficient(x):
        return allanfit.fit_many(x, RATE_HZ).least_squares["N"]

    slopes = jax.eval_shape(jax.jacrev(coefficient), batch[:3])
    assert slopes.shape == (3, 3, SAMPLES)


def test_lists_are_arrays_and_other_shapes_are_refused(batch):
    with pytest.raises(ValueError, match=r"shape \(sensors, samples\); got \(8192,\)"):
        allanfit.fit_many(batch[0], RATE_HZ)
    with pytest.raises(ValueError, match="at least 256 samples"):
        allanfit.fit_many(np.zeros((2, 100)), RATE_HZ)
    with pytest.raises(ValueError, match="positive"):
        allanfit.fit_many(batch, -1.0)


_ON_FOUR = """
import sys
import jax
import numpy as np
jax.config.update("jax_enable_x64", True)
import allanfit
from allanfit.identify import _many
from tests.identify.test_many import moments
assert jax.device_count() == 4
_many.conclude = moments
fits = allanfit.fit_many(np.load(sys.argv[1]), 50.0)
np.savez(sys.argv[2], *jax.tree.leaves(fits.estimate))
"""


def moments(data, ramp, dt, key):
    """What can be had without a fit, and soon compiled: a place for all that a fit gives."""
    mean, chance = jnp.mean(data.density), jax.random.normal(key, (3, 5))
    slope = jnp.sum(ramp.odd_modes)
    return {
        "least_squares": jnp.append(mean * jnp.arange(4), slope),
        "draws": mean + chance,
        "deviance_rise": mean * jnp.ones(4),
        "converged": jnp.isfinite(slope),
        **dict.fromkeys(("deviance", "quantization_score", "acceptance"), mean / dt),
        **dict.fromkeys(("ramp_p_value", "goodness_of_fit"), chance[0, 0]),
    }


def test_four_devices_give_the_numbers_of_one(batch, tmp_path, monkeypatch):
    """Two groups, on the first two devices of four."""
    flags = f"{os.environ['XLA_FLAGS']} --xla_force_host_platform_device_count=4"
    monkeypatch.setenv("XLA_FLAGS", flags)
    source, result = tmp_path / "batch.npy", tmp_path / "fits.npz"
    np.save(source, batch)
    subprocess.run(
        [sys.executable, "-c", _ON_FOUR, str(source), str(result)],
        check=True,
        cwd=Path(__file__).parents[2],
    )
    monkeypatch.setattr(_many, "conclude", moments)
    # Another function, lest JAX remember what it traced with the true conclusion.
    conclude_group = _many._conclude_group.__wrapped__
    monkeypatch.setattr(_many, "_conclude_group", jax.jit(lambda *args: conclude_group(*args)))
    on_one = allanfit.fit_many(batch, RATE_HZ)
    with np.load(result) as stored:
        leaves = jax.tree.leaves(on_one.estimate)
        for name, leaf in zip(stored.files, leaves, strict=True):
            np.testing.assert_array_equal(stored[name], np.asarray(leaf))
