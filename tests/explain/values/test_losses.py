"""The record made white about samples that were lost on the way."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate
from allanfit.explain._state import begin
from allanfit.explain.values._losses import beside_losses

SAMPLES, EACH = 1024, 4000


def test_a_white_record_is_as_strong_about_a_loss_as_told():
    """Records of differences of white errors, each closed up in its middle and made white."""
    rng = np.random.default_rng(0)
    slow = 0.05
    frequency = np.arange(SAMPLES // 2 + 1) / SAMPLES
    density = slow + 4 * np.sin(np.pi * frequency) ** 2
    errors = rng.standard_normal((EACH, SAMPLES + 2))
    x = np.diff(errors) + np.sqrt(slow) * rng.standard_normal((EACH, SAMPLES + 1))
    closed = np.delete(x, SAMPLES // 2, axis=1)
    white = np.fft.irfft(np.fft.rfft(closed) / np.sqrt(density))
    measured = np.mean(white**2, axis=0)

    one = x[:4].ravel()
    state = begin(one, ((0, one.size),), "point", np.array([1.0, slow, 0.0, 0.0]), 1e-3)
    after = one.size // 2
    state.place[after:] += 1
    told = beside_losses(state) ** 2
    told_here = told[after - 4 : after + 4]
    measured_here = np.roll(measured, -SAMPLES // 2)[np.arange(-4, 4)]
    # A mean square of so many is known to sqrt(2/EACH), and the fitted spectrum to some per cent.
    assert told_here == pytest.approx(measured_here, rel=0.1)
    assert measured_here.max() > 2
    assert told[: after - 200] == pytest.approx(1)


def test_no_outliers_where_losses_break_a_correlation():
    """Where quantization rules, 200 losses seemed to be as many outliers."""
    rng = np.random.default_rng(1)
    n = 120_000
    x = rng.standard_normal(n) + 7 * np.diff(rng.standard_normal(n + 1))
    gone = np.sort(rng.choice(n - 2, 200, replace=False)) + 1
    kept = np.ones(n, bool)
    kept[gone] = False
    after = np.flatnonzero(np.diff(np.flatnonzero(kept)) > 1) + 1
    state = investigate(
        x[kept],
        ((0, n - 200),),
        "point",
        np.array([49.0, 1.0, 0.0, 0.0]),
        lost=200 / n,
        losses=[(int(each), 1) for each in after],
    )
    assert {finding.name for finding in state.findings} == {"dropped_samples"}
