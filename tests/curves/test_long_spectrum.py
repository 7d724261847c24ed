"""The mirror spectrum in one pass against the cosine transform of the whole record."""

import numpy as np
import pytest
import scipy.fft

import allanfit
from allanfit.curves import LongStatistics, design
from allanfit.curves._long_spectrum import LongSpectrum

SAMPLES = 600_000
NOISE = np.random.default_rng(2).standard_normal(SAMPLES)


def spectrum(x, block=100_000):
    found = LongSpectrum()
    for start in range(0, x.size, block):
        found.add(x[start : start + block])
    return found.end_stretch(), found.sums()


@pytest.mark.parametrize("kind", ["white", "walk"])
def test_first_coefficients_are_those_of_the_record(kind):
    x = 3.0 + (NOISE if kind == "white" else np.cumsum(NOISE))
    found, _ = spectrum(x)
    whole = scipy.fft.dct(x[: SAMPLES // 512 * 512], norm="ortho")[1 : len(found) + 1]
    assert len(found) > 100
    np.testing.assert_allclose(found, whole, atol=1e-3 * np.std(whole))


def test_a_ramp_changes_nothing():
    _, without = spectrum(NOISE)
    _, found = spectrum(NOISE + 1e-4 * np.arange(SAMPLES))
    np.testing.assert_allclose(found, without, rtol=1e-6, atol=1e-6)


def test_the_design_expects_what_white_noise_shows():
    """Each bin within its spread, all together as chi-square says, with a gap in the record."""
    taken = LongStatistics()
    for block in (NOISE[:280_000], NOISE[280_000:550_000]):
        taken.add(block)
    taken.end_stretch()
    taken.add(NOISE[550_000:])
    taken.end_stretch()
    found, layout = taken.value()
    white = 1
    excess = np.asarray(found.density) / layout.density[:, white] - 1
    score = excess * np.sqrt(layout.ordinates / 2)
    assert np.max(np.abs(score)) < 4.5
    assert 0.7 < np.mean(score**2) < 1.4
    # Of 550,000 samples 25,712 are a last segment too short to use above 1/8192 of the rate.
    assert sum(layout.ordinates) == pytest.approx(SAMPLES - 25_712, abs=50)
    assert layout.lengths == (550_000, 50_000)
    assert taken.mean == pytest.approx(NOISE.mean())


def test_a_short_record_has_the_statistics_of_the_fit():
    x = np.cumsum(NOISE[:8192]) + 5 * NOISE[8192:16384]
    taken = LongStatistics()
    taken.add(x[:10])
    taken.add(x[10:])
    taken.end_stretch()
    # Too short a stretch, left out.
    taken.add(x[:15])
    taken.end_stretch()
    found, layout = taken.value()
    expected = design((8192,))
    coefficients = scipy.fft.dct(x, norm="ortho")[1:]
    ordinates = 2 * expected.projection[0](coefficients)
    whole = np.bincount(expected.bin_index[0], ordinates) / expected.ordinates
    # Edges of wide bins are moved by up to a thousandth.
    few = expected.ordinates < 100
    np.testing.assert_array_equal(layout.ordinates[few], expected.ordinates[few])
    np.testing.assert_allclose(layout.density[few], expected.density[few], rtol=1e-9)
    np.testing.assert_allclose(found.density[few], whole[few], rtol=1e-6)
    np.testing.assert_allclose(layout.density, expected.density, rtol=0.01)
    np.testing.assert_allclose(found.density, whole, rtol=0.02)
    np.testing.assert_allclose(layout.ramp, expected.ramp, rtol=1e-9)
    np.testing.assert_allclose(layout.ramp_variance, expected.ramp_variance, rtol=1e-9)
    np.testing.assert_allclose(found.odd_modes[0], coefficients[:64:2], rtol=1e-5, atol=1e-4)


def test_curves_of_a_file(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.stack([NOISE[:8192], np.ones(8192)], axis=1))
    curves = allanfit.curves_of_file(path, rate_hz=50.0, unit="deg/s", block_samples=2000)
    channel = curves["channel_1"]
    x = NOISE[:8192] * np.pi / 180
    sizes = np.rint(channel.tau_s * 50).astype(int)
    expected = allanfit.allan_variance(x, 50.0, sizes)
    np.testing.assert_allclose(channel.allan_variance, expected, rtol=1e-3)
    np.testing.assert_allclose(channel.allan_variance[sizes < 2048], expected[sizes < 2048], 1e-5)
    total = np.sum(channel.density * channel.ordinates) * 50 / (2 * 8192)
    assert total == pytest.approx(x.var(), rel=2e-3)
    assert any("channel_2 is left out" in finding for finding in curves.findings)
