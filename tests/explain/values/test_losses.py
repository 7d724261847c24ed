"""The record made white about samples that were lost on the way."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate
from allanfit.explain._state import begin
from allanfit.explain.values._losses import Lost, beside_losses, count_losses_out
from allanfit.recording._timestamps import read_clock

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


def test_what_was_lost_goes_into_the_next_sample():
    """Errors of the angle of 20 beside N of 1: of a lost sample all others leave 2 20 open.

    That of an angle is Q N from either side, where a walk of N goes on beneath white errors of Q;
    the sample before was lost too in some cases, which changes nothing. As much comes with errors
    of its own, known to a sixth by 150 of them; lost, the power would be 2 400.
    """
    rng = np.random.default_rng(6)
    n = 60_000
    x = 0.5 + rng.standard_normal(n) + 20 * np.diff(rng.standard_normal(n + 1))
    kept = np.ones(n, bool)
    first = np.sort(rng.choice(n // 10 - 2, 150, replace=False)) * 10 + 10
    kept[first] = False
    kept[first[:50] + 1] = False
    at = np.flatnonzero(kept)
    after = np.flatnonzero(np.diff(at) > 1) + 1
    lost = np.diff(at)[after - 1] - 1
    state = begin(x[kept], ((0, at.size),), "point", np.array([400.0, 1.0, 0.0, 0.0]), 1e-3)
    state.place += np.cumsum(np.bincount(after, lost, minlength=at.size))
    count_losses_out(state, after.size, 0)
    whole = np.cumsum(np.append(0.0, x - 0.5))
    true = whole[at[after] + 1] - whole[at[after - 1] + 1]
    errors = state.values[after] - 0.5 - true
    assert np.mean(errors**2) == pytest.approx(2 * 40, rel=0.6)
    untouched = np.delete(np.arange(at.size), after)
    assert np.array_equal(state.values[untouched], x[kept][untouched])
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.06)


def test_n_is_as_uncertain_as_errors_lost_nobody_knows_when():
    """Of n squares of normal errors the sum is known to sqrt(2/n); 400 draws, known to 4 %."""
    rng = np.random.default_rng(7)
    x = rng.standard_normal(20_000) + 7 * np.diff(rng.standard_normal(20_001))
    state = begin(x, ((0, x.size),), "point", np.array([49.0, 1.0, 0.0, 0.0]), 1e-3)
    count_losses_out(state, 50, 0)
    assert np.array_equal(state.values, x)
    # The fit knows Q to some per cent.
    assert state.foreign == pytest.approx(2 * 50 / x.size * 49, rel=0.1)
    assert state.unseen is not None
    assert np.std(state.unseen) / state.foreign == pytest.approx(np.sqrt(2 / 50), rel=0.15)


@pytest.mark.parametrize(
    ("size", "least"), [("one", 0.93), ("packets of 8", 0.93), ("geometric", 0.88)]
)
def test_the_fraction_is_known_by_events_not_by_what_each_loses(size, least):
    """Time stamps with 20 events on average, in 300 records: what held of 95 % intervals.

    Of 4,000 drawn without stamps 95.5, 95.0 and 93.4 % held, from which 300 stray by 1.2 to 1.4 %;
    `least` is three to four of these below. Single losses taken for independent, 51 and 37 % would
    hold of the last two.
    """
    rng = np.random.default_rng(7)
    samples, events = 20_000, 20
    laws = {
        "one": lambda number: np.ones(number, int),
        "packets of 8": lambda number: np.full(number, 8),
        "geometric": lambda number: rng.geometric(1 / 8, number),
    }
    mean = 1 if size == "one" else 8
    held = 0
    for _ in range(300):
        sizes = laws[size](max(rng.poisson(events), 1))
        # One event in every part, so that none run into one.
        first = 100 * (1 + rng.choice(samples // 100 - 3, sizes.size, replace=False))
        kept = np.ones(samples, bool)
        for start, lost in zip(first, sizes, strict=True):
            kept[start : start + min(lost, 99)] = False
        told = read_clock(np.flatnonzero(kept) / 100.0, "t", "s", None)
        fractions = Lost(told.lost, told.losses, deviation=told.lost_deviation).draws(
            int(kept.sum()), rng
        )
        low, high = np.quantile(fractions, [0.025, 0.975])
        held += low < events * mean / samples < high
    assert held / 300 > least


def test_one_long_loss_among_few_leaves_the_fraction_wide_open():
    """Events of 1, 7, 2, 120 and 1: the one of 120 is 1 of 5, and may as well have been 0 or 3."""
    kept = np.ones(180_000, bool)
    for at, lost in enumerate((1, 7, 2, 120, 1), start=1):
        kept[30_000 * at : 30_000 * at + lost] = False
    told = read_clock(np.flatnonzero(kept) / 100.0, "t", "s", None)
    assert told.lost == pytest.approx(131 / 180_000, rel=1e-4)
    assert told.lost_deviation == pytest.approx(np.sqrt(1 + 49 + 4 + 120**2 + 1) / 131)
    rng = np.random.default_rng(3)
    found = Lost(told.lost, told.losses, deviation=told.lost_deviation)
    low, high = np.quantile(found.draws(kept.size, rng), [0.025, 0.975]) / told.lost
    assert low < 0.25
    assert high > 3
    # Of as many by single losses it is known to a part in the root of their number.
    low, high = np.quantile(found._replace(deviation=0.0).draws(kept.size, rng), [0.025, 0.975])
    assert (high - low) / told.lost == pytest.approx(2 * 1.96 / np.sqrt(131), rel=0.1)
