"""Gains of digital low-pass filters beside the responses that SciPy computes of their taps."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import firwin, freqz

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
