"""Brief disturbances: none where there is none, and where one is."""

import numpy as np
from scipy.stats import binom

from allanfit.explain._investigate import investigate
from allanfit.explain.strength._bursts import bursts

SAMPLES = 20_000


def ring(at: int, energy: float, decay: float, frequency: float) -> np.ndarray:
    """A ring-down whose squares sum to `energy`."""
    after = np.maximum(np.arange(SAMPLES) - at, 0)
    wave = np.exp(-after / decay) * np.sin(2 * np.pi * frequency * after)
    return wave * np.sqrt(energy / np.sum(wave**2))


def test_white_noise_has_none():
    """Of 60 records less than a tenth below .05; false alarm 3e-3 at the level itself."""
    rng = np.random.default_rng(0)
    chances = np.exp([bursts(rng.standard_normal(SAMPLES)).log_p for _ in range(60)])
    assert binom.sf(np.sum(chances < 0.05) - 1, 60, 0.05) > 3e-3


def test_a_ring_down_is_found_where_it_is():
    rng = np.random.default_rng(1)
    for at, decay, frequency in ((3000, 30, 0.11), (12_000, 200, 0.05)):
        found = bursts(rng.standard_normal(SAMPLES) + ring(at, 140.0, decay, frequency))
        assert found.log_p < -8
        where = np.flatnonzero(found.loud)
        assert np.median(where) > at - 2 * found.window
        assert np.median(where) < at + 4 * decay + 2 * found.window
        assert found.loud.mean() < 0.1


def test_two_knocks_say_more_than_one():
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(SAMPLES)
    one = bursts(noise + ring(5000, 50.0, 60, 0.11))
    two = bursts(noise + ring(5000, 50.0, 60, 0.11) + ring(14_000, 50.0, 60, 0.11))
    assert two.log_p < one.log_p - 2


def test_where_several_say_what_none_says_alone_is_told_where():
    """Knocks of which each is within chance; false alarm of one seed .05, of the median none."""
    middles = np.arange(2500, 20_000, 5000)
    knocks = sum(ring(at, 34.0, 60, 0.11) for at in middles)
    near = []
    for seed in range(20):
        found = bursts(np.random.default_rng(seed).standard_normal(SAMPLES) + knocks)
        assert found.loud.any()
        away = np.abs(np.flatnonzero(found.loud)[:, None] - middles).min(axis=1)
        near.append(np.mean(away < 600))
    assert np.median(near) > 0.5


def test_a_lasting_line_is_none():
    time = np.arange(SAMPLES)
    line = 0.5 * np.sin(2 * np.pi * 0.1337 * time)
    found = bursts(np.random.default_rng(2).standard_normal(SAMPLES) + line)
    assert found.log_p > -6


def test_a_knock_makes_no_second_one_elsewhere():
    """Chance lifts a tile far away so high in one record of a thousand: two of 100 once in 200."""
    elsewhere = 0
    for seed in range(100):
        white = np.random.default_rng((21, seed)).standard_normal(16_384)
        time = np.arange(400)
        white[2000:2400] += 6 * np.exp(-time / 60) * np.sin(0.9 * time)
        loud = bursts(np.clip(white, -8, 8)).loud
        assert loud[2000:2040].all()
        elsewhere += loud[8192:].any()
    assert elsewhere < 2


def test_a_knock_shows_among_samples_that_now_and_then_repeat():
    """A tenth repeats: such noise has hardly longer tails than noise of its own."""
    rng = np.random.default_rng(3)
    fresh = rng.random(100_000) > 0.1
    fresh[0] = True
    x = rng.standard_normal(100_000)
    time = np.arange(400)
    x[60_000:60_400] += 2.2 * np.exp(-time / 80) * np.sin(2 * np.pi * 0.05 * time)
    held = x[np.flatnonzero(fresh)[np.cumsum(fresh) - 1]]
    state = investigate(held, ((0, held.size),), "point", np.array([1e-6, 1.0, 0.0, 0.0]))
    assert {finding.name for finding in state.findings} == {"sample_hold", "disturbance"}
    (knock,) = state.knocks
    assert knock[0] < 60_050 < knock[1]
