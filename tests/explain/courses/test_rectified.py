"""Steps there and back are one shift of the mean if the noise is louder between them."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate

SAMPLES = 120_000
LOUD = ((0.08, 0.14), (0.37, 0.74), (0.77, 0.91))
Q, RATIO = 7.0, 1.3


def drawn(seed: int, shift: float, ratio: float):
    """White noise of one that is louder at times, hardly heard beside errors of an angle."""
    rng = np.random.default_rng(seed)
    loud = np.zeros(SAMPLES, bool)
    for start, stop in LOUD:
        loud[int(start * SAMPLES) : int(stop * SAMPLES)] = True
    angle = Q * np.diff(rng.standard_normal(SAMPLES + 1))
    return angle + np.where(loud, ratio, 1.0) * rng.standard_normal(SAMPLES) + shift * loud


def names_and_edges(values):
    state = investigate(values, ((0, SAMPLES),), "point", np.array([Q**2, 1.0, 0.0, 0.0]))
    edges = None
    if state.modulation is not None:
        edges = np.flatnonzero(np.diff(state.modulation.loud)) / SAMPLES
    return sorted(finding.name for finding in state.findings), edges


@pytest.mark.parametrize("shift", [0.3, 0.6])
def test_a_shift_has_the_edges_of_its_steps(shift):
    """The smaller shift is taken at first, with loud times that lack a pause, and steps beside."""
    names, edges = names_and_edges(drawn(0, shift, RATIO))
    assert names == ["variance_modulation", "vibration_rectification"]
    assert edges == pytest.approx(np.ravel(LOUD), abs=1e-3)


def test_steps_between_which_noise_lasts_stay_steps():
    names, _ = names_and_edges(drawn(0, 0.6, 1.0))
    assert set(names) == {"step"}
