"""Whether visits to the rarer level of a telegraph are alike, beside noise of a known spectrum."""

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit
from allanfit.explain.courses._visits import Visits, visits

SAMPLES, WALK = 40_000, 0.005


def found(course: np.ndarray, level: np.ndarray, rng: np.random.Generator) -> Visits | None:
    """Beside white noise of one and a walk that rises above it within some 200 samples."""
    noise = rng.standard_normal(SAMPLES) + WALK * np.cumsum(rng.standard_normal(SAMPLES))
    frequency = np.maximum(np.linspace(0, 0.5, SAMPLES // 2), 0.2 / SAMPLES)
    density = 1 + (WALK / (2 * np.sin(np.pi * frequency))) ** 2
    return visits(course + noise, level.astype(float), density, 0)


def telegraph(rng: np.random.Generator, up: float, down: float) -> np.ndarray:
    dwells = np.ceil(rng.exponential(np.tile([down, up], round(SAMPLES / (up + down)) + 100)))
    return np.searchsorted(np.cumsum(dwells), np.arange(SAMPLES), side="right") % 2


def popcorn(rng: np.random.Generator, lasts: float, every: float) -> np.ndarray:
    """Of exponential heights and of both signs; each dies away."""
    heights = rng.exponential(1, SAMPLES) * rng.choice([-1, 1], SAMPLES)
    starts = rng.random(SAMPLES) < 1 / every
    return np.asarray(lfilter([1], [1, -np.exp(-1 / lasts)], heights * starts))


@pytest.mark.parametrize(
    ("up", "down"), [(12, 1200), (60, 600), (300, 300), (900, 60)], ids=lambda each: str(each)
)
@pytest.mark.parametrize("height", [2.0, 4.0])
def test_visits_of_a_telegraph_are_alike(up, down, height):
    """A false alarm of 1e-4 a record, and none in 6 of each; of 802 of more kinds none had .001."""
    rng = np.random.default_rng(4)
    for _ in range(6):
        level = telegraph(rng, up, down)
        told = found(height * level, level, rng)
        assert told is None or told.log_chance > np.log(1e-4)


def test_noise_is_what_their_heights_scatter_by():
    """Some 1000 heights: the mean square is known to 5 %, and 15 % is three times that."""
    rng, squares = np.random.default_rng(5), []
    for _ in range(12):
        level = telegraph(rng, 60, 600)
        told = found(4.0 * level, level, rng)
        assert told is not None
        long = np.diff(told.at, axis=1)[:, 0] > 20
        squares.append(((told.height - 4.0) / told.deviation)[long] ** 2)
    # Edges that nobody sees are wrong by a sample or two, and short returns are hidden.
    assert np.mean(np.minimum(np.concatenate(squares), 9)) == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize("height", [2.0, 4.0])
def test_heights_of_pulses_differ(height):
    rng, alike = np.random.default_rng(6), 0
    for _ in range(6):
        course = height * popcorn(rng, 60, 400)
        told = found(course, course > height / 2, rng)
        alike += told is None or told.log_chance > np.log(1e-4)
    assert alike <= 1


def test_pulses_of_differing_heights_are_no_telegraph():
    """They were one with a probability of .95, with spikes, steps, knocks and loud times beside."""
    rng = np.random.default_rng(5)
    samples, rate_hz = 60_000, 100.0
    values = 0.05 * rng.standard_normal(samples)
    starts = rng.random(samples) < 0.2 / rate_hz
    heights = 0.15 * rng.exponential(1, samples) * rng.choice([-1, 1], samples)
    values += lfilter([1], [1, -np.exp(-1 / (0.3 * rate_hz))], starts * heights)
    recording = allanfit.recording_of(values, rate_hz=rate_hz, unit="deg/s")
    (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    assert told["verdict"] == "unexplained"
    (effect,) = told["effects"]
    assert "pulses of differing heights" in effect["sentence"]
    assert "mostly from" in effect["sentence"]
    assert told["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.02)
