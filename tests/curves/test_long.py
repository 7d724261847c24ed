"""The Allan variance block by block against that of the whole record."""

from itertools import pairwise

import numpy as np
import pytest

import allanfit
from allanfit.curves import LongAllanVariance, LongStatistics
from allanfit.curves._rows import ROW

SAMPLES = 300_000


@pytest.fixture(scope="module")
def record():
    rng = np.random.default_rng(4)
    return 5.0 + rng.standard_normal(SAMPLES) + 0.01 * np.cumsum(rng.standard_normal(SAMPLES))


@pytest.mark.parametrize("length", [4096, 7777, SAMPLES])
def test_blocks_of_any_length_give_the_variance_of_the_whole(record, length):
    """Exactly to 8192; beyond, within 0.2 % of the standard error, which is above sqrt(n/N)."""
    sizes = allanfit.cluster_sizes(SAMPLES)
    variance = LongAllanVariance(sizes)
    ends = np.unique([0, 3, 20, *range(length, SAMPLES, length), SAMPLES])
    for begin, end in pairwise(ends):
        variance.add(record[begin:end])
    apart = variance.value() / np.asarray(allanfit.allan_variance(record, 1.0, sizes)) - 1
    assert np.max(np.abs(apart[sizes <= 8192])) < 1e-9
    assert np.max(np.abs(apart) / np.sqrt(sizes / SAMPLES)) < 2e-3


@pytest.mark.parametrize("shape", ["walk", "gravity", "ramp", "one row"])
def test_rows_of_cosines_have_the_differences_of_the_record(shape):
    """Several rows taken together, one by one, and what is left; none of what drifts is lost."""
    rng = np.random.default_rng(8)
    x = rng.standard_normal(5 * ROW + 12_345)
    x = {
        "walk": lambda: x + np.cumsum(x),
        "gravity": lambda: 9.8 + 1e-4 * x,
        "ramp": lambda: x + 0.01 * np.arange(x.size),
        "one row": lambda: x[:ROW],
    }[shape]()
    sizes = np.array([1, 2, 7, 1024, 8192])
    alone, beside = LongAllanVariance(sizes), LongStatistics()
    for start in range(0, x.size, 600_000):
        alone.add(x[start : start + 600_000])
        beside.add(x[start : start + 600_000])
    expected = np.asarray(allanfit.allan_variance(x, 1.0, sizes))
    np.testing.assert_allclose(alone.value(), expected, rtol=1e-9)
    # Where the spectrum has made the transforms already.
    beside.end_stretch()
    statistics, layout = beside.value()
    place = np.searchsorted(layout.cluster_sizes, sizes)
    np.testing.assert_allclose(np.asarray(statistics.allan)[place], expected, rtol=1e-9)


def test_an_odd_size_takes_every_position(record):
    sizes = np.array([3, 2049, 8193, 40_001])
    variance = LongAllanVariance(sizes)
    variance.add(record)
    expected = allanfit.allan_variance(record, 1.0, sizes)
    np.testing.assert_allclose(variance.value(), expected, rtol=1e-9)


def test_the_value_is_there_at_any_time_and_changes_nothing(record):
    sizes = np.array([1, 64, 100_000])
    variance = LongAllanVariance(sizes)
    variance.add(record[:1000])
    early = variance.value()
    expected = allanfit.allan_variance(record[:1000], 1.0, sizes[:2])
    np.testing.assert_allclose(early[:2], expected, rtol=1e-9)
    assert np.isnan(early[2])
    variance.add(record[1000:])
    expected = allanfit.allan_variance(record, 1.0, sizes)
    np.testing.assert_allclose(variance.value(), expected, rtol=1e-3)


def test_what_is_no_block_is_refused(record):
    with pytest.raises(ValueError, match="increasing positive integers"):
        LongAllanVariance([4, 2])
    with pytest.raises(ValueError, match="increasing positive integers"):
        LongAllanVariance([])
    variance = LongAllanVariance([1, 2])
    variance.add(record[:10])
    with pytest.raises(ValueError, match="sample 12 is not finite"):
        variance.add(np.array([0.0, 1.0, np.nan]))
    with pytest.raises(ValueError, match=r"shape \(samples,\)"):
        variance.add(record[:10].reshape(2, 5))


def test_stretches_add(record):
    """As by hand: sums of both sides of the gap over differences of both."""
    sizes = np.array([1, 6, 2049, 8192])
    variance = LongAllanVariance(sizes)
    total, positions = np.zeros(4), np.zeros(4)
    for piece in (record[:70_000], record[70_000:70_010], record[90_000:]):
        variance.add(piece[:5])
        variance.add(piece[5:])
        variance.end_stretch()
        reach = sizes[2 * sizes <= piece.size]
        count = piece.size - 2 * reach + 1
        total[: reach.size] += count * np.asarray(allanfit.allan_variance(piece, 1.0, reach))
        positions[: reach.size] += count
    np.testing.assert_allclose(variance.value()[:3], (total / positions)[:3], rtol=1e-9)
    np.testing.assert_allclose(variance.value()[3], (total / positions)[3], rtol=1e-3)
