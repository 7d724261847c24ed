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
