"""Curves of an explanation against densities of the noises that it names."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.explain._curves import _labels, _lines
from allanfit.explain._effect import Effect
from allanfit.explain._state import begin
from allanfit.explain.spectrum._model import Model
from allanfit.explain.spectrum._structure import Kinds, bounds, free
from allanfit.physics import DriftingLine, Resonance

RATE, SAMPLES, N = 50.0, 30_000, 0.005


def state_of(values: np.ndarray, name: str, size: float, first: float, second: float):
    """An investigation that knows N and one noise, shaped as in `bounds`."""
    power = np.array([0.0, N**2 * RATE, 0.0, 0.0])
    state = begin(values, ((0, values.size),), "point", power, 0.01)
    limits = bounds(name, float(values.size))
    shape = [free(first, *limits[0]), free(second, *limits[1])]
    theta = np.concatenate([np.log(power + 1e-300), [2 * np.log(size)], shape])
    state.model = Model(Kinds(None, (name,)), theta, 0.0)
    return state


@pytest.mark.parametrize(
    ("noise", "second", "half"),
    [
        # Ordinates are 1/600 Hz apart, and bins are half a hertz wide here.
        (Resonance(jnp.asarray(0.01), jnp.asarray(11.3), jnp.asarray(500.0)), 500.0, 0.0113),
        (DriftingLine(jnp.asarray(0.01), jnp.asarray(11.3), jnp.asarray(0.006)), 0.006, 0.006),
    ],
    ids=["resonance", "drifting line"],
)
def test_close_to_a_line_the_model_is_as_narrow_as_it_is(noise, second, half):
    """Within 2 %: a point stands for all frequencies up to half way to its neighbours."""
    name, dt = noise.name, 1 / RATE
    breadth = second if name == "resonance" else second / 11.3
    rng = np.random.default_rng(3)
    values = N * RATE**0.5 * rng.standard_normal(SAMPLES)
    values += np.asarray(noise.sample(jax.random.key(1), SAMPLES, dt, "point"))
    state = state_of(values, name, 0.01, 11.3 * dt, breadth)
    size = {"resonance": "sigma", "drifting_line": "amplitude"}[name]
    told = {size: 0.01, "frequency": 11.3}
    draws = {key: np.full(2, value) for key, value in told.items()}
    effect = Effect(name, 0.99, {}, draws, band_hz=(11.3 - 2 * half, 11.3 + 2 * half))
    (line,) = _lines(state, [effect], dt, 1.0)
    frequency = np.array(line["frequency_hz"])
    expected = 2 * N**2 + np.asarray(noise.density(jnp.asarray(frequency), dt, "point"))
    assert frequency.min() < 11.3 - 4 * half < 11.3 + 4 * half < frequency.max()
    np.testing.assert_allclose(line["model"], expected, rtol=0.02)
    peak = frequency[np.argmax(line["model"])]
    assert peak == pytest.approx(11.3, abs=1 / 600)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.5], ids=["on", "near", "between"])
def test_a_sinusoid_is_as_broad_as_the_window_makes_it(part):
    """Far above the noise the spectrum of the record has nothing else, wherever ordinates are."""
    frequency = (6_780 + part) * RATE / SAMPLES
    time = np.arange(SAMPLES) / RATE
    values = N * RATE**0.5 * np.random.default_rng(5).standard_normal(SAMPLES)
    values += 50.0 * np.sin(2 * np.pi * frequency * time + 0.4)
    power = np.array([0.0, N**2 * RATE, 0.0, 0.0])
    state = begin(values, ((0, SAMPLES),), "point", power, 0.01)
    draws = {"amplitude": np.full(2, 50.0), "frequency": np.full(2, frequency)}
    effect = Effect("sinusoid", 0.99, {}, draws, band_hz=(frequency, frequency))
    (line,) = _lines(state, [effect], 1 / RATE, 1.0)
    density, model = np.array(line["density"]), np.array(line["model"])
    lobe = np.abs(np.array(line["frequency_hz"]) - frequency) < 1.6 * RATE / SAMPLES
    assert lobe.sum() >= 3
    np.testing.assert_allclose(model[lobe], density[lobe], rtol=0.02)


def test_noises_of_one_name_are_counted_by_themselves_the_strongest_first():
    """As many of another name are between them; a line of amplitude A has the power A^2/2."""
    state = state_of(np.random.default_rng(4).standard_normal(2_000), "resonance", 1.0, 0.1, 9.0)
    names = ("drifting_line", "resonance", "drifting_line", "resonance", "gauss_markov")
    logs = 2 * np.log([0.1, 0.2, 0.3, 0.25, 0.5])
    threes = np.column_stack([logs, np.zeros((5, 2))])
    theta = np.concatenate([state.model.theta[:4], threes.ravel()])
    state.model = Model(Kinds(None, names), theta, 0.0)
    assert _labels(state, []) == [
        "drifting_line 2",
        "resonance 2",
        "drifting_line",
        "resonance",
        "gauss_markov",
    ]
    # One resonance is a line that wanders, and weaker than 0.3/sqrt(2).
    state.wandering = {1}
    assert _labels(state, [])[:3] == ["drifting_line 3", "drifting_line 2", "drifting_line"]
