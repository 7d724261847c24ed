"""Filters of all shapes: named once, with nothing made up beside them."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import (
    bessel,
    butter,
    cheby1,
    cheby2,
    cont2discrete,
    ellip,
    firwin,
    freqz,
    iirnotch,
    lfilter,
    remez,
    sosfilt,
    sosfreqz,
    tf2sos,
)

from allanfit.explain._investigate import investigate
from allanfit.explain._state import begin
from allanfit.explain.spectrum._leakage import leave_leakage
from allanfit.explain.spectrum._structure import (
    EACH,
    FLOOR,
    SHAPE,
    TERMS,
    WINDOWED,
    Kinds,
    free_filter,
    shape_of,
    sieve,
)

SAMPLES = 30_000


def noise(seed: int, samples: int = SAMPLES + 500) -> np.ndarray:
    """White noise of one a sample, and a random walk."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.standard_normal(samples))
    return rng.standard_normal(samples) + 1e-3 * walk


def found_in(values: np.ndarray):
    """What an investigation names, the filter, and N."""
    values = values[-SAMPLES:]
    power = np.array([0.0, np.var(values), 0.0, 1e-6])
    state = investigate(values, ((0, SAMPLES),), "point", power)
    assert state.model.kinds.filtering
    names = [finding.name for finding in state.findings]
    four = state.model.theta[SHAPE]
    return names, sieve(state.model.kinds.shaping or "", four, float(SAMPLES)), state


@pytest.mark.parametrize(("taps", "times"), [(10, 1), (6, 2)])
def test_a_running_mean_is_known_by_its_zeros(taps, times):
    """By convolution; N within five of its standard errors, which are about 0.6 %."""
    x = noise(taps)
    for _ in range(times):
        x = np.convolve(x, np.ones(taps) / taps, "valid")
    names, low_pass, state = found_in(x)
    assert names == ["low_pass"]
    assert low_pass.running_mean
    assert float(low_pass.taps(1.0)) == pytest.approx(taps, abs=1e-6)
    assert float(low_pass.order) == pytest.approx(times, abs=1e-6)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_the_comb_of_a_sigma_delta_converter_is_known():
    """Means over two samples of the log, three times over, at eight times its rate."""
    fine = np.random.default_rng(13).standard_normal(8 * (SAMPLES + 10)) * np.sqrt(8)
    for _ in range(3):
        fine = np.convolve(fine, np.ones(16) / 16, "valid")
    names, low_pass, state = found_in(fine[::8])
    assert names == ["low_pass"]
    assert low_pass.oversampled
    assert float(low_pass.taps(1.0)) == pytest.approx(2, abs=1e-6)
    assert float(low_pass.order) == pytest.approx(3, abs=1e-6)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_an_average_of_two_is_that_pole_which_the_bilinear_transform_puts_there():
    """(1 + z^-1)/2 is both, with a cut-off at a quarter of the rate."""
    names, low_pass, state = found_in(np.convolve(noise(2), [0.5, 0.5], "valid"))
    assert names == ["low_pass"]
    assert float(low_pass.cutoff_frequency) == pytest.approx(0.25, rel=0.03)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_a_bessel_filter_droops_and_is_no_filter_with_lines():
    names, low_pass, state = found_in(sosfilt(bessel(2, 0.3, output="sos"), noise(4)))
    assert names == ["low_pass"]
    assert 0.3 < float(low_pass.droop) < 0.95
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize(
    ("sections", "order"),
    [
        (cheby1(4, 1.0, 0.24, output="sos"), 4),
        (ellip(4, 1.0, 40, 0.156, output="sos"), 4),
        (cheby2(3, 40, 0.42, output="sos"), 3),
    ],
    ids=["Chebyshev", "elliptic", "inverse Chebyshev"],
)
def test_a_filter_with_ripple_is_one_filter(sections, order):
    """They were filters with resonances, and N a hundredth of itself; within five deviations."""
    # Over what it leaves at zero frequency, where N is read.
    still = np.prod(sections[:, :3].sum(axis=1) / sections[:, 3:].sum(axis=1))
    names, low_pass, state = found_in(sosfilt(sections, noise(8, SAMPLES + 4000)) / still)
    assert names == ["low_pass"]
    assert low_pass.ripple is not None
    assert float(low_pass.order) == order
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize(
    ("order", "ripple", "attenuation", "edge"),
    # The last one's lobes are lost in what passes, as those of Chebyshev's filters are.
    [(3, 1, 30, 0.15), (4, 0.5, 40, 0.25), (5, 0.5, 150, 0.2)],
)
def test_an_elliptic_filter_in_front_of_the_converter_is_one_filter(
    order, ripple, attenuation, edge
):
    """At sixteen times the rate, one value in sixteen: its lobes fold, and a line was made of it.

    Half of the power passes where SciPy says; N within five of its standard errors of 1 %.
    """
    sections = ellip(order, ripple, attenuation, edge / 8, output="sos")
    frequency = np.linspace(0, 0.5, 20_001)
    power = np.abs(sosfreqz(sections, 2 * np.pi * frequency / 16)[1]) ** 2
    fine = np.random.default_rng(order).standard_normal(16 * (SAMPLES + 400)) * 4
    names, low_pass, state = found_in(sosfilt(sections, fine)[::16] / np.sqrt(power[0]))
    assert names == ["low_pass"]
    assert low_pass.ripple is not None
    assert not low_pass.digital
    assert float(low_pass.order) == order
    cutoff = frequency[np.flatnonzero(power > power[0] / 2)[-1]]
    assert float(low_pass.cutoff_frequency) == pytest.approx(cutoff, rel=0.02)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize(
    ("sections", "part"),
    [
        (butter(4, 0.2, output="sos"), 0.05),
        (butter(2, 0.1, output="sos"), 0.1),
        (ellip(4, 0.5, 40, 0.5, output="sos"), 0.02),
        (tf2sos(firwin(63, 0.4), 1), 0.1),
        # A hump beside white noise came before a filter with none.
        (cheby2(3, 40, 0.492, output="sos"), 0.016),
    ],
    ids=["fourth order", "second order", "elliptic", "sixty-three taps", "inverse Chebyshev"],
)
def test_white_noise_behind_a_filter_is_part_of_it(sections, part):
    """A converter's noise made a line of the foot of an edge, or the filter had no name at all.

    Within a decibel: where an analogue filter is as likely, quantization takes a part of it.
    """
    still = np.prod(sections[:, :3].sum(axis=1) / sections[:, 3:].sum(axis=1))
    values = sosfilt(sections, noise(17, SAMPLES + 4000)) / still
    values += part * np.random.default_rng(18).standard_normal(values.size)
    names, low_pass, state = found_in(values)
    assert names == ["low_pass"]
    assert state.model.kinds.floored
    assert low_pass.floor is not None
    assert float(low_pass.floor) == pytest.approx(20 * np.log10(part), abs=1)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.05)


def test_exponential_averages_of_averages_have_poles_and_no_zeros():
    """Two unequal poles: the response that SciPy has, and N within five of its standard errors."""
    two = np.convolve([1, -0.6], [1, -0.8])
    names, low_pass, state = found_in(lfilter([0.08], two, noise(6)))
    assert names == ["low_pass"]
    assert low_pass.recursive
    frequency = np.linspace(0, 0.49, 50)
    passed = np.abs(freqz([0.08], two, worN=2 * np.pi * frequency)[1]) ** 2
    np.testing.assert_allclose(
        np.asarray(low_pass.gain(jnp.asarray(frequency), 1.0)), passed, rtol=0.1
    )
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize("part", [0.3, 0.35, 0.5])
def test_behind_one_pole_all_noise_is_no_correlated_noise(part):
    """It was one cause of twenty, without white noise, and N's interval reached to zero."""
    _, _, state = found_in(lfilter([part], [1, part - 1], noise(11, SAMPLES + 2000)))
    found = state.finding("low_pass")
    assert found.rivals.keys().isdisjoint({"gauss_markov"})
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.06)


def test_correlated_noise_above_white_is_no_filter():
    """Such noise of more than three times the power, which one pole is like before it flattens."""
    shocks = np.random.default_rng(12).standard_normal(SAMPLES + 2000)
    x = noise(13, SAMPLES + 2000) + lfilter([1], [1, -0.85], shocks)
    values = x[-SAMPLES:]
    power = np.array([0.0, np.var(values), 0.0, 1e-6])
    state = investigate(values, ((0, SAMPLES),), "point", power)
    assert [finding.name for finding in state.findings] == ["gauss_markov"]
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.12)


def test_a_steep_filter_of_finite_response_is_one_filter():
    """SciPy's equiripple half-band filter of 47 taps, and codes of a thirtieth of the noise."""
    taps = remez(47, [0, 0.2, 0.3, 0.5], [1, 0], fs=1.0)
    values = np.convolve(noise(5), taps, "valid")
    code = values.std() / 30
    names, low_pass, state = found_in(np.round(values / code) * code)
    assert names == ["low_pass"]
    assert low_pass.windowed
    # Half of the amplitude passes at a quarter of the rate, half of the power a little below.
    assert 0.235 < float(low_pass.cutoff_frequency) < 0.25
    # An edge from .2 to .3 cycles a sample takes Hamming's window some 3.3/.1 samples.
    assert 25 < float(low_pass.order) < 50
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_a_window_that_a_running_mean_stands_for_at_first_is_one_filter():
    """What its ends leak hides the stop band until it is left out; a resonance stood beside."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal(20_100) + 1e-4 * np.cumsum(rng.standard_normal(20_100))
    values = lfilter(firwin(31, 0.08), [1.0], values)[100:]
    state = investigate(values, ((0, values.size),), "point", np.array([0.0, 0.1, 0.0, 1e-8]))
    assert [finding.name for finding in state.findings] == ["low_pass"]
    assert np.exp(state.model.theta[1]) == pytest.approx(1.0, rel=0.05)


def test_a_window_so_narrow_that_its_two_edges_meet_is_one_filter():
    """SciPy's 31 taps with a corner at a third of the window's width; N to five errors of 1 %."""
    taps = firwin(31, 2 * 0.03)
    names, low_pass, state = found_in(np.convolve(noise(7), taps, "valid"))
    assert names == ["low_pass"]
    assert low_pass.windowed
    assert float(low_pass.cutoff_frequency) == pytest.approx(0.0262, rel=0.05)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.05)


def test_a_decimator_is_one_filter_though_it_leaves_nothing_beyond():
    """SciPy's filter of 255 taps at 36 % of the rate that every tenth sample leaves."""
    fine = np.random.default_rng(12).standard_normal(10 * (SAMPLES + 500)) * np.sqrt(10)
    taps = firwin(255, 2 * 0.036)
    names, low_pass, state = found_in(np.convolve(fine, taps, "valid")[::10])
    assert names == ["low_pass"]
    assert low_pass.windowed
    frequency, response = freqz(taps, worN=4096, fs=10)
    half = np.interp(0.5, (np.abs(response) ** 2)[::-1], frequency[::-1])
    assert float(low_pass.cutoff_frequency) == pytest.approx(half, rel=0.01)
    assert float(low_pass.order) == pytest.approx(25.4, rel=0.1)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_an_oscillator_that_rises_before_its_corner_is_a_filter():
    """Damped by 0.6, before the converter: sampled 8 times as fast and taken every 8th time."""
    turn = 2 * np.pi * 0.15
    numerator, denominator, _ = cont2discrete(
        ([turn**2], [1, 2 * 0.6 * turn, turn**2]), 1 / 8, "bilinear"
    )
    fine = np.random.default_rng(5).standard_normal(8 * (SAMPLES + 500)) * np.sqrt(8)
    names, low_pass, _ = found_in(lfilter(numerator[0], denominator, fine)[::8])
    assert names == ["low_pass"]
    assert float(low_pass.droop) < -0.2
    # Half of the power passes where x^2 + (4 zeta^2 - 2) x = 1, x being the square of f/f_0.
    x = np.roots([1, 4 * 0.36 - 2, -1]).max()
    assert float(low_pass.cutoff_frequency) == pytest.approx(0.15 * np.sqrt(x), rel=0.08)


def test_what_passes_beyond_a_notch_is_not_left_out():
    """A steep edge at the notch would explain all, were what refutes it taken for leakage."""
    rng = np.random.default_rng(21)
    passed = lfilter(*butter(2, 0.5), rng.standard_normal(SAMPLES))
    values = lfilter(*iirnotch(0.3, 4), passed)
    power = np.array([0.0, np.var(values), 0.0, 1e-6])
    state = begin(values, ((0, SAMPLES),), "point", power, alarm=1e-3)
    edge = free_filter(WINDOWED, 0.14, 100.0, SAMPLES)
    theta = np.concatenate([state.model.theta[:TERMS], edge, [FLOOR]])
    state.model = state.model._replace(kinds=Kinds(WINDOWED), theta=theta)
    leave_leakage(state)
    assert state.spectrum.clean(np.array([0.2, 0.24])).all()


def test_a_filter_that_comes_last_filters_added_noise_too():
    """Poles at Nyquist leave nothing there of a relaxation of 400 samples, added before them.

    N within five standard errors of .6 %, and the time within four of some 10 %.
    """
    rng, decay = np.random.default_rng(13), np.exp(-1 / 400)
    drive = 3 * np.sqrt(1 - decay**2) * rng.standard_normal(SAMPLES + 500)
    relaxing = noise(13) + lfilter([1.0], [1.0, -decay], drive)
    names, low_pass, state = found_in(lfilter(*butter(2, 0.6), relaxing))
    assert names == ["low_pass", "gauss_markov"]
    assert state.model.kinds.last
    assert low_pass.digital
    assert float(low_pass.cutoff_frequency) == pytest.approx(0.3, rel=0.02)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)
    three = state.model.theta[-EACH:]
    assert float(shape_of("gauss_markov", three, float(SAMPLES))[0]) == pytest.approx(400, rel=0.4)


@pytest.mark.parametrize(("corner", "order"), [(0.62, 4), (0.6, 5), (0.55, 4)])
def test_a_steep_edge_beyond_nyquist_is_no_resonance_before_it(corner, order):
    """What passes there folds onto what is before, which is then twice as strong.

    At sixteen times the rate, one value in sixteen; N is what shows at low frequency.
    """
    fine = np.random.default_rng(order).standard_normal(16 * (SAMPLES + 50)) * 4
    sos = butter(order, corner, fs=16, output="sos")
    names, low_pass, state = found_in(sosfilt(sos, fine)[::16])
    assert names == ["low_pass"]
    assert float(low_pass.cutoff_frequency) > 0.5
    _, response = freqz(
        *butter(order, corner, fs=16), worN=[1e-6, *2 * np.pi * np.arange(1, 9) / 16]
    )
    weight = np.array([1.0] + [2.0] * 7 + [1.0])
    folded = np.sum(weight * np.abs(response) ** 2)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(np.sqrt(folded), rel=0.03)
