"""Sinusoids near to one another, and what only looks like them."""

import numpy as np
import pytest
from scipy.signal import lfilter

from allanfit.explain.lines._lines import scan
from allanfit.explain.lines._several import several
from allanfit.explain.lines._sidebands import symmetric

SAMPLES = 32_768
TIME = np.arange(SAMPLES)
LOOSE = 1e-3


def found_in(x: np.ndarray) -> list[float]:
    """In ordinates, beside white noise of one."""
    white = x + np.random.default_rng(4).standard_normal(SAMPLES)
    peak = scan(white, LOOSE)[0]
    sines = several(white, np.ones(SAMPLES), TIME.astype(float), peak, LOOSE)
    return sorted(sine.frequency * SAMPLES for sine in sines)


def line(ordinate: float, gain: float) -> np.ndarray:
    """A sinusoid that gains so much in log-likelihood."""
    return 2 * np.sqrt(gain / SAMPLES) * np.cos(2 * np.pi * ordinate * TIME / SAMPLES + ordinate)


@pytest.mark.parametrize(
    "lines",
    [
        {5000.3: 1000.0, 5006.3: 700.0},
        {5000.3: 200.0, 5060.0: 150.0},
        {5000.3: 900.0, 5015.5: 200.0, 4985.1: 100.0},
    ],
)
def test_steady_lines_are_several_at_their_places(lines):
    """To six of their standard errors, sqrt(6/gain)/(2 pi) ordinates each."""
    found = found_in(np.sum([line(*each) for each in lines.items()], axis=0))
    errors = [np.sqrt(6 / lines[place]) / (2 * np.pi) for place in sorted(lines)]
    assert len(found) == len(lines)
    assert np.all(np.abs(np.array(found) - sorted(lines)) < 6 * np.array(errors))


def test_one_line_and_one_that_wanders_are_not_several():
    rng = np.random.default_rng(6)
    assert found_in(line(5000.3, 1000.0)) == []
    for width in (2.0, 8.0, 30.0):
        # The frequency is a bounded walk of such a standard deviation, in ordinates.
        keep = 1 - 10 / SAMPLES
        walk = lfilter([1.0], [1, -keep], rng.standard_normal(2 * SAMPLES))[SAMPLES:]
        phase = np.cumsum(5000 + width * walk * np.sqrt(1 - keep**2)) / SAMPLES
        assert found_in(2 * np.sqrt(400 / SAMPLES) * np.cos(2 * np.pi * phase)) == []


def test_a_line_that_swings_has_sidebands_of_its_own():
    """Whose frequency goes to and fro by 5 ordinates, three times in the record."""
    swing = 5 / 3 * np.sin(2 * np.pi * 3 * TIME / SAMPLES)
    x = 2 * np.sqrt(700 / SAMPLES) * np.cos(2 * np.pi * 5000 * TIME / SAMPLES + swing)
    assert found_in(x) == []


def test_a_band_of_noise_is_not_several():
    """A resonance of a few ordinates and of many; whose strongest ones stand out alone."""
    rng = np.random.default_rng(7)
    for width in (2.0, 10.0, 40.0):
        keep = np.exp(-np.pi * width / SAMPLES + 2j * np.pi * 5000 / SAMPLES)
        drive = rng.standard_normal(2 * SAMPLES) + 1j * rng.standard_normal(2 * SAMPLES)
        ringing = lfilter([1.0], [1, -keep], drive)[SAMPLES:].real
        assert found_in(ringing / ringing.std() * np.sqrt(2 * 400 / SAMPLES)) == []


def test_sidebands_of_one_line_are_alike():
    """Spectra of a strength that varies are even about the line, whatever it does."""
    places = [0.1, 0.1005, 0.101]
    assert symmetric(places, [20.0, 50.0, 22.0], SAMPLES)
    assert not symmetric(places, [43.0, 20.0, 13.0], SAMPLES)
    # A line between two sidebands may be suppressed, and one as weak as the other hidden.
    assert symmetric([0.1, 0.1005, 0.1015, 0.102], [9.0, 40.0, 39.0, 8.0], SAMPLES)
    assert not symmetric([0.1, 0.1005, 0.101, 0.1015], [40.0, 30.0, 20.0, 10.0], SAMPLES)
