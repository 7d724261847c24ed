"""Vibration in bouts: noise of a band of its own, which may shift the mean."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from allanfit.explain._investigate import _joined_again, investigate
from allanfit.explain.strength._lasting import loudness

SAMPLES = 60_000
BOUTS = ((10_000, 22_000), (35_000, 41_000), (50_000, 55_000))
STRENGTH = 2.0


# In 12 records noise and mean together know an edge to 12 samples rms, noise alone to 15.
KNOWN = 12.0


def drawn(
    shift: float, knock: float = 0.0, seed: int = 31, strength: float = STRENGTH
) -> np.ndarray:
    """White noise of one beside a slow walk; vibration of 0.15 to 0.4 of the Nyquist frequency."""
    rng = np.random.default_rng(seed)
    values = rng.standard_normal(SAMPLES) + 0.004 * np.cumsum(rng.standard_normal(SAMPLES))
    moving = lfilter(*butter(2, [0.15, 0.4], "band"), rng.standard_normal(SAMPLES))
    for start, stop in BOUTS:
        values[start:stop] += strength * (moving / moving.std())[start:stop] + shift
    values[28_000:28_200] += knock * rng.standard_normal(200)
    return values


def investigated(values):
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 2e-5]))
    return state, {finding.name for finding in state.findings}


def n_of(state) -> float:
    return float(np.exp(state.model.theta[1] / 2))


def edges(state) -> np.ndarray:
    return np.flatnonzero(np.diff(state.flags(state.modulation.loud).astype(int))) + 1


@pytest.mark.parametrize("knock", [0.0, 6.0])
def test_vibration_that_shifts_the_mean_is_rectified(knock):
    state, names = investigated(drawn(0.4, knock))
    knocked = {"disturbance"} if knock else set()
    assert names == {"variance_modulation", "vibration_rectification"} | knocked
    assert not state.unknown
    # N is that of the quiet times, 37,000 samples: to three standard deviations.
    assert abs(n_of(state) - 1) < 0.011
    assert state.vibration.variance == pytest.approx(STRENGTH**2, rel=0.05)
    (size,) = state.sized.sizes
    assert size == pytest.approx(0.4 / STRENGTH**2, rel=0.1)
    assert edges(state) == pytest.approx(np.ravel(BOUTS), abs=3 * KNOWN)


def test_vibration_of_a_mount_has_a_skirt_down_to_zero():
    """It was left below a fiftieth of the sampling rate, where it was a resonance or a bump."""
    rng = np.random.default_rng(5)
    samples = 4 * SAMPLES
    values = rng.standard_normal(samples) + 0.002 * np.cumsum(rng.standard_normal(samples))
    # A mass on a spring of Q = 8 at 0.23 of the sampling rate, pushed by white noise.
    decay, turn = np.exp(-np.pi * 0.23 / 8), 2 * np.pi * 0.23
    pushed = rng.standard_normal(samples)
    moving = lfilter([1.0], [1.0, -2 * decay * np.cos(turn), decay**2], pushed)
    for start, stop in 4 * np.array(BOUTS):
        values[start:stop] += 2.5 * (moving / moving.std())[start:stop] + 0.4
    state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 4e-6]))
    names = [finding.name for finding in state.findings]
    assert names == ["variance_modulation", "vibration_rectification"]
    assert not state.unknown
    # Of 148,000 samples: to four standard deviations.
    assert abs(n_of(state) - 1) < 0.0075


@pytest.mark.parametrize("strength", [6.0, 12.0])
def test_vibration_much_stronger_than_the_noise_leaves_its_quiet_times(strength):
    """Five hundred times the density of the noise was taken for three times: a bump was left."""
    state, names = investigated(drawn(0.4, strength=strength))
    assert names == {"variance_modulation", "vibration_rectification"}
    assert not state.unknown
    assert state.model.kinds.shaping is None
    assert abs(n_of(state) - 1) < 0.011
    assert state.vibration.variance == pytest.approx(strength**2, rel=0.05)
    assert state.modulation.ratio == pytest.approx(np.sqrt(1 + strength**2), rel=0.05)
    (size,) = state.sized.sizes
    assert size == pytest.approx(0.4 / strength**2, rel=0.1)


def test_times_that_were_cut_out_and_come_back_have_their_vibration():
    """Nothing was known of them, and a recording with vibration and knocks ended in an error."""
    state, _ = investigated(drawn(0.4, knock=6.0))
    assert state.looked_at.size < SAMPLES
    whole = _joined_again(state, np.array([0.0, 1.0, 0.0, 2e-5]))
    assert whole.looked_at.size == SAMPLES
    assert whole.modulation.loud.size == whole.vibration.course.size == SAMPLES
    known = np.isin(whole.looked_at, state.looked_at)
    assert np.array_equal(whole.modulation.loud[known], state.modulation.loud)


def test_bouts_begin_and_end_where_mean_and_noise_say():
    """Of 24 edges, by a chance of .01 or less further off."""
    found = [edges(investigated(drawn(0.4, seed=seed))[0]) for seed in range(36, 40)]
    assert np.sqrt(np.mean((np.array(found) - np.ravel(BOUTS)) ** 2)) < 1.35 * KNOWN


def test_vibration_that_does_not_has_no_name():
    state, _ = investigated(drawn(0.0))
    assert "variance_modulation" in state.disowned
    assert ["spectrum of its own" in each.why for each in state.unknown] == [True]
    # Between 0.075 and 0.2 cycles per sample.
    assert 0.11 < state.unknown[0].frequency < 0.17
    assert len(state.unknown[0].times) == len(BOUTS)
    assert abs(n_of(state) - 1) < 0.011


def test_white_noise_that_is_louder_stays_noise_that_is_louder():
    rng = np.random.default_rng(32)
    values = rng.standard_normal(SAMPLES) + 0.004 * np.cumsum(rng.standard_normal(SAMPLES))
    for start, stop in BOUTS:
        values[start:stop] += rng.standard_normal(stop - start)
    state, names = investigated(values)
    assert names == {"variance_modulation"}
    assert state.vibration is None
    assert not state.unknown


def test_loud_white_noise_has_its_own_size_where_quantization_rules():
    """Sums of samples tell of it there, and hear only its lowest frequencies."""
    rng, samples = np.random.default_rng(3), 200_000
    loud = np.zeros(samples, bool)
    loud[40_000:90_000] = loud[130_000:170_000] = True
    white = rng.standard_normal(samples) * np.where(loud, 2.0, 1.0)
    values = white + 7 * np.diff(rng.standard_normal(samples + 1))
    state = investigate(values, ((0, samples),), "point", np.array([49.0, 2.35, 0.0, 0.0]))
    assert [finding.name for finding in state.findings] == ["variance_modulation"]
    assert state.modulation.summed > 1
    column = loudness(state, state.modulation)[:, 0]
    assert column.max() - column.min() == pytest.approx(3.0, rel=0.15)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_vibration_of_a_mass_on_a_spring_leaves_n(seed):
    """Of quality 4, with a sixteenth of its peak's power at zero frequency, in 7 % of the time.

    It was a resonance for ever, and N low by a tenth.
    """
    rng = np.random.default_rng(seed)
    pole = np.exp(-0.88 / 8) * np.exp(1j * 0.88)
    pushed = lfilter([1.0], np.poly([pole, pole.conj()]).real, rng.standard_normal(SAMPLES))
    values = rng.standard_normal(SAMPLES) + 1e-3 * np.cumsum(rng.standard_normal(SAMPLES))
    for start, stop in ((9_000, 12_000), (42_000, 43_500)):
        values[start:stop] += 1.5 * (pushed / pushed.std())[start:stop]
    state, _ = investigated(values)
    assert n_of(state) == pytest.approx(1, abs=0.02)
    assert not state.model.kinds.added
    (unknown,) = state.unknown
    assert [start for start, _ in unknown.times] == pytest.approx([9_000, 42_000], abs=600)
