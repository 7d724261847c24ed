"""Spectra and strengths of noise that change in the course of a record."""

import numpy as np
import pytest
from scipy.stats import binom

from allanfit.explain.strength._changing import moved_along, reshaped, reshaped_at_times, swinging


def test_a_steady_line_and_steady_noise_are_no_swing():
    """Of 100 records a tenth at .1 or fewer; false alarm 2e-3."""
    rng = np.random.default_rng(1)
    chances = np.exp([swinging(rng.standard_normal(8192))[1] for _ in range(100)])
    assert binom.sf(np.sum(chances < 0.1) - 1, 100, 0.1) > 2e-3


def test_a_spectrum_that_changes_its_shape_is_told_from_one_that_grows():
    rng = np.random.default_rng(5)
    flat = np.ones(129)
    first, second = rng.exponential(size=(2, 60, 129))
    assert reshaped([first, second], flat) is None
    assert reshaped([first, 3 * second], flat) is None
    tilted = second * np.linspace(0.7, 1.3, 129)
    found = reshaped([first, tilted], flat)
    assert found is not None
    assert found[1] < np.log(1e-6)


def test_a_band_that_moves_through_the_spectrum_is_seen_in_one_band():
    """Half as strong again in a third of an octave, which climbs by an octave and a half.

    Over all bands that is a small change, and was none. Of 20 records without it none is told, by a
    chance of one below 2e-5, and none where all is a tenth louder in every other part.
    """
    rng = np.random.default_rng(21)
    order, flat = np.arange(129), np.ones(129)
    middles = np.geomspace(14, 40, 24)
    moving = [1 + 0.5 * (np.abs(order / middle - 1) < 0.12) for middle in middles]
    mean = np.mean(moving, axis=0)

    def told(shapes):
        groups = [rng.exponential(size=(40, 129)) * shape for shape in shapes]
        return reshaped(groups, flat) is not None

    assert sum(told([shape / mean for shape in moving]) for _ in range(20)) == 20
    assert not any(told([flat] * 24) for _ in range(20))
    assert not any(told([flat * (1 + 0.1 * (k % 2)) for k in range(24)]) for _ in range(20))


def test_white_noise_beside_rising_noise_is_no_other_spectrum_however_loud():
    """Fifty times what is quiet at the lowest frequency, a fifth of it at the highest.

    Of 40 records none; the chance of one is below 1e-4. Then the same times a slope.
    """
    rng = np.random.default_rng(8)
    quiet = 0.02 + 5 * np.sin(np.pi * np.arange(129) / 256) ** 2
    loud, share = quiet + 1.0, np.repeat([1.0, 0.0], 300)
    density = (quiet + loud) / 2
    for slope, told in ((0.0, False), (1.6, True)):
        tilt = 1 + slope * np.linspace(-0.5, 0.5, 129)
        spectra = np.where(share[:, None] > 0, quiet + tilt, quiet) / density
        found = [
            reshaped_at_times(rng.exponential(size=spectra.shape) * spectra, share, density)
            for _ in range(40)
        ]
        assert all((each is not None) == told for each in found)


def test_what_a_filter_lets_pass_of_louder_noise_is_no_other_spectrum():
    """Half as much again of what falls by ten, in 40 records; all where no filter is known."""
    rng = np.random.default_rng(18)
    passed, share = np.geomspace(1.0, 0.1, 129), np.repeat([1.0, 0.0], 300)
    quiet = passed + 0.03
    spectra = np.where(share[:, None] > 0, quiet + 0.5 * passed, quiet) / quiet
    records = [rng.exponential(size=spectra.shape) * spectra for _ in range(40)]
    assert not any(reshaped_at_times(each, share, quiet, passed=passed) for each in records)
    assert all(reshaped_at_times(each, share, quiet) for each in records)


def test_a_band_that_was_cut_out_says_nothing_of_the_shape():
    """Loud times that add white noise, in 40 records; of the band a thirtieth is left to both.

    Of 40 none where it is known, by a chance of one below 1e-4; all where it is not.
    """
    rng = np.random.default_rng(9)
    cut = np.abs(np.arange(129) - 60) < 20
    quiet = 0.5 + 5 * np.sin(np.pi * np.arange(129) / 256) ** 2
    share = np.repeat([1.0, 0.0], 300)
    density = quiet + 0.3
    spectra = np.where(share[:, None] > 0, quiet + 0.6, quiet) / density * np.where(cut, 0.03, 1.0)
    records = [rng.exponential(size=spectra.shape) * spectra for _ in range(40)]
    assert not any(reshaped_at_times(each, share, density, ~cut) for each in records)
    assert all(reshaped_at_times(each, share, density) for each in records)


def test_a_band_that_is_faint_at_times_says_nothing_of_the_shape():
    """White noise of 60 times what is quiet at low frequency, in every other part of a record."""
    rng = np.random.default_rng(10)
    quiet = 0.02 + 5 * np.sin(np.pi * np.arange(129) / 256) ** 2
    density = quiet + 0.6
    parts = [(quiet + 1.2 * (k % 2)) / density * rng.exponential(size=(40, 129)) for k in range(24)]
    assert reshaped(parts, density) is None
    # Where tiles leak there is more of it than the density says.
    parts = [each + 0.02 for each in parts]
    assert reshaped(parts, density) is None


def test_a_contrast_that_stays_is_silent_and_one_that_moves_is_seen():
    """Of 200 steady records a tenth at .1 or fewer; false alarm 2e-3. Then a tilt to and fro."""
    rng = np.random.default_rng(6)
    contrast = np.linspace(-1.0, 1.0, 127)[:, None]
    several = np.column_stack([contrast, contrast**2, 3 * contrast])
    for each in (contrast, several):
        steady = [moved_along(rng.exponential(size=(400, 127)), each)[1] for _ in range(200)]
        assert binom.sf(np.sum(np.exp(steady) < 0.1) - 1, 200, 0.1) > 2e-3
    powers = rng.exponential(size=(400, 127))
    # Louder and softer is no matter.
    level = 1 + 0.5 * np.sin(2 * np.pi * np.arange(400) / 100)[:, None]
    assert moved_along(level * powers, contrast)[1] > np.log(1e-3)
    turning = np.where(np.arange(400) // 50 % 2, 1.0, -1.0)[:, None]
    moving = powers * (1 + 0.1 * turning * contrast[:, 0])
    gain, log_p = moved_along(moving, contrast)
    # The fundamental of a square wave holds 8/pi^2 of n a^2 sum of squares of the contrast.
    expected = 8 / np.pi**2 * 400 * 0.01 * np.sum(contrast**2)
    assert abs(gain - expected) < 5 * 2 * np.sqrt(expected)
    assert log_p < np.log(1e-4)
    assert moved_along(moving, several)[1] < np.log(1e-4)


def test_a_level_that_is_known_to_change_is_no_contrast_that_moves():
    rng = np.random.default_rng(7)
    slope = np.linspace(0.5, 3.0, 127)
    contrasts = np.column_stack([slope, slope**2])
    turning = np.where(np.arange(400) // 50 % 2, 1.0, -1.0)[:, None]
    moving = rng.exponential(size=(400, 127)) * (1 + 0.05 * turning * slope)
    assert moved_along(moving, contrasts)[1] < np.log(1e-4)
    assert moved_along(moving, contrasts, slope)[1] > np.log(1e-3)


def test_a_swing_has_its_period():
    """Of which a record has nine, or hundreds: power that swings by a tenth among 134,000."""
    time = np.arange(134_000)
    for period in (14_900, 2233, 150):
        swing = np.sqrt(1 + 0.12 * np.sin(2 * np.pi * time / period))
        found = swinging(swing * np.random.default_rng(0).standard_normal(time.size))
        assert found is not None
        assert abs(time.size / found[0] - time.size / period) < 1
        assert found[1] < -20


@pytest.mark.parametrize("samples", [40_000, 40_001])
def test_two_converters_by_turns_are_a_swing_of_two_samples(samples):
    """One a tenth as strong again in power; and noise that is as strong is none in 500 records."""
    rng = np.random.default_rng(samples)
    by_turns = np.where(np.arange(samples) % 2, 1.0, np.sqrt(1.1))
    found = swinging(by_turns * rng.standard_normal(samples))
    assert found is not None
    assert found[0] == 2
    assert found[1] < np.log(1e-5)
    for _ in range(500):
        steady = swinging(rng.standard_normal(2000))
        assert steady is not None
        assert steady[0] > 2 or steady[1] > np.log(1e-3)


@pytest.mark.parametrize("period", [64.0, 10.0, 7.3])
def test_the_period_of_brief_pulses_is_theirs_and_no_harmonic_is(period):
    """One sample of each is three times as strong: all harmonics are alike, one leads by chance."""
    white = np.random.default_rng(64).standard_normal(60_000)
    white[np.rint(np.arange(0, white.size - 1, period)).astype(int)] *= 3
    found = swinging(np.clip(white / white.std(), -4, 4))
    assert found is not None
    assert found[0] == pytest.approx(period, rel=1e-3)
