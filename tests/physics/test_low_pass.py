"""Gains of digital low-pass filters beside the responses that SciPy computes of their taps."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import cheby1, cheby2, ellip, firwin, freqs_zpk, freqz, sosfreqz

from allanfit.physics import LowPass

DT = 0.01


def test_a_filter_with_a_window():
    """SciPy's, of 41 taps under Hamming's window: |H|, and where half of the power passes."""
    frequency = np.linspace(0, 0.5, 2001) / DT
    for taps, edge in ((41, 0.2), (101, 0.05), (31, 0.03)):
        found = np.abs(freqz(firwin(taps, 2 * edge), worN=frequency, fs=1 / DT)[1])
        cutoff = np.interp(-np.sqrt(0.5), -found, frequency)
        low_pass = LowPass(jnp.asarray(cutoff), jnp.asarray(taps - 1.0), windowed=True)
        gain = np.asarray(eqx.filter_jit(low_pass.gain)(frequency, DT))
        np.testing.assert_allclose(np.sqrt(gain), found, atol=0.01)
        assert gain[0] == pytest.approx(1)


@pytest.mark.parametrize("poles", [(0.7, 0.7), (0.9, 0.3), (0.6 + 0.3j, 0.6 - 0.3j)])
def test_a_filter_of_two_poles(poles):
    """Exponential averages of averages, equal or not, and a resonator: by freqz, to rounding."""
    _, once, twice = np.poly(poles).real
    frequency = np.linspace(0, 0.49, 500)
    response = freqz([1 + once + twice], [1, once, twice], worN=2 * np.pi * frequency)[1]
    # The square of the denominator at 0, at a quarter of the rate and at half of it: a parabola
    # in y = sin^2, which is 1 + a y + b y^2 in units of the first.
    zero, quarter, half = (abs(np.polyval([1, once, twice], z)) ** 2 for z in (1, 1j, -1))
    one = (half - zero) / zero
    both = (quarter - zero) / zero
    b = 2 * (one - 2 * both)
    a = one - b
    y = (np.sqrt(a**2 + 4 * b) - a) / (2 * b)
    low_pass = LowPass(
        jnp.asarray(np.arcsin(np.sqrt(y)) / np.pi / DT),
        jnp.asarray(2.0),
        droop=jnp.asarray(a * y),
        recursive=True,
    )
    gain = eqx.filter_jit(low_pass.gain)(frequency / DT, DT)
    np.testing.assert_allclose(np.asarray(gain), np.abs(response) ** 2, rtol=1e-4)


@pytest.mark.parametrize(("length", "times"), [(1, 2), (1.5, 3), (4, 3)])
def test_means_of_what_is_sampled_faster(length, times):
    """A comb of integrators at 64 times the rate, by freqz of its taps, and its images folded."""
    rate, taps = 64, round(64 * length)
    kernel = np.array([1.0])
    for _ in range(times):
        kernel = np.convolve(kernel, np.ones(taps) / taps)
    frequency = np.linspace(0, 0.5, 101)
    images = (frequency[:, None] + np.arange(rate)) / rate
    power = np.abs(freqz(kernel, worN=2 * np.pi * images.ravel())[1]) ** 2
    folded = power.reshape(images.shape).sum(axis=1)
    cutoff = np.interp(-0.5, -power.reshape(images.shape)[:, 0], frequency)
    low_pass = LowPass(
        jnp.asarray(cutoff / DT), jnp.asarray(float(times)), running_mean=True, oversampled=True
    )
    assert float(low_pass.taps(DT)) == pytest.approx(length, rel=1e-3)
    gain = eqx.filter_jit(low_pass.gain)(frequency / DT, DT)
    np.testing.assert_allclose(np.asarray(gain), folded / folded[0], rtol=0.01, atol=1e-7)
    assert not low_pass.after_converter


@pytest.mark.parametrize(
    ("order", "ripple", "attenuation", "edge"),
    [
        (2, 0.3, 20, 0.1),
        (4, 1.0, 40, 0.08),
        (5, 0.05, 60, 0.3),
        (7, 2.0, 80, 0.2),
        (10, 0.1, 50, 0.1),
    ],
)
def test_an_elliptic_filter(order, ripple, attenuation, edge):
    """SciPy's design of poles and zeros, over its gain at zero, which is in a valley if even."""
    sections = ellip(order, ripple, attenuation, 2 * edge, output="sos")
    assert_gain_is_that_of(sections, edge, order, ripple, attenuation, 1e-3, 1e-6)


@pytest.mark.parametrize("order", [3, 4])
def test_an_elliptic_filter_in_front_of_the_converter_folds(order):
    """SciPy's analogue design at the images of each frequency, two sampling rates to each side."""
    ripple, attenuation, edge = 0.5, 40.0, 0.3
    design = ellip(order, ripple, attenuation, edge, output="zpk", analog=True)

    def power(frequency):
        return np.abs(freqs_zpk(*design, worN=np.abs(frequency).ravel())[1]) ** 2

    fine = np.linspace(edge, 0.5, 20_001)
    cutoff = np.interp(-power(np.zeros(1))[0] / 2, -power(fine), fine)
    low_pass = LowPass(
        jnp.asarray(cutoff / DT),
        jnp.asarray(float(order)),
        ripple=jnp.asarray(ripple),
        attenuation=jnp.asarray(attenuation),
    )
    frequency = np.linspace(0, 0.5, 301)
    images = frequency[:, None] + np.arange(-2, 3)
    folded = power(images).reshape(images.shape).sum(axis=1)
    gain = np.asarray(eqx.filter_jit(low_pass.gain)(frequency / DT, DT))
    np.testing.assert_allclose(gain, folded / folded[0], rtol=1e-3, atol=1e-6)


def test_a_floor_is_white_noise_behind_a_filter():
    """A hundredth of the power, of which all is left where the filter leaves nothing."""
    low_pass = LowPass(jnp.asarray(5.0), jnp.asarray(6.0), floor=jnp.asarray(-20.0), digital=True)
    gain = low_pass.gain(jnp.asarray([0.0, 5.0, 49.9]), DT)
    np.testing.assert_allclose(np.asarray(gain), [1.0, 0.01 + 0.99 / 2, 0.01], rtol=1e-4)
    white = np.random.default_rng(0).standard_normal(200_000).astype(np.float32)
    passed = low_pass.apply(jax.random.key(0), jnp.asarray(white), DT, "point")
    above = np.abs(np.fft.rfft(np.asarray(passed)))[40_000:] ** 2 / white.size
    # Sixty thousand ordinates of that hundredth.
    assert above.mean() == pytest.approx(0.01, rel=0.03)


@pytest.mark.parametrize("order", [2, 3, 6])
def test_chebyshev_filters_are_elliptic_ones_without_lobes_or_ripple(order):
    """Without ripple the pass band has no edge, and what is next to none is near enough."""
    one = cheby1(order, 0.5, 0.2, output="sos")
    assert_gain_is_that_of(one, 0.1, order, 0.5, 350.0, 1e-3, 1e-6)
    other = cheby2(order, 50, 0.5, output="sos")
    assert_gain_is_that_of(other, 1e-3, order, 1e-12, 50.0, 0.03, 1e-3)


def assert_gain_is_that_of(sections, edge, order, ripple, attenuation, within, floor):
    """A filter's gain is SciPy's, down to a floor; its cut-off is where half is left."""

    def power(frequency):
        return np.abs(sosfreqz(sections, 2 * np.pi * np.asarray(frequency))[1]) ** 2

    beyond = np.linspace(edge, 0.4999, 200_001)
    still = power([0.0])[0]
    cutoff = np.interp(
        -0.5, -power(beyond[: np.argmin(power(beyond))]) / still, beyond[: np.argmin(power(beyond))]
    )
    low_pass = LowPass(
        jnp.asarray(cutoff / DT),
        jnp.asarray(float(order)),
        ripple=jnp.asarray(ripple),
        attenuation=jnp.asarray(float(attenuation)),
        digital=True,
    )
    assert not low_pass.contradiction()
    frequency = np.linspace(0, 0.49, 800)
    gain = np.asarray(eqx.filter_jit(low_pass.gain)(frequency / DT, DT))
    np.testing.assert_allclose(gain, power(frequency) / still, rtol=within, atol=floor)


@pytest.mark.parametrize(
    ("order", "more", "why"),
    [
        (4.0, {"digital": True}, "give both or neither"),
        (4.0, {"attenuation": jnp.asarray(40.0), "recursive": True}, "nothing else"),
        (3.5, {"attenuation": jnp.asarray(40.0), "digital": True}, "a whole number from 2 to 10"),
    ],
)
def test_a_ripple_that_no_filter_has_is_refused(order, more, why):
    low_pass = LowPass(jnp.asarray(20.0), jnp.asarray(order), ripple=jnp.asarray(0.5), **more)
    assert why in low_pass.contradiction()
