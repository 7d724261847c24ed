"""What values say, and what they do not: codes of an angle, long tails, two levels."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from allanfit.explain._investigate import investigate
from allanfit.explain.courses._telegraph import two_levels
from allanfit.explain.spectrum._ordinates import ordinates
from allanfit.explain.strength._knocks import wrong_ends

SAMPLES = 40_000


def named(values: np.ndarray):
    power = np.array([0.0, np.var(values) / 2, 0.0, 0.0])
    return investigate(values, ((0, values.size),), "point", power)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.parametrize("rate", [0.0, 0.37])
def test_differences_of_a_rounded_angle_are_quantization(seed, rate):
    """An angle that moves by .42 codes a sample: its errors are almost white, but not quite."""
    rng = np.random.default_rng(seed)
    angle = np.cumsum(rate + 0.42 * rng.standard_normal(SAMPLES + 1))
    state = named(np.diff(np.round(angle)))
    assert [finding.name for finding in state.findings] == []
    quantization, white = np.exp(state.model.theta[:2] / 2)
    assert white == pytest.approx(0.42, rel=0.02)
    assert quantization == pytest.approx(12**-0.5, rel=0.04)


@pytest.mark.parametrize("angle", [True, False])
def test_held_samples_hold_their_rounding(angle):
    """Each repeats the one before with a chance of .3; Q tells whose codes they are."""
    rng = np.random.default_rng(9)
    white = rng.standard_normal(SAMPLES)
    rounded = np.diff(np.round(np.cumsum(white)), prepend=0.0) if angle else np.round(white)
    fresh = np.where(rng.random(SAMPLES) < 0.7, np.arange(SAMPLES), 0)
    state = named(rounded[np.maximum.accumulate(fresh)])
    names = ["sample_hold"] if angle else ["sample_hold", "output_rounding"]
    assert [finding.name for finding in state.findings] == names
    # Rounding of the values is in N still; that of the angle is Q.
    quantization, white = np.exp(state.model.theta[:2] / 2)
    assert white == pytest.approx(1 if angle else (1 + 1 / 12) ** 0.5, rel=0.03)
    assert quantization**2 == pytest.approx(1 / 12 if angle else 0, abs=0.03)


def test_long_tails_are_the_noise_itself():
    """Laplace: N is that of all samples, though a mixture of two would have half of them spikes."""
    state = named(np.random.default_rng(5).laplace(size=SAMPLES) / np.sqrt(2))
    assert [finding.name for finding in state.findings] == ["outliers"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.02)


def test_spikes_no_larger_than_the_noise_are_told():
    """Of size 1.2 in one sample of fifty; N is that of the noise without them."""
    rng = np.random.default_rng(6)
    spikes = 1.2 * rng.standard_normal(8 * SAMPLES) * (rng.random(8 * SAMPLES) < 0.02)
    state = named(rng.standard_normal(8 * SAMPLES) + spikes)
    assert [finding.name for finding in state.findings] == ["outliers"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("places", [(700, 5_000, 31_313), (15, 700, 31_313, SAMPLES - 20)])
def test_what_stands_in_for_tall_spikes_is_no_stronger_than_the_noise(places):
    """A logger's zeros, 600 standard deviations down, also where the record begins and ends."""
    values = np.random.default_rng(7).standard_normal(SAMPLES)
    alone = float(np.std(values))
    values[list(places)] = -600.0
    state = named(values)
    assert [finding.name for finding in state.findings] == ["outliers"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(alone, rel=2e-3)


@pytest.mark.parametrize("freedom", [3, 4, 6, 10])
def test_long_tails_are_told_as_such(freedom):
    """Student's distributions, whose variance is df/(df - 2); 3 has no fourth moment."""
    rng = np.random.default_rng(50 + freedom)
    state = named(rng.standard_t(freedom, SAMPLES) / np.sqrt(freedom / (freedom - 2)))
    assert [finding.name for finding in state.findings] == ["outliers"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03 if freedom > 4 else 0.1)


@pytest.mark.parametrize(("place", "level"), [(0, 800.0), (0, 30.0), (-1, -500.0)])
def test_a_wrong_sample_at_either_end_is_left_out(place, level):
    values = np.random.default_rng(9).standard_normal(SAMPLES)
    values[place] = level
    state = named(values)
    assert [finding.name for finding in state.findings] == ["disturbance"]
    ((begin, end),) = state.knocks
    assert begin <= place % SAMPLES < end
    assert end - begin < 5
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.02)


def test_a_right_sample_at_either_end_is_none():
    """White noise, a strong walk, long tails: none of 300 ends is wrong; by chance 1e-4 or less."""
    rng = np.random.default_rng(10)
    for _ in range(50):
        white = rng.standard_normal(3000)
        for values in (white, np.cumsum(white), rng.laplace(size=3000)):
            assert wrong_ends(values) is None


@pytest.mark.parametrize("share", [0.5, 0.1])
def test_two_levels_are_told_from_a_normal_process(share):
    """Of ten telegraphs of some 60 dwells nearly all are clear, of ten relaxations hardly one."""
    rng = np.random.default_rng(6)
    length, keep, noise = 4000, 1 - 1 / 32, 0.3
    chances = {"telegraph": [], "relaxation": []}
    for _ in range(10):
        # Both have the autocovariance keep^lag.
        drawn = np.where(rng.random(length) > keep, np.arange(length), 0)
        upper = (rng.random(length) < share)[np.maximum.accumulate(drawn)]
        levels = (upper - share) / np.sqrt(share * (1 - share))
        relaxation = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.standard_normal(length))
        for kind, series in (("telegraph", levels), ("relaxation", relaxation)):
            seen = ordinates((series + noise * rng.standard_normal(length),), "point")
            turn = np.cos(2 * np.pi * seen.frequency)
            signal = 2 * (1 - keep**2) / (1 - 2 * keep * turn + keep**2)
            total = signal + 2 * noise**2
            found = two_levels(seen.amplitude, signal, total, corner=40, seed=7)
            chances[kind].append(found.chance)
            if kind == "telegraph":
                assert found.upper == pytest.approx(upper.mean(), abs=0.03)
    assert np.mean(np.array(chances["telegraph"]) < 1e-3) > 0.85
    assert np.sum(np.array(chances["relaxation"]) < 1e-2) <= 1


@pytest.mark.parametrize(("seed", "order", "repeat"), [(1, 1, 1.1), (2, 2, 1.5), (3, 2, 1.2)])
def test_n_of_filtered_values_that_are_held_at_random(seed, order, repeat):
    """What is slow is held without loss; N was 4 to 26 % low as if all were white."""
    rng = np.random.default_rng(seed)
    values = np.asarray(lfilter(*butter(order, 0.4), rng.standard_normal(2 * SAMPLES)))
    values += 1e-3 * np.cumsum(rng.standard_normal(values.size))
    fresh = np.where(rng.random(values.size) < 1 / repeat, np.arange(values.size), 0)
    state = named(values[np.maximum.accumulate(fresh)])
    assert {finding.name for finding in state.findings} == {"sample_hold", "low_pass"}
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_a_shock_that_reaches_the_rails_is_a_disturbance():
    """Two thirds of its samples stand at a rail, and none of the others."""
    rng = np.random.default_rng(8)
    values = rng.standard_normal(SAMPLES)
    values[9000:10000] += 50 * rng.standard_normal(1000)
    state = named(np.clip(values, -20, 20))
    assert {finding.name for finding in state.findings} == {"saturation", "disturbance"}
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.02)
    ((start, stop),) = state.knocks
    assert start <= 9000
    assert stop >= 10000


def test_a_slow_turn_by_hand_is_a_disturbance():
    """To and fro for ten seconds in which noise is hardly louder: of the spectrum it is a peak."""
    rng = np.random.default_rng(13)
    walk = 0.005 * np.cumsum(rng.standard_normal(SAMPLES))
    moment = (np.arange(SAMPLES) - 20_000) / 50
    turn = np.exp(-((moment / 6) ** 4) / 2) * np.sin(0.7 * moment)
    state = investigate(
        rng.standard_normal(SAMPLES) + walk + turn,
        ((0, SAMPLES),),
        "point",
        np.array([0.0, 1.0, 0.0, 2.5e-5]),
    )
    assert [finding.name for finding in state.findings] == ["disturbance"]
    ((start, stop),) = state.knocks
    assert 17_500 < start < 19_800
    assert 20_200 < stop < 22_500


def test_times_at_the_rail_are_cut_out():
    """Tilted beyond its range four times, the sensor shows nothing then."""
    rng = np.random.default_rng(9)
    values = rng.standard_normal(SAMPLES)
    starts = 6400 * np.arange(1, 5)
    for start in starts:
        values[start : start + 1600] += 30
    state = named(np.minimum(values, 20))
    assert [finding.name for finding in state.findings] == ["saturation"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.02)
    edges = [0, *(edge for start in starts for edge in (start, start + 1600)), SAMPLES]
    assert [edge for piece in state.pieces for edge in piece] == edges


def test_of_a_record_at_its_rail_nothing_else_is_told():
    rng = np.random.default_rng(10)
    state = named(np.minimum(rng.standard_normal(SAMPLES) + 3, 1))
    assert [finding.name for finding in state.findings] == ["saturation"]


def test_noise_that_changes_below_quantization_is_heard():
    """All of it is a tenth louder for a third of the record, N alone half as loud again."""
    rng = np.random.default_rng(11)
    loud = np.abs(np.arange(SAMPLES) / SAMPLES - 0.5) < 1 / 6
    noise = 0.3 * np.where(loud, 1.25, 1.0) * rng.standard_normal(SAMPLES)
    state = named(noise + np.diff(rng.standard_normal(SAMPLES + 1)))
    assert [finding.name for finding in state.findings] == ["variance_modulation"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(0.3, rel=0.03)
    changing = state.modulation
    assert changing is not None
    assert changing.ratio == pytest.approx(1.25, rel=0.1)
    assert np.mean(changing.loud == loud) > 0.93


def test_noise_that_a_rail_cuts_at_times_is_as_strong_throughout():
    """The mean wanders by a standard deviation, and with it the share of samples at zero."""
    rng = np.random.default_rng(12)
    slow = np.sin(2 * np.pi * 3 * np.arange(SAMPLES) / SAMPLES)
    state = named(np.maximum(1.5 + 0.7 * slow + rng.standard_normal(SAMPLES), 0))
    names = {finding.name for finding in state.findings}
    assert "saturation" in names
    assert "variance_modulation" not in names


def test_a_filter_stays_one_where_the_noise_changes_far_below_its_corner():
    """Slow noise in the first half only, and a filter at a hundred times its frequency."""
    rng = np.random.default_rng(13)
    fast = lfilter(*butter(2, 0.4), rng.standard_normal(SAMPLES))
    slow = lfilter([0.05], [1, -0.98], rng.standard_normal(SAMPLES))
    state = named(fast + np.where(np.arange(SAMPLES) < SAMPLES // 2, 4 * slow, 0))
    assert any("shape of the spectrum changes" in unknown.why for unknown in state.unknown)
    assert state.model.kinds.filtering
    assert "low_pass" not in state.disowned
