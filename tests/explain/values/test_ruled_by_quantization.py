"""Values of a sensor whose quantization rules its samples, as a ring laser gyro's does."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate

SAMPLES = 120_000


def drawn(seed: int) -> np.ndarray:
    """White noise of one beside differences of angle errors of seven."""
    rng = np.random.default_rng(seed)
    return rng.standard_normal(SAMPLES) + 7 * np.diff(rng.standard_normal(SAMPLES + 1))


def investigated(values, **known):
    power = np.array([49.0, 1.0, 0.0, 0.0])
    return investigate(values, ((0, values.size),), "point", power, **known)


def n_of(state) -> float:
    return float(np.exp(state.model.theta[1] / 2))


@pytest.mark.parametrize(("width", "names"), [(2.0, {"output_rounding"}), (0.5, set())])
def test_codes_that_are_fine_beside_the_samples_are_coarse_beside_n(width, names):
    """A fifth of the samples' deviation adds a third to the power of N, a twentieth 2 %."""
    state = investigated(np.round(drawn(1) / width) * width)
    assert {finding.name for finding in state.findings} == names
    # N is known to 1.6 %.
    assert n_of(state) == pytest.approx(1, abs=0.05)


def test_errors_of_the_angle_do_not_cancel_across_lost_samples():
    """One in a hundred, lost, adds 2 0.01 49 to the power of N, nearly as much as there is."""
    rng = np.random.default_rng(2)
    kept = rng.random(SAMPLES) > 0.01
    after = np.flatnonzero(np.diff(np.flatnonzero(kept)) > 1) + 1
    losses = [(int(each), 1) for each in after]
    state = investigated(drawn(3)[kept], lost=0.01, losses=losses)
    assert {finding.name for finding in state.findings} == {"dropped_samples"}
    assert n_of(state) == pytest.approx(1, abs=0.06)


def test_a_swing_of_n_is_heard_in_sums():
    """N swings by a fifth with a period of 900 samples, of which most are errors of the angle."""
    rng = np.random.default_rng(4)
    swing = np.sqrt(1 + 0.35 * np.sin(2 * np.pi * np.arange(SAMPLES) / 900))
    angle = 7 * np.diff(rng.standard_normal(SAMPLES + 1))
    state = investigated(angle + swing * rng.standard_normal(SAMPLES))
    (unknown,) = state.unknown
    assert unknown.period == pytest.approx(900, rel=0.01)


@pytest.mark.parametrize(("size", "share"), [(15.0, 0.003), (40.0, 5e-4), (400.0, 5e-4)])
def test_single_errors_are_seen_in_sums(size, share):
    """From four times what all other samples leave open of one (3.75), and two of its deviation."""
    rng = np.random.default_rng(5)
    hit = rng.random(SAMPLES) < share
    state = investigated(drawn(6) + size * hit * rng.standard_normal(SAMPLES))
    assert {finding.name for finding in state.findings} == {"outliers"}
    found = state.contamination
    assert found is not None
    # Draws are the tool's own; the numbers of errors are known from chance to some ten per cent.
    low, high = np.quantile(found.draws, [1e-3, 1 - 1e-3], axis=0)
    assert low[0] < share < high[0]
    assert low[1] < size < high[1]
    assert n_of(state) == pytest.approx(1, abs=0.06)


def test_steps_are_no_single_errors():
    """Three steps of a third of N's deviation, as a tactical gyro's bias makes them."""
    values = drawn(7)
    for at in (30_000, 61_000, 100_000):
        values[at:] += 0.3
    names = {finding.name for finding in investigated(values).findings}
    assert names == {"step"}


def test_a_knock_is_no_single_error():
    """Its first half-cycle is one that all others contradict, but it rings on."""
    values, time = drawn(8), np.arange(2000)
    values[60_000:62_000] += 14 * np.exp(-time / 140) * np.sin(2 * np.pi * 0.13 * time)
    names = {finding.name for finding in investigated(values).findings}
    assert names == {"disturbance"}
