"""Processes that jump one way and come back, told from telegraphs and from normal ones."""

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit
from allanfit.explain.courses._telegraph import one_way
from allanfit.explain.spectrum._ordinates import ordinates

SAMPLES, CONSTANT = 20_000, 60.0


def telegraph(rng: np.random.Generator, up: float, down: float) -> np.ndarray:
    """Of a standard deviation of one, its levels held for so many samples on average."""
    dwells = rng.exponential(np.tile([up, down], SAMPLES)) + 1
    ends = np.cumsum(dwells)
    level = np.searchsorted(ends, np.arange(SAMPLES), side="right") % 2
    return level / level.std()


def pulses(rng: np.random.Generator, every: float) -> np.ndarray:
    """Of one height, which die away."""
    decayed = lfilter([1], [1, -np.exp(-1 / CONSTANT)], rng.random(SAMPLES) < 1 / every)
    return decayed / decayed.std()


def wandering(rng: np.random.Generator) -> np.ndarray:
    kept = np.exp(-1 / CONSTANT)
    return lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.standard_normal(SAMPLES))


def log_chance(process: np.ndarray, rng: np.random.Generator) -> float:
    """As in white noise of the process's own standard deviation."""
    found = ordinates((process + rng.standard_normal(SAMPLES),), "point")
    kept = np.exp(-1 / CONSTANT)
    turn = 1 - 2 * kept * np.cos(2 * np.pi * found.frequency) + kept**2
    signal = (1 - kept**2) / turn
    corner = round(2 * SAMPLES / (2 * np.pi * CONSTANT))
    return one_way(found.amplitude, signal, signal + 1.0, corner)


@pytest.mark.parametrize(
    "process",
    [
        wandering,
        lambda rng: telegraph(rng, 2 * CONSTANT, 2 * CONSTANT),
        lambda rng: telegraph(rng, 1.15 * CONSTANT, 8 * CONSTANT),
    ],
    ids=["normal", "even telegraph", "uneven telegraph"],
)
def test_backward_in_time_they_are_the_same(process):
    """Of 300 more than 27 are below a chance of .05 once in 2000 times; telegraphs seldom are."""
    rng = np.random.default_rng(1)
    chances = np.array([log_chance(process(rng), rng) for _ in range(300)])
    assert np.count_nonzero(chances < np.log(0.05)) <= 27
    assert chances.min() > np.log(1e-4)


def test_pulses_are_not():
    rng = np.random.default_rng(2)
    chances = np.array([log_chance(pulses(rng, 6 * CONSTANT), rng) for _ in range(100)])
    assert np.mean(chances < np.log(1e-3)) > 0.9


def test_pulses_that_die_away_are_no_telegraph():
    """They were one with a probability of .95: two thirds of sigma high, with 4 s to die away."""
    rng = np.random.default_rng(8)
    samples, rate_hz = 120_000, 100.0
    values = 0.06 * rng.standard_normal(samples)
    starts = rng.random(samples) < 1 / (15 * rate_hz)
    values += 0.04 * lfilter([1], [1, -np.exp(-1 / (4 * rate_hz))], starts)
    recording = allanfit.recording_of(values, rate_hz=rate_hz, unit="deg/s")
    (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    assert told["verdict"] == "unexplained"
    (effect,) = told["effects"]
    assert "jumps one way" in effect["sentence"]
    # What is left out has no name, but N is right beside it.
    assert told["coefficients_after"]["N"]["value"] == pytest.approx(0.006, rel=0.01)
