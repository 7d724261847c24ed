"""Samples lost without a time stamp, by the phase of a line."""

from itertools import pairwise, product

import jax
import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import poisson, skellam

import allanfit
from allanfit.explain._investigate import investigate
from allanfit.explain.lines import _phase
from allanfit.explain.lines._phase import Jumps, Turning


def band(rng, turns, power: float):
    """A line in complex white noise of one, of phases in turns."""
    noise = rng.standard_normal((2, turns.size)) / np.sqrt(2)
    return np.sqrt(power) * np.exp(2j * np.pi * turns) + noise[0] + 1j * noise[1]


def test_jumps_are_a_poisson_process_and_diffusion_a_walk():
    jumps, place = Jumps(7, 60), np.arange(60)
    counts = np.arange(30)
    expected = np.bincount(7 * counts % 60, poisson.pmf(counts, 0.8), minlength=60)
    (move,) = jumps.moves([Turning(0.0, 0.8, 0.0)])
    np.testing.assert_allclose(move[:, 0], expected, atol=1e-10)
    np.testing.assert_allclose(move[:, 5], np.roll(expected, 5), atol=1e-10)
    # As many steps to either side as the difference of two Poisson variates.
    rate = 0.01 / (2 * np.pi / 60) ** 2 / 2
    away = (place + 30) % 60 - 30
    (move,) = _phase.NO_JUMPS._replace(phases=60).moves([Turning(0.0, 0.0, 0.01)])
    np.testing.assert_allclose(move[:, 0], skellam.pmf(away, rate, rate), atol=1e-10)
    (move,) = _phase.ANY_JUMPS.moves([Turning(0.0, 0.3, 0.0)])
    np.testing.assert_allclose(move[1:, 0], -np.expm1(-0.3) / 48, atol=1e-10)


def test_all_courses_of_the_phase_are_counted():
    """The sum over every course of four moments, each drawn by its chance."""
    jumps, way = Jumps(1, 6), Turning(0.3, 0.4, 0.2)
    z = band(np.random.default_rng(1), 0.2 * np.arange(4), 0.5)
    power = np.mean(np.abs(z) ** 2) - 1
    (move,), (counted,) = jumps.moves([way]), jumps.moves([way], counted=True)
    total, counts = 0.0, np.zeros(4)
    for course in product(range(6), repeat=4):
        phase = 2 * np.pi * np.array(course) / 6 + 0.3 * np.arange(4)
        amplitude = np.sqrt(power) * np.exp(1j * phase)
        chance = np.exp(np.sum(np.abs(z) ** 2 - np.abs(z - amplitude) ** 2)) / 6
        chance *= np.prod([move[b, a] for a, b in pairwise(course)])
        total += chance
        for at, (a, b) in enumerate(pairwise(course)):
            counts[at + 1] += chance * counted[b, a] / move[b, a]
    np.testing.assert_allclose(_phase.log_likelihood(z, way, jumps), np.log(total), rtol=1e-9)
    np.testing.assert_allclose(_phase.jumps_between(z, way, jumps), counts / total, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.4, 1.3, 2.9, 5.5])
def test_jumps_are_by_whole_steps_that_are_near(angle):
    """Of so many fractions one is within a few thousandths of a turn (Dirichlet's theorem)."""
    jumps = _phase.jumps_by(angle)
    assert jumps.steps is not None
    assert abs(2 * np.pi * jumps.steps / jumps.phases - angle) < 0.01


def test_jumps_are_found_and_placed():
    rng = np.random.default_rng(3)
    drift, angle = 0.05, 1.1
    often = rng.poisson(0.04, 2000)
    turns = (drift * np.arange(2000) + angle * np.cumsum(often)) / (2 * np.pi)
    z, jumps = band(rng, turns, 2.0), _phase.jumps_by(angle)
    # The middle of the Lorentz curve, and half its width.
    middle, width = drift + 0.04 * np.sin(angle), 0.04 * (1 - np.cos(angle))
    way = _phase.search(z, middle, width, jumps, 0.04)
    number, deviation = _phase.jumps_told(z, way, jumps)
    assert abs(number - often.mean()) < 3 * deviation
    assert abs(way.drift - drift) < 0.01
    # All but a few within two moments.
    course = np.cumsum(_phase.jumps_between(z, way, jumps))
    assert np.mean(np.abs(course - np.cumsum(often)) > 0.5) < 0.08
    other = _phase.search(z, middle, width, _phase.NO_JUMPS, 0.0)
    assert (
        _phase.log_likelihood(z, way, jumps) - _phase.log_likelihood(z, other, _phase.NO_JUMPS) > 20
    )


def record(kind: str) -> np.ndarray:
    """White noise of one with a line as strong, 100 samples lost or none."""
    rng = np.random.default_rng(8)
    samples, share, frequency = 50_000, 2e-3, 0.07
    turns = frequency * np.arange(samples)
    kept = np.ones(samples, bool)
    half = share * (1 - np.cos(2 * np.pi * frequency)) / (2 * np.pi)
    if kind == "lost":
        kept = rng.random(samples) >= share
    elif kind == "diffuses":
        turns = turns + np.cumsum(np.sqrt(half / np.pi) * rng.standard_normal(samples))
    elif kind == "sweeps":
        turns = turns + 2 * half * np.arange(samples) ** 2 / samples
    line = np.sin(2 * np.pi * turns)
    if kind == "rings":
        decay = np.exp(-2 * np.pi * half)
        poles = [1.0, -2 * decay * np.cos(2 * np.pi * frequency), decay**2]
        line = np.asarray(lfilter([1.0], poles, rng.standard_normal(samples)))
        line /= np.sqrt(2) * line.std()
    return (rng.standard_normal(samples) + line)[kept]


def found_in(x: np.ndarray):
    return investigate(x, ((0, x.size),), "point", np.array([0.0, 1.0, 0.0, 0.0]))


def test_a_line_tells_of_losses_that_no_time_stamp_does():
    x = record("lost")
    state = found_in(x)
    assert [finding.name for finding in state.findings] == ["dropped_samples", "sinusoid"]
    lost = state.findings[0].detail
    assert abs(lost.fraction - (50_000 - x.size) / 50_000) < 3 * lost.deviation
    assert lost.frequency == pytest.approx(0.07, abs=2e-5)
    # As long as it was, but for what is lost about the ends.
    assert abs(state.moment(x.size) - 50_000) < 4
    assert state.lines[0].shape["frequency"] == pytest.approx(0.07, abs=1e-6)


@pytest.mark.parametrize("kind", ["diffuses", "sweeps", "rings"])
def test_no_losses_where_a_line_goes_another_way(kind):
    assert "dropped_samples" not in {finding.name for finding in found_in(record(kind)).findings}


def test_time_goes_by_where_a_real_log_lost_samples(shared):
    """Its time stamps, which are too uneven to tell single losses, are not looked at.

    A window about each loss is longer than others by what was lost in it, and by chance by a
    seventh of a sample on average: false alarm .003.
    """
    recording = allanfit.load(shared / "recordings" / "mpu6050.npz")
    assert recording.lost == 0
    (channel,) = [each for each in recording.channels if each.name == "gyro_z"]
    x = np.asarray(channel.samples)
    white = np.array([0.0, np.var(np.diff(x)) / 2, 0.0, 0.0])
    with jax.enable_x64(True):
        state = investigate(x, channel.stretches, "point", white)
    lost = next(each for each in state.findings if each.name == "dropped_samples").detail
    assert lost.frequency * recording.rate_hz == pytest.approx(31.28, abs=0.02)
    time = np.load(shared / "recordings" / "mpu6050.npz")["time_s"] * recording.rate_hz
    half = 40
    at = np.array([first for first, _ in lost.losses])
    at = at[(at > half) & (at < x.size - half)]
    windows = time[2 * half :] - time[: -2 * half]
    longer = windows[at - half].mean() - windows.mean()
    expected = sum(count for _, count in lost.losses) / len(lost.losses)
    assert longer > 0.5
    assert abs(longer - expected) < 3 * windows.std() / np.sqrt(at.size) + 0.2
