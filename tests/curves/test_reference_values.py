"""Against values that nobody here made: published sets, Stable32, allantools, SciPy."""

from itertools import pairwise

import allantools
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import periodogram

import allanfit


def nbs14():
    """The 1000-point set of NIST SP 1065, section 12.4."""
    numbers = [1234567890]
    while len(numbers) < 1000:
        numbers.append(16807 * numbers[-1] % 2147483647)
    return np.array(numbers) / 2147483647


def test_nbs14_overlapping():
    found = np.sqrt(allanfit.allan_variance(nbs14(), 1.0, [1, 10, 100]))
    np.testing.assert_allclose(found, [2.922319e-1, 9.159953e-2, 3.241343e-2], rtol=2e-7)


def test_nbs14_cluster_by_cluster():
    found = np.sqrt(allanfit.allan_variance(nbs14(), 1.0, [1, 10, 100], overlapping=False))
    np.testing.assert_allclose(found, [2.922319e-1, 9.965736e-2, 3.897804e-2], rtol=2e-7)


@pytest.mark.parametrize(
    ("clock", "table", "tolerance"),
    [
        ("clock_gps1pps", "gps_stable32_OADEV_octave", 5e-5),
        ("clock_cs5071a", "Cs5071A_oadev_decade", 5e-5),
        # The data as stored differ from what Stable32 read: allantools finds what we find.
        ("clock_ocxo", "ocxo_oadev_octave", 2e-3),
    ],
)
def test_stable32_overlapping_tables(shared, clock, table, tolerance):
    data = np.load(shared / "recordings" / f"{clock}.npz")["frequency_offset"]
    rows = np.loadtxt(shared / "recordings" / "stable32" / f"{table}.txt")
    found = np.sqrt(allanfit.allan_variance(data, 1.0, rows[:, 0].astype(int)))
    np.testing.assert_allclose(found, rows[:, -2], rtol=tolerance)


@pytest.mark.parametrize(
    ("clock", "table"),
    [("clock_gps1pps", "gps_stable32_ADEV_decade"), ("clock_cs5071a", "Cs5071A_adev_decade")],
)
def test_stable32_plain_tables(shared, clock, table):
    """Stable32 drops a last partial cluster; ours counts it, so that it is cut off before."""
    data = np.load(shared / "recordings" / f"{clock}.npz")["frequency_offset"]
    for row in np.loadtxt(shared / "recordings" / "stable32" / f"{table}.txt"):
        n = int(row[0])
        whole = data[: len(data) // n * n]
        (found,) = allanfit.allan_variance(whole, 1.0, [n], overlapping=False)
        np.testing.assert_allclose(np.sqrt(found), row[-2], rtol=5e-5)


@pytest.mark.parametrize("axis", ["Gyro_X", "Gyro_Z", "Accel_X"])
def test_published_curves_of_the_adis16405(shared, axis):
    curves = np.load(shared / "recordings" / "published_allan_curves.npz")
    samples = np.load(shared / "recordings" / "adis16405_a.npz")[axis.lower()]
    sizes = np.rint(curves[f"adis__{axis}__tau"] * 100).astype(int)
    inside = 2 * sizes <= len(samples)
    found = allanfit.allan_variance(samples, 100.0, sizes[inside])
    np.testing.assert_allclose(found, curves[f"adis__{axis}__avar"][inside], rtol=1e-5)


def test_allantools_on_a_walk():
    rng = np.random.default_rng(0)
    data = rng.normal(size=20_000) + np.cumsum(rng.normal(size=20_000)) / 10
    sizes = np.array([1, 2, 3, 5, 17, 100, 999, 6000])
    _, deviation, _, _ = allantools.oadev(data, rate=1.0, data_type="freq", taus=sizes)
    np.testing.assert_allclose(
        allanfit.allan_variance(data, 1.0, sizes), np.array(deviation) ** 2, rtol=1e-9
    )


def test_cluster_estimator_is_the_plain_loop_with_its_partial_cluster():
    data = np.random.default_rng(1).normal(size=103)
    for n in (1, 2, 7, 10, 50):
        means = [np.mean(data[i : i + n]) for i in range(0, 103, n)]
        expected = sum((b - a) ** 2 for a, b in pairwise(means))
        (found,) = allanfit.allan_variance(data, 1.0, [n], overlapping=False)
        np.testing.assert_allclose(found, expected / (2 * (len(means) - 1)), rtol=1e-12)


@pytest.mark.parametrize("samples", [1000, 1001])
@pytest.mark.parametrize(("taper", "window"), [("hann", "hann"), ("none", "boxcar")])
def test_ordinates_are_those_of_scipy(samples, taper, window):
    data = np.random.default_rng(2).normal(size=samples) + 7
    frequency, density = periodogram(data, fs=50.0, window=window, detrend="constant")
    found = allanfit.psd(data, 50.0, taper=taper, bins_per_decade=None)
    np.testing.assert_allclose(found.frequency, frequency[1:], rtol=1e-12)
    np.testing.assert_allclose(found.density, density[1:], rtol=1e-9, atol=1e-18)


def test_mirror_ordinates_hold_the_variance():
    data = np.random.default_rng(3).normal(size=1001).cumsum()
    found = allanfit.psd(data, 50.0, bins_per_decade=None)
    spacing = 50.0 / (2 * 1001)
    np.testing.assert_allclose(np.sum(found.density) * spacing, np.var(data), rtol=1e-12)


def test_bins_average_all_ordinates_once():
    data = np.random.default_rng(4).normal(size=5000)
    every = allanfit.psd(data, 10.0, bins_per_decade=None)
    binned = allanfit.psd(data, 10.0, bins_per_decade=8)
    assert int(jnp.sum(binned.ordinates)) == len(every.density)
    total = jnp.sum(binned.density * binned.ordinates)
    np.testing.assert_allclose(total, jnp.sum(every.density), rtol=1e-12)
    start = int(jnp.sum(binned.ordinates[:-1]))
    np.testing.assert_allclose(binned.density[-1], jnp.mean(every.density[start:]), rtol=1e-12)


def test_plain_periodogram_doubles_a_random_walk_and_the_mirror_does_not():
    """800 walks, 10 ordinates: standard error 1.2 %, tolerance four of them."""
    walks = np.random.default_rng(5).normal(size=(800, 512)).cumsum(axis=1)
    for taper, factor in (("none", 2.0), ("mirror", 1.0)):
        found = allanfit.psd(walks, 1.0, taper=taper, bins_per_decade=None)
        density = 0.5 / np.sin(np.pi * np.asarray(found.frequency)) ** 2
        ratio = np.mean(np.asarray(found.density)[:, 4:14] / density[4:14])
        np.testing.assert_allclose(ratio, factor, rtol=0.06)


def test_a_bias_of_a_million_changes_nothing():
    data = np.random.default_rng(6).normal(size=100_000)
    plain = allanfit.allan_variance(data, 1.0)
    biased = allanfit.allan_variance(data + 1e6, 1.0)
    np.testing.assert_allclose(biased, plain, rtol=1e-9)


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.float16, list])
def test_whole_and_short_numbers_are_as_good_as_long_ones(kind):
    """Codes about a large mean, which single precision and 32 bits drown or wrap."""
    codes = np.random.default_rng(5).integers(-300, 300, 4000)
    shifted = codes if kind is np.float16 else codes + 2**30
    given = shifted.tolist() if kind is list else shifted.astype(kind)
    expected = allanfit.allan_variance(codes.astype(float), 1.0, [1, 16])
    for wide in (True, False):
        with jax.enable_x64(wide):
            found = allanfit.allan_variance(given, 1.0, [1, 16])
        np.testing.assert_allclose(found, expected, rtol=1e-12 if wide else 1e-5)


def test_float32_agrees_on_a_million_samples():
    rng = np.random.default_rng(7)
    data = rng.normal(size=1_000_000) + np.cumsum(rng.normal(size=1_000_000)) / 10
    sizes = np.array([1, 7, 1000, 300_000])
    wide = np.asarray(allanfit.allan_variance(data, 1.0, sizes))
    with jax.enable_x64(False):
        narrow = allanfit.allan_variance(data.astype(np.float32), 1.0, sizes)
        assert narrow.dtype == jnp.float32
        np.testing.assert_allclose(np.asarray(narrow, np.float64), wide, rtol=1e-5)


def test_curves_under_vmap_jit_and_grad():
    data, direction = np.split(np.random.default_rng(9).normal(size=(4, 400)), [3])
    data, direction = jnp.asarray(data), direction[0]
    sizes = [1, 3, 50]
    together = allanfit.allan_variance(data, 1.0, sizes)
    alone = np.stack([allanfit.allan_variance(x, 1.0, sizes) for x in data])
    np.testing.assert_allclose(together, alone, rtol=1e-12)
    np.testing.assert_allclose(
        jax.jit(lambda x: allanfit.psd(x, 1.0).density)(data),
        np.stack([allanfit.psd(x, 1.0).density for x in data]),
        rtol=1e-9,
    )
    for curve in (
        lambda x: jnp.sum(jnp.log(allanfit.allan_variance(x, 1.0, sizes))),
        lambda x: jnp.sum(jnp.log(allanfit.psd(x, 1.0).density)),
    ):
        slope = np.vdot(jax.jit(jax.grad(curve))(data[0]), direction)
        step = 1e-6
        ahead, behind = (jax.jit(curve)(data[0] + s * direction) for s in (step, -step))
        np.testing.assert_allclose(slope, (ahead - behind) / (2 * step), rtol=1e-5)


def test_one_broken_sensor_leaves_the_others():
    data = np.random.default_rng(8).normal(size=(2, 300))
    broken = data.copy()
    broken[0, 5] = np.nan
    found = allanfit.allan_variance(broken, 1.0)
    assert bool(jnp.all(jnp.isnan(found[0])))
    assert bool(jnp.all(found[1] == allanfit.allan_variance(data, 1.0)[1]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(100), 1.0, [0]), "between 1 and half"),
        ((np.zeros(100), 1.0, [51]), "between 1 and half"),
        ((np.zeros(100), 1.0, np.array([1.5])), "integers"),
        ((np.zeros(2), 1.0), "at least 3"),
        ((np.zeros((2, 2, 9)), 1.0), "shape"),
        ((np.zeros(100), 0.0), "positive"),
        ((np.zeros(100), np.int64(-5)), "positive"),
        ((np.zeros(100), np.inf), "positive"),
        ((np.zeros(100), "100"), "positive"),
        ((np.array(["a", "b", "c"]), 1.0), "real numbers"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        allanfit.allan_variance(*arguments)
