"""Structures: densities against simulated records, and whether starts reach the best."""

import itertools

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.fft import dct
from scipy.signal import butter, fftconvolve, freqz, lfilter

from allanfit.explain.spectrum._climb import climb, rescale
from allanfit.explain.spectrum._density import (
    TOGETHER,
    expected_density,
    log_slopes,
    noise_at,
    parts,
)
from allanfit.explain.spectrum._holding import held_rows
from allanfit.explain.spectrum._model import Model, best, of_samples
from allanfit.explain.spectrum._ordinates import (
    LEAKAGE_GRID,
    above_leakage,
    bin_edges,
    binned,
    leakage,
    ordinates,
)
from allanfit.explain.spectrum._structure import (
    ADDED,
    FLOOR,
    Data,
    Kinds,
    bounds,
    free,
    free_floor,
    shape_of,
)
from allanfit.physics import DriftingLine, GaussMarkov, PowerLaw, Resonance

SAMPLES = 16_384


def data_of(values: np.ndarray) -> Data:
    spectrum = ordinates((values,), "point")
    bins = binned(spectrum, bin_edges(spectrum.longest))
    return Data(bins, float(values.size), 0.0, 1.0, np.ones(4, bool))


def theta_of(name: str, size: float, first: float, second: float) -> np.ndarray:
    limits = bounds(name, float(SAMPLES))
    terms = np.log([1e-12, 1.0, 1e-12, 1e-12])
    three = [np.log(size), free(first, *limits[0]), free(second, *limits[1])]
    # Of what shapes the spectrum the floor comes after these.
    return np.concatenate([terms, three, [] if name in ADDED else [FLOOR]])


@pytest.mark.parametrize(
    ("kinds", "theta"),
    [
        (Kinds(None, ("gauss_markov",)), theta_of("gauss_markov", 0.2, 90.0, 1.0)),
        (Kinds(None, ("resonance",)), theta_of("resonance", 0.2, 0.11, 20.0)),
        (Kinds(None, ("power_law",)), theta_of("power_law", 0.02, 1.4, 1.0)),
        (Kinds(None, ("drifting_line",)), theta_of("drifting_line", 0.2, 0.2, 0.05)),
        (Kinds("low_pass"), theta_of("low_pass", 1.0, 0.2, 2.0)),
        (Kinds("averaged_low_pass"), theta_of("averaged_low_pass", 1.0, 0.6, 2.0)),
        (Kinds("digital_low_pass"), theta_of("digital_low_pass", 1.0, 0.2, 2.0)),
        (Kinds("bump"), theta_of("bump", 2.0, 0.05, 0.3)),
        (
            Kinds("digital_low_pass", floored=True),
            np.append(theta_of("digital_low_pass", 1.0, 0.2, 2.0)[:-1], free_floor(0.01)),
        ),
        (
            Kinds("analogue_equiripple_4", floored=True),
            np.append(theta_of("analogue_equiripple_4", 1.0, 0.2, 40.0)[:-1], free_floor(0.01)),
        ),
    ],
)
@pytest.mark.parametrize("repeat", [1.0, 1.6])
def test_slopes_are_the_derivatives_of_the_density(kinds, theta, repeat):
    data = data_of(np.random.default_rng(0).standard_normal(SAMPLES))._replace(repeat=repeat)
    slopes = log_slopes(theta[None], kinds, data)[0]
    for place in range(theta.size):
        step = np.zeros(theta.size)
        step[place] = 1e-5
        high = np.log(expected_density(theta + step, kinds, data))
        low = np.log(expected_density(theta - step, kinds, data))
        # Idle parameters have no slope, whatever the difference quotient says.
        if np.any(slopes[:, place]):
            np.testing.assert_allclose(slopes[:, place], (high - low) / 2e-5, atol=2e-6)


def test_a_far_start_finds_a_gauss_markov_process():
    """Sizes within 5 standard deviations of the draw, by the scatter of some 180 relaxations."""
    rng = np.random.default_rng(1)
    decay = np.exp(-1 / 90.0)
    walk = np.zeros(SAMPLES)
    for k in range(1, SAMPLES):
        walk[k] = decay * walk[k - 1] + np.sqrt(1 - decay**2) * 0.45 * rng.standard_normal()
    data = data_of(rng.standard_normal(SAMPLES) + walk)
    kinds = Kinds(None, ("gauss_markov",))
    start = theta_of("gauss_markov", 0.02, 10.0, 1.0)
    reached, deviance = climb(start[None], kinds, data)
    assert deviance[0] < 1.25 * data.bins.used.sum()
    assert np.exp(reached[0, 4] / 2) == pytest.approx(0.45, rel=0.25)
    held, value = rescale(reached[0], kinds, data)
    assert value == pytest.approx(deviance[0], abs=1e-3)
    np.testing.assert_allclose(held[4], reached[0, 4], atol=1e-2)


@pytest.mark.parametrize("steps", [4, 60])
def test_each_start_of_many_comes_as_far_as_it_does_alone(steps):
    """More than climb together as a rule, of which the nearest arrive long before the last."""
    rng = np.random.default_rng(6)
    walk = lfilter([0.1], [1, -0.9], rng.standard_normal(SAMPLES))
    data = data_of(rng.standard_normal(SAMPLES) + walk)
    kinds = Kinds(None, ("gauss_markov",))
    times = np.geomspace(0.5, SAMPLES / 20, TOGETHER + 3)
    starts = np.stack([theta_of("gauss_markov", 0.02, each, 1.0) for each in times])
    reached, deviance = climb(starts, kinds, data, steps=steps)
    assert steps == 60 or deviance.max() > deviance.min() + 1
    for start, theta, value in zip(starts, reached, deviance, strict=True):
        (alone,), (least,) = climb(start[None], kinds, data, steps=steps)
        assert value == pytest.approx(least, abs=1e-6)
        np.testing.assert_allclose(
            expected_density(theta, kinds, data), expected_density(alone, kinds, data), rtol=1e-6
        )


def test_foreign_white_noise_is_taken_from_n():
    rng = np.random.default_rng(2)
    data = data_of(rng.standard_normal(SAMPLES))
    start = np.log([1e-9, 1.0, 1e-9, 1e-9])[None]
    alone, _ = climb(start, Kinds(), data)
    shared, _ = climb(start, Kinds(), data._replace(foreign=2 * 0.25))
    assert np.exp(alone[0, 1]) - np.exp(shared[0, 1]) == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "values", "first", "second"),
    [
        (GaussMarkov, (0.2**0.5, 90.0), 90.0, 1.0),
        (Resonance, (0.2**0.5, 0.11, 3.0), 0.11, 3.0),
        (PowerLaw, (1.4, 0.2), 1.4, 1.0),
        (DriftingLine, (0.2**0.5, 0.2, 0.019), 0.2, 0.095),
    ],
)
def test_added_noise_is_that_of_the_catalogue(kind, values, first, second):
    """The mean of its density over each bin, but for what the width of the bins blurs."""
    effect = kind(*map(jnp.asarray, values))
    data = data_of(np.random.default_rng(8).standard_normal(SAMPLES))
    theta = theta_of(effect.name, 0.2, first, second)
    found = expected_density(theta, Kinds(None, (effect.name,)), data)
    found = (found - expected_density(theta[:4], Kinds(), data))[data.bins.used]
    nodes = np.asarray(data.bins.nodes)[data.bins.used]
    half = (nodes[:, 2:] - nodes[:, :1]) / 2 / 0.6**0.5
    inside = nodes[:, 1:2] + half * np.linspace(-1, 1, 401)
    density = np.asarray(effect.density(jnp.asarray(inside), 1.0, "point"))
    mean = np.trapezoid(density, axis=1) / 400
    seen = mean > 0.05 * mean.max()
    np.testing.assert_allclose(found[seen], mean[seen], rtol=0.05)


@pytest.mark.parametrize(("term", "order"), [("B", 0.5), ("K", 1.0)])
def test_slow_noise_that_is_held(term, order):
    """Periodograms of 200 records of fractional differences, held; within 3 %.

    The ratio to what is not held: at low frequency it is one, whatever the mean of repeats.
    """
    repeat = 2.0
    rng = np.random.default_rng(6)
    length, freed, held = 4096, np.zeros(2049), np.zeros(2049)
    steps = np.arange(1, 2 * length)
    response = np.concatenate([[1.0], np.cumprod((steps - 1 + order) / steps)])
    for _ in range(200):
        x = fftconvolve(rng.standard_normal(4 * length), response)[2 * length : 3 * length]
        fresh = np.where(rng.random(length) < 1 / repeat, np.arange(length), 0)
        for total, each in ((freed, x), (held, x[np.maximum.accumulate(fresh)])):
            total += np.abs(np.fft.rfft((each - each.mean()) * np.hanning(length))) ** 2
    data = data_of(rng.standard_normal(length))
    frequency, used = data.bins.frequency, data.bins.used
    place = "QNBK".index(term)
    expected = held_rows(data._replace(repeat=repeat))[place] / held_rows(data)[place]
    edges = np.geomspace(0.004, 0.4, 9)
    for low, high in itertools.pairwise(edges):
        inside = used & (frequency > low) & (frequency < high)
        at = slice(round(low * length), round(high * length))
        found = held[at].sum() / freed[at].sum()
        weight = held_rows(data)[place][inside]
        mean = np.average(expected[inside], weights=weight * np.asarray(data.bins.shape)[inside])
        assert mean == pytest.approx(found, rel=0.03)


@pytest.mark.parametrize("repeat", [1.1, 1.6])
def test_white_noise_that_is_held_behind_a_filter(repeat):
    """Periodograms of 400 records through SciPy's Butterworth filter, held; within 4 deviations.

    Of white noise that is held there is three or five times as much at low frequency.
    """
    rng = np.random.default_rng(8)
    length, total = 2048, np.zeros(1025)
    window = np.hanning(length)
    for _ in range(400):
        x = lfilter(*butter(2, 0.27, fs=1.0), rng.standard_normal(length + 100))[100:]
        fresh = np.where(rng.random(length) < 1 / repeat, np.arange(length), 0)
        held = np.asarray(x)[np.maximum.accumulate(fresh)] * window
        total += np.abs(np.fft.rfft(held)) ** 2 / np.sum(window**2) / 400
    data = data_of(rng.standard_normal(length))._replace(repeat=repeat)
    expected = expected_density(
        theta_of("digital_low_pass", 1.0, 0.27, 2.0), Kinds("digital_low_pass"), data
    )
    used, frequency = data.bins.used, np.arange(1025) / length
    expected = np.interp(frequency, data.bins.frequency[used], expected[used]) / 2
    edges = np.round(np.geomspace(6, 1022, 12)).astype(int)
    for first, last in itertools.pairwise(edges):
        # A Hann window makes neighbours alike, two of which tell as much as one.
        few = np.sqrt(2 / 400 / (last - first))
        ratio = total[first:last].mean() / expected[first:last].mean()
        assert ratio == pytest.approx(1, abs=4 * few + 0.01)


def test_quantized_angle_that_is_held():
    """Periodograms of 300 records of differences of white noise, held; within 5 deviations."""
    repeat = 1.6
    rng = np.random.default_rng(5)
    length, total = 2048, np.zeros(1025)
    for _ in range(300):
        x = np.diff(rng.standard_normal(3 * length + 1))
        fresh = np.where(rng.random(length) < 1 / repeat, np.arange(length), 0)
        held = x[np.maximum.accumulate(fresh)] * np.hanning(length)
        total += np.abs(np.fft.rfft(held)) ** 2 / np.sum(np.hanning(length) ** 2) / 300
    data = data_of(rng.standard_normal(length))._replace(repeat=repeat)
    frequency, used = data.bins.frequency, data.bins.used
    expected = held_rows(data)[0]
    # Away from what a taper leaks from the mean; frequencies far below the difference's own corner
    # are within.
    inside = used & (frequency > 0.003)
    found = np.interp(frequency, np.arange(1025) / length, 2 * total)
    assert np.all(np.abs(found[inside] / expected[inside] - 1) < 5 / np.sqrt(300))


@pytest.mark.parametrize("order", [1.0, 3.0])
def test_a_filter_behind_the_converter_shapes_white_noise_and_quantization(order):
    """Against SciPy's Butterworth filter, up to its zero at the Nyquist frequency."""
    data = data_of(np.random.default_rng(6).standard_normal(SAMPLES))
    theta = theta_of("digital_low_pass", 1.0, 0.27, order)
    held, kinds = held_rows(data), Kinds("digital_low_pass")
    filtered = np.asarray(parts(theta[None], kinds, data, held)[0][0])
    plain = np.asarray(parts(theta[None, :4], Kinds(), data, held)[0][0])
    middle = np.asarray(data.bins.nodes)[:, 1]
    below = data.bins.used & (middle < 0.499)
    numerator, denominator = butter(int(order), 0.27, fs=1.0)
    # The mean over each bin, whose outer Gauss-Legendre nodes are sqrt(0.6) of its half width out.
    nodes = np.asarray(data.bins.nodes)[below]
    half = (nodes[:, 2:] - nodes[:, :1]) / 2 / 0.6**0.5
    inside = middle[below, None] + half * np.linspace(-1, 1, 401)
    response = np.abs(freqz(numerator, denominator, 2 * np.pi * inside.ravel())[1]) ** 2
    response = np.trapezoid(response.reshape(inside.shape), axis=1) / 400
    for term in (0, 1):
        ratio = filtered[term, below] / plain[term, below]
        np.testing.assert_allclose(ratio, response, rtol=1e-4)


def test_a_term_that_vanished_returns():
    """Powers climb by their logarithms, from which minus infinity is no way back."""
    x = np.diff(np.random.default_rng(7).standard_normal(SAMPLES + 1))
    data = data_of(x)
    gone = np.array([-300.0, 0.0, -300.0, -300.0])
    found = best([(Kinds(), gone)], data)[0]
    assert np.exp(found.theta[0]) == pytest.approx(1.0, rel=5 * np.sqrt(2 / (SAMPLES / 2)))


@pytest.mark.parametrize(("order", "cutoff"), [(2, 0.3), (4, 0.2)])
def test_what_the_ends_of_a_record_leak(order, cutoff):
    """Mean squares of 400 cosine transforms beyond a filter, where little else is; 5 deviations.

    What two ends leak is shared by all ordinates of one parity: two degrees of freedom a record.
    """
    rng, length = np.random.default_rng(12), 2048
    numerator, denominator = butter(order, 2 * cutoff)
    white = rng.standard_normal((400, length + 500))
    passed = np.asarray(lfilter(numerator, denominator, white))[:, 500:]
    found = np.mean(dct(passed, norm="ortho") ** 2, axis=0)
    frequency = np.arange(length) / (2 * length)
    turns = 2 * np.pi * np.concatenate([LEAKAGE_GRID, frequency])
    response = np.abs(freqz(numerator, denominator, turns)[1]) ** 2
    grid, own = np.split(response, [LEAKAGE_GRID.size])
    leaked = leakage(grid, frequency) / length
    beyond = leaked > 3 * own
    assert np.count_nonzero(beyond) > 10
    ratio = np.mean(found[beyond] / (own + leaked)[beyond])
    assert abs(ratio - 1) < 5 * np.sqrt(1 / 400)
    inside = frequency < cutoff
    assert np.mean(found[inside] / own[inside]) == pytest.approx(1.0, abs=0.01)


def test_ordinates_end_where_a_steep_filter_leaves_nothing():
    """White noise and a random walk have no such end; behind eight poles the rest is leakage."""
    rng = np.random.default_rng(13)
    white = rng.standard_normal(SAMPLES)
    steep = np.asarray(lfilter(*butter(8, 0.4), white))
    for values, top in ((white, 0.5), (np.cumsum(white), 0.5), (steep, 0.35)):
        spectrum = ordinates((values,), "point")
        found = above_leakage(spectrum, binned(spectrum, bin_edges(SAMPLES)))
        # (tan(pi f)/tan(0.2 pi))^16 is the number of samples at 0.294.
        assert found.top == 0.5 if top == 0.5 else 0.27 < found.top < 0.31


def test_a_structure_keeps_its_shapes_in_a_record_of_another_length():
    """Free parameters are bounded by the length: as they are they would be other shapes."""
    kinds = Kinds("bump", ("gauss_markov", "drifting_line"))
    samples, fewer = data_of(np.ones(64))._replace(samples=60_000.0), 40_000.0
    shapes = ((0.01, 0.2), (300.0, 1.0), (0.15, 0.005))
    names = ("bump", *kinds.added)
    three = [
        [
            1.0,
            *(
                free(each, *limit)
                for each, limit in zip(shape, bounds(name, 60_000.0), strict=True)
            ),
        ]
        for name, shape in zip(names, shapes, strict=True)
    ]
    three[0].append(FLOOR)
    model = Model(kinds, np.concatenate([np.zeros(4), *three]), 0.0)
    moved = of_samples(model, samples, samples._replace(samples=fewer)).theta
    assert np.any(np.abs(moved - model.theta) > 1e-3)
    for begin, name, shape in zip((4, 8, 11), names, shapes, strict=True):
        three = moved[begin:][:3]
        assert three[0] == 1.0
        np.testing.assert_allclose(shape_of(name, three, fewer), shape, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "first", "density"),
    [
        ("power_law", 0.6, lambda f: f**-0.6),
        ("power_law", 1.6, lambda f: f**-1.6),
        # One-sided, of variance 1 and a correlation time of 0.7 samples.
        ("gauss_markov", 0.7, lambda f: 4 * 0.7 / (1 + (2 * np.pi * 0.7 * f) ** 2)),
    ],
)
def test_averages_hold_what_they_fold(name, first, density):
    """Counted from many multiples of the rate; sinc^2 alone is 40 % short at half of it."""
    data = data_of(np.random.default_rng(0).standard_normal(SAMPLES))._replace(averaging=1.0)
    three = theta_of(name, 1.0, first, 1.0)[4:]
    frequency = np.array([0.02, 0.1, 0.3, 0.499])
    # Every sine is that of the frequency itself, and falls off as its square beyond.
    multiples = np.arange(-20_000, 20_001)
    true = frequency[:, None] + multiples
    folded = np.sum(np.sinc(true) ** 2 * density(np.abs(true)), axis=1)
    found = noise_at(name, three, frequency, data)
    np.testing.assert_allclose(found, folded, rtol=2e-4)
    assert found[-1] > 1.05 * np.sinc(0.499) ** 2 * density(0.499)
