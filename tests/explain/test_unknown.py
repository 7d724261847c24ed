"""Causes outside the catalogue: seen for what they are, and not seen where they are not."""

import re

import numpy as np
import pytest
from scipy.signal import butter, iirnotch, lfilter

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain._effects import _unknown
from allanfit.explain._investigate import investigate
from allanfit.explain._mismatch import located, once
from allanfit.explain._state import Unknown
from allanfit.explain.lines._changing import _pulse
from allanfit.explain.lines._moving import Band
from allanfit.explain.lines._sidebands import even
from allanfit.explain.values._held_out import of_codes, of_events, of_spikes, of_swing

# The length and rate of test_explain, for one compilation.
RATE, SAMPLES = 50.0, 30_000
TIME = np.arange(SAMPLES) / RATE


def explained(folder, values):
    path = folder / "gyro.npz"
    np.savez(path, gyro_x=values, rate_hz=RATE, units='{"gyro_x": "deg/s"}')
    found = explain_recording(allanfit.load(path), posterior=False)
    return found.to_dict()["channels"][0]


@pytest.fixture
def noise():
    """White noise of N = 0.005 and a random walk of K = 2e-4, in deg/s."""
    rng = np.random.default_rng(8)
    walk = np.cumsum(rng.standard_normal(SAMPLES)) * 2e-4 * RATE**-0.5
    return 0.005 * RATE**0.5 * rng.standard_normal(SAMPLES) + walk


@pytest.mark.parametrize(
    ("cause", "word"),
    [
        (
            lambda x: x + 0.03 * ((TIME % 20) < 4) * np.sin(2 * np.pi * 7.3 * TIME),
            "comes and goes, every 20 s, at 7.3",
        ),
        (lambda x: x + 0.012 * np.sin(2 * np.pi * (5 + 0.003 * TIME) * TIME), "sweeps"),
        (
            lambda x: x + 0.05 * ((TIME > 100) & (TIME < 180)) * np.sin(2 * np.pi * 7.3 * TIME),
            r"one frequency and phase whose strength changes, at 7.\S+ Hz, mostly from",
        ),
        (lambda x: np.where(np.abs(x - x.mean()) < 0.012, x.mean(), x), "a dead band"),
        (lambda x: x * np.where(np.arange(SAMPLES) % 2, 1.3, 1.0), "two converters"),
        # Three times, and far too strong for a quarter of an ordinate to do.
        (
            lambda x: x + 0.1 * (TIME % 130 < 50) * np.sin(2 * np.pi * 7.3 * TIME),
            "a line",
        ),
        (lambda x: x * np.sqrt(1 + 0.5 * np.sin(2 * np.pi * TIME / 3)), "swings, every 3 s"),
        (lambda x: x + 0.08 * (TIME % 2 < 0.03), "a waveform repeats, every 2 s"),
        # Between values 1/0.73 apart; the difference of the rates is 13.5 Hz.
        (
            lambda x: np.interp(np.arange(SAMPLES) * 0.73, np.arange(SAMPLES), x),
            "swings, every 0.07407 s; interpolation",
        ),
    ],
    ids=[
        "bursts of a line",
        "sweep",
        "a line that is switched on",
        "a dead band",
        "two converters",
        "a line that is switched on three times",
        "swing",
        "pulses",
        "between",
    ],
)
def test_it_is_called_unexplained_and_said_why(tmp_path, noise, cause, word):
    channel = explained(tmp_path, cause(noise))
    assert channel["verdict"] == "unexplained"
    assert any(re.search(word, effect["sentence"]) for effect in channel["effects"])
    assert channel["improvement"]["held_out_log_score"]["difference"] > 10


def test_a_high_pass_filter_is_known_by_what_it_leaves(tmp_path, noise):
    """Its corner within 20 %, which a little flicker beside it takes, and N within 3 %."""
    numerator, denominator = butter(2, 0.5 / (RATE / 2), "high")
    channel = explained(tmp_path, lfilter(numerator, denominator, noise))
    assert channel["verdict"] == "unexplained"
    (effect,) = channel["effects"]
    assert "as behind a high-pass filter of order" in effect["sentence"]
    assert effect["parameters"]["frequency"]["value"] == pytest.approx(0.5, rel=0.2)
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.03)


@pytest.mark.parametrize(("frequency", "quality"), [(12.0, 30.0), (8.0, 2.0)])
def test_a_notch_is_known_whatever_its_width(tmp_path, noise, frequency, quality):
    """It was a steep filter with a resonance beyond, and N 8 % low; now N is within 3 %."""
    channel = explained(tmp_path, lfilter(*iirnotch(frequency, quality, fs=RATE), noise))
    assert channel["verdict"] == "unexplained"
    (effect,) = channel["effects"]
    assert "a notch at" in effect["sentence"]
    parameters = {name: each["value"] for name, each in effect["parameters"].items()}
    assert parameters["frequency"] == pytest.approx(frequency, rel=0.01)
    assert 1 / parameters["width"] == pytest.approx(quality, rel=0.15)
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.03)


def test_notches_stand_beside_each_other_and_beside_a_filter(tmp_path):
    """Two notches behind a filter at 15 Hz; beside all three N is within 5 %."""
    x = 0.005 * RATE**0.5 * np.random.default_rng(9).standard_normal(SAMPLES + 2000)
    x = lfilter(*butter(2, 15, fs=RATE), x)
    for frequency in (7.0, 11.0):
        x = lfilter(*iirnotch(frequency, 10, fs=RATE), x)
    channel = explained(tmp_path, x[2000:])
    assert channel["verdict"] == "unexplained"
    assert [effect["name"] for effect in channel["effects"]] == ["low_pass", "bump", "bump"]
    cutoff, *notches = [each["parameters"] for each in channel["effects"]]
    assert cutoff["cutoff_frequency"]["value"] == pytest.approx(15, rel=0.05)
    found = sorted(each["frequency"]["value"] for each in notches)
    assert found == pytest.approx([7, 11], rel=0.02)
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.05)


@pytest.mark.parametrize(
    ("forward", "backward"),
    [
        ([1.0, *8 * [0.0], 0.1], [1.0]),
        ([1.0, *4 * [0.0], -0.15], [1.0]),
        ([1.0], [1.0, *29 * [0.0], -0.12]),
    ],
    ids=["9 samples", "5 and of the other sign", "30 and back"],
)
def test_an_echo_is_told_with_its_time(tmp_path, forward, backward):
    """It was a steep filter, correlated noise and a resonance, and N too small by half."""
    rng = np.random.default_rng(8)
    walk = np.cumsum(rng.standard_normal(SAMPLES)) * 2e-4 * RATE**-0.5
    x = lfilter(forward, backward, 0.005 * RATE**0.5 * rng.standard_normal(SAMPLES)) + walk
    channel = explained(tmp_path, x)
    assert channel["verdict"] == "unexplained"
    (effect,) = channel["effects"]
    assert "an echo" in effect["sentence"]
    lag = max(len(forward), len(backward)) - 1
    part = (forward[1:] or [-each for each in backward[1:]])[-1]
    parameters = effect["parameters"]
    assert RATE / parameters["frequency"]["value"] == pytest.approx(lag, abs=0.1)
    low, high = parameters["height"]["intervals"]["0.95"]
    assert low < part < high
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.03)


def test_somebody_who_leans_on_the_table_is_a_disturbance(tmp_path, noise):
    """Little louder for eight seconds, and tilted: no step up and down, and nothing rectified."""
    inside = (TIME > 300) & (TIME < 308)
    channel = explained(tmp_path, noise + inside * (0.025 + 0.03 * np.sin(2 * np.pi * 1.1 * TIME)))
    (effect,) = channel["effects"]
    assert effect["name"] == "disturbance"
    ((start, stop),) = effect["parameters"]["intervals"]["value"]
    assert 280 < start < 301
    assert 307 < stop < 328


def test_a_line_that_begins_late_is_no_change_of_the_noise(tmp_path, noise):
    """Its wander is a bounded walk of 0.05 Hz rms; it has 0.7 times the power of the noise."""
    rng = np.random.default_rng(1)
    wander = lfilter([1.0], [1, -0.999], rng.standard_normal(SAMPLES)) * 0.05 * 0.002**0.5
    phase = 2 * np.pi * np.cumsum(11.3 + wander) / RATE
    channel = explained(tmp_path, noise + 0.04 * (TIME > 400) * np.cos(phase))
    assert {effect["name"] for effect in channel["effects"]} <= {"drifting_line", "resonance"}
    assert any("mostly from" in effect["sentence"] for effect in channel["effects"])
    # The standard error is 0.5 %; taken out twice, N was 10 % too small.
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.02)


def test_harmonics_and_strangers_are_no_comb():
    assert even([0.1, 0.1004, 0.1008, 0.1016], SAMPLES)
    assert not even([0.1, 0.1004, 0.1011, 0.1016], SAMPLES)


def test_weak_bursts_have_a_period_and_steady_noise_has_none():
    """A seventh of the time on, no harmonic strong alone; false alarm 1e-5 a record."""
    rng = np.random.default_rng(4)
    count, low, high = 60_000, 0.09, 0.11
    at = np.linspace(low, high, 50)
    for amplitude, expected in ((0.5, 1500.0), (0.0, 0.0)):
        time = np.arange(count)
        on = time % 1500 < 214
        white = rng.standard_normal(count) + amplitude * on * np.sin(0.2 * np.pi * time)
        # Its share of the power where it is.
        share = (amplitude**2 / 2 / 7) / (2 * (high - low))
        band = Band(low, high, at, np.full(at.size, share / (1 + share)))
        assert _pulse(white, band) == pytest.approx(expected, rel=0.01)


def test_the_gain_of_events_is_their_information():
    """Per scored sample the divergence of the true share from the expected one; 5 deviations."""
    rng = np.random.default_rng(2)
    happened = rng.random(200_000) < 0.05
    found = of_events(happened, 0.01)
    divergence = 0.05 * np.log(5) + 0.95 * np.log(0.95 / 0.99)
    assert abs(found.nats - 100_000 * divergence) < 5 * found.variance**0.5
    # What is as frequent as expected gains nothing but the cost of having learnt it.
    assert -8 < of_events(happened, 0.05).nats < 8


def test_the_gain_of_values_is_there_where_the_cause_is():
    rng = np.random.default_rng(3)
    white = rng.standard_normal(20_000)
    assert of_codes(np.round(white, 1), 0.1).nats > 1e4
    assert of_codes(white, 0.1).nats < 10
    swing = np.sqrt(1 + 0.4 * np.sin(2 * np.pi * np.arange(20_000) / 97.0))
    # n a^2/8 for a small swing of the variance by a share a.
    assert of_swing(white * swing, 97.0).nats == pytest.approx(20_000 * 0.16 / 8, rel=0.25)
    assert of_swing(white, 97.0).nats < 5
    spikes = 8.0 * rng.standard_normal(20_000) * (rng.random(20_000) < 0.003)
    assert of_spikes(white + spikes, (), 0).nats > 50


def test_a_resonance_beside_a_sweep_keeps_its_name(tmp_path, noise):
    """Each band answers for itself."""
    rng = np.random.default_rng(12)
    turn = 2 * np.pi * 15 / RATE
    ringing = lfilter([1], [1, -2 * 0.98 * np.cos(turn), 0.98**2], rng.standard_normal(SAMPLES))
    ringing *= 0.01 / np.std(ringing)
    sweep = 0.015 * np.sin(2 * np.pi * (5 + 0.003 * TIME) * TIME)
    channel = explained(tmp_path, noise + sweep + ringing)
    assert channel["verdict"] == "unexplained"
    assert {effect["name"] for effect in channel["effects"]} == {"bump", "resonance"}
    assert any("sweeps" in effect["sentence"] for effect in channel["effects"])
    (resonance,) = (each for each in channel["effects"] if each["name"] == "resonance")
    assert resonance["parameters"]["frequency"]["value"] == pytest.approx(15, rel=0.02)


def test_a_sweep_leaves_no_filter_behind():
    """Its band was the foot of a filter, and Q behind that four times N; there is no Q."""
    samples, rng = 60_000, np.random.default_rng(2)
    cycles = np.cumsum(0.05 * 8 ** (np.arange(samples) / samples))
    values = rng.standard_normal(samples) + 0.4 * np.sin(2 * np.pi * cycles)
    state = investigate(values, ((0, samples),), "point", np.array([1e-4, 1.0, 1e-6, 1e-6]))
    assert state.unknown
    assert "low_pass" not in {finding.name for finding in state.findings}
    assert not state.model.kinds.filtering
    q, n = np.exp(state.model.theta[:2] / 2)
    assert q < 0.2
    assert n == pytest.approx(1.0, abs=0.03)


def test_a_sweep_is_told_from_where_to_where(tmp_path, noise):
    """As of a fan that slows down, from 11.5 to 10.9 Hz."""
    cycles = np.cumsum(11.5 - 0.6 * np.arange(SAMPLES) / SAMPLES) / RATE
    channel = explained(tmp_path, noise + 0.02 * np.sin(2 * np.pi * cycles))
    assert channel["verdict"] == "unexplained"
    said = " ".join(effect["sentence"] for effect in channel["effects"])
    (told,) = re.findall(r"sweeps .* from ([\d.]+) to ([\d.]+) Hz; a motor", said)
    # A segment of the path knows its frequency to a fraction of 0.6 Hz.
    assert [float(each) for each in told] == pytest.approx([11.5, 10.9], abs=0.1)


def test_a_line_without_a_name_is_told_where_it_is_beside_a_bump(noise):
    """Of the bump alone leaving it out of the model tells where it shows."""
    state = investigate(noise, ((0, SAMPLES),), "point", np.array([1e-4, 0.005, 1e-6, 2e-4]))
    kinds = state.model.kinds._replace(shaping="bump")
    theta = np.concatenate([state.model.theta, [0.3, 0.0, 0.0, 0.0]])
    state.model = state.model._replace(kinds=kinds, theta=theta)
    state.unknown = [
        Unknown(7.3 / RATE, 1e-3, "a line"),
        Unknown(9.1 / RATE, 1e-3, "a line", period=20 * RATE),
        Unknown(0.02 / RATE, 1.0, "a jump"),
    ]
    effects = [_unknown(state, each, 1 / RATE) for each in state.unknown]
    assert [each.note for each in effects] == [
        "a line, at 7.3 Hz",
        "a line, every 20 s, at 9.1 Hz",
        "a jump",
    ]
    entries = [each.entry for each in located(state, effects[:2], 1 / RATE)]
    middles = sorted((entry["low"] + entry["high"]) / 2 for entry in entries)
    assert middles == pytest.approx([7.3, 9.1], rel=1e-3)


def test_places_that_are_alike_are_told_once():
    place = {"domain": "time", "low": 0.0, "high": 9.0, "sentence": "It differs.", "effect": "bump"}
    entries = [place | {"p_value": 1e-5}, place | {"p_value": 1e-3}]
    other = place | {"low": 1.0, "p_value": 1e-3}
    assert once([*entries, other]) == [entries[0], other]
