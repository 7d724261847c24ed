"""A line of one phase whose strength changes, against normal noise of its spectrum."""

import numpy as np
from scipy.integrate import quad

from allanfit.explain.lines._one_phase import one_phase

BAND, MIDDLE = 301, 150.0
WIDTH = 4.0


def white(rng: np.random.Generator) -> np.ndarray:
    return (rng.standard_normal(BAND) + 1j * rng.standard_normal(BAND)) / np.sqrt(2)


def excess(power: float):
    return lambda order: power * np.exp(-((order / WIDTH) ** 2) / 2)


def line(strength: np.ndarray, phase: float = 1.0) -> np.ndarray:
    return strength * np.exp(1j * (2 * np.pi * MIDDLE * np.arange(BAND) / BAND + phase))


def test_the_likelihood_is_that_of_amplitudes_in_phase_averaged_over_the_phase():
    """By quadrature: in-phase amplitudes with twice the excess, those in quadrature with none."""
    rng = np.random.default_rng(1)
    z, power = white(rng) + line(np.full(BAND, 0.2)), 3.0
    ordinates = np.fft.fft(z) / np.sqrt(BAND)
    order = np.arange(1, 151)
    above, below = ordinates[150 + order], ordinates[150 - order]
    spread = 1 + 2 * excess(power)(order)

    def likelihood(phase):
        turn = np.exp(-1j * phase)
        amplitude = (above * turn + np.conj(below * turn)) / np.sqrt(2)
        log = np.sum(np.abs(amplitude) ** 2 * (1 - 1 / spread) - np.log(spread))
        carrier = (ordinates[150] * turn).real ** 2
        return np.exp(log + carrier * (1 - 1 / (1 + 2 * power)) - np.log(1 + 2 * power) / 2)

    expected = np.log(quad(likelihood, 0, np.pi, epsabs=0, limit=400)[0] / np.pi)
    both = np.concatenate([excess(power)(order)] * 2 + [[power]])
    told = np.abs(np.concatenate([above, below, [ordinates[150]]])) ** 2
    normal = np.sum(told * both / (1 + both) - np.log1p(both))
    found = one_phase(z, MIDDLE, 0.0, excess(power))
    np.testing.assert_allclose(found.gain, expected - normal, rtol=1e-6)


def test_lines_that_are_switched_are_told_from_noise_and_from_lines_that_wander():
    """Ten of each, seeds fixed; of noise the gain is below zero by some standard deviations."""
    rng = np.random.default_rng(2)
    time = np.arange(BAND) / BAND
    for _ in range(10):
        on = np.abs(time - rng.uniform(0.3, 0.7)) < 0.1
        found = one_phase(white(rng) + line(2.0 * on), MIDDLE, 2.0, excess(20.0))
        assert found.gain > 3
        assert found.on is not None
        assert np.mean((time > found.on[0]) & (time < found.on[1]) == on) > 0.95
        wander = line(np.full(BAND, 0.9)) * np.exp(4j * np.sin(2 * np.pi * (time + rng.random())))
        noise = np.zeros(BAND, complex)
        about = np.arange(-20, 21)
        noise[150 + about] = np.sqrt(excess(20.0)(about) * BAND) * white(rng)[: about.size]
        for other in (wander, np.fft.ifft(noise)):
            assert one_phase(white(rng) + other, MIDDLE, 2.0, excess(20.0)).gain < -2
