"""Sensors with clocks of their own, drawn here sample by sample."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain.values._clock import fresh_values, logged_density

SAMPLES = 60_000


def polled(fresh, repeat, phase=0.37, jitter=0.0, seed=3):
    """What a logger sees of values made every `repeat` samples, and which of them it sees."""
    time = np.arange(SAMPLES) + jitter * np.random.default_rng(seed).standard_normal(SAMPLES)
    index = np.maximum.accumulate(np.floor(np.maximum(time, 0) / repeat + phase).astype(int))
    return fresh[index], index


def part_recovered(found, fresh, index):
    """How much of the sensor's own sequence is found again, the place of its first value aside."""
    size = min(found.values.size, index[-1] - 12)
    return max(
        np.mean(found.values[:size] == fresh[index[0] + begin :][:size]) for begin in range(10)
    )


COARSE = [(r, code) for r in (1.37, 1.7944, 2.01, 2.26, 3.21, 7.3) for code in (0.0, 0.3, 1.0)]


@pytest.mark.parametrize(("repeat", "code"), [(1.02, 0.0), (1.1, 0.0), (1.1, 0.3), *COARSE])
def test_fresh_values_are_found_again(repeat, code):
    """However coarse the codes are, which make neighbours alike, if repeats are more than those."""
    fresh = np.random.default_rng(1).standard_normal(int(SAMPLES / repeat) + 20)
    fresh = np.round(fresh / code) * code if code else fresh
    seen, index = polled(fresh, repeat)
    found = fresh_values(seen, ((0, SAMPLES),))
    assert found is not None
    assert abs(found.repeat.samples - repeat) < 3 * found.repeat.deviation
    assert part_recovered(found, fresh, index) > 0.99
    np.testing.assert_array_equal(seen[found.at], found.values)


@pytest.mark.parametrize("repeat", [2, 3, 5])
@pytest.mark.parametrize("code", [0.0, 1.0])
def test_values_that_are_all_held_equally_long(repeat, code):
    fresh = np.random.default_rng(2).standard_normal(SAMPLES // repeat)
    fresh = np.round(fresh / code) * code if code else fresh
    found = fresh_values(np.repeat(fresh, repeat), ((0, SAMPLES // repeat * repeat),))
    assert found is not None
    assert found.repeat.samples == repeat
    assert max(np.mean(found.values[:5000] == fresh[i : i + 5000]) for i in range(5)) == 1.0


def test_a_clock_that_drifts_and_a_logger_that_jitters():
    """Six samples of drift within the record; a tenth of a sample of jitter."""
    fresh = np.random.default_rng(4).standard_normal(SAMPLES)
    time = np.arange(SAMPLES) + 6 * np.sin(np.arange(SAMPLES) / SAMPLES * 6) + 7
    index = np.floor(time / 1.6).astype(int)
    found = fresh_values(fresh[index], ((0, SAMPLES),))
    assert found is not None
    assert part_recovered(found, fresh, index) > 0.99
    seen, index = polled(fresh, 1.6, jitter=0.1)
    found = fresh_values(seen, ((0, SAMPLES),))
    assert found is not None
    # Some values come and go between two looks: a place is lost for good with each.
    assert found.values.size == pytest.approx(SAMPLES / 1.6, abs=3)


def test_stretches_keep_apart():
    fresh = np.random.default_rng(5).standard_normal(SAMPLES)
    seen, _ = polled(fresh, 1.7944)
    pieces = ((0, 20_000), (23_000, SAMPLES))
    found = fresh_values(seen, pieces)
    assert found is not None
    sizes = [stop - start for start, stop in found.pieces]
    for size, (start, stop), (first, last) in zip(sizes, pieces, found.pieces, strict=True):
        assert size == pytest.approx((stop - start) / 1.7944, abs=3)
        assert start <= found.at[first] < found.at[last - 1] < stop


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6])
def test_values_repeated_at_random_have_no_clock(share):
    """Ten records each; a clock is never made up."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        fresh = np.where(rng.random(SAMPLES) > share, np.arange(SAMPLES), 0)
        seen = rng.standard_normal(SAMPLES)[np.maximum.accumulate(fresh)]
        assert fresh_values(seen, ((0, SAMPLES),)) is None


def test_rounding_alone_has_no_clock():
    rng = np.random.default_rng(6)
    for code in (0.5, 1.0, 2.0):
        seen = np.round(rng.standard_normal(SAMPLES) / code) * code
        assert fresh_values(seen, ((0, SAMPLES),)) is None
    # A slow wave in coarse codes changes at regular times, and repeats nothing.
    wave = 3 * np.sin(2 * np.pi * 0.01 * np.arange(SAMPLES)) + 0.2 * rng.standard_normal(SAMPLES)
    assert fresh_values(np.round(wave), ((0, SAMPLES),)) is None


@pytest.mark.parametrize("repeat", [1.37, 2.6])
def test_density_of_the_log_of_coloured_values(repeat):
    """Mean periodogram of 400 records of an AR(1) process; within 5 deviations and 1 %."""
    rng, length = np.random.default_rng(7), 1024
    white = rng.standard_normal((400, 2 * length))
    coloured = np.asarray(lfilter([1.0], [1.0, -0.7], white))[:, 512:]
    index = np.floor(np.arange(length) / repeat + rng.random((400, 1))).astype(int)
    window = np.hanning(length)
    seen = np.take_along_axis(coloured, index, axis=1) * window
    power = np.mean(np.abs(np.fft.rfft(seen)) ** 2, axis=0) / np.sum(window**2)
    frequency = np.fft.rfftfreq(length)

    def density(f):
        return 1 / np.abs(1 - 0.7 * np.exp(-2j * np.pi * f)) ** 2

    ratio = power / logged_density(frequency, repeat, density)
    assert np.all(np.abs(ratio[3:-3] - 1) < 5 / 20 + 0.01)
    assert np.mean(ratio[3:-3]) == pytest.approx(1.0, abs=0.01)


def test_a_sensor_with_a_clock_of_its_own_is_explained(tmp_path):
    """A line at 7 Hz and white noise at 100 Hz, logged at 180 Hz: no image has a name."""
    rng, rate, repeat = np.random.default_rng(8), 180.0, 1.8 * 0.9974
    fresh = 2e-3 * rate**0.5 * rng.standard_normal(SAMPLES)
    own = rate / repeat
    fresh += 3e-3 * np.sin(2 * np.pi * 7.0 * np.arange(SAMPLES) / own)
    seen, _ = polled(fresh, repeat)
    path = tmp_path / "gyro.npz"
    np.savez(path, gyro_x=seen, rate_hz=rate, units=json.dumps({"gyro_x": "deg/s"}))
    found = explain_recording(allanfit.load(path), posterior=False).to_dict()["channels"][0]
    effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert set(effects) == {"sample_hold", "sinusoid"}
    assert effects["sample_hold"]["repeat"]["value"] == pytest.approx(repeat, abs=1e-4)
    assert effects["sample_hold"]["regular"]["value"] == 1
    (sentence,) = [e["sentence"] for e in found["effects"] if e["name"] == "sample_hold"]
    # A value that fills w samples adds w times itself to a sum: E[w^2]/E[w] in power.
    below, above = np.floor(repeat), repeat - np.floor(repeat)
    squares = (1 - above) * below**2 + above * (below + 1) ** 2
    assert f"N is {np.sqrt(squares / repeat):.3g} times as large" in sentence
    low, high = effects["sinusoid"]["frequency"]["intervals"]["0.95"]
    assert low < 7.0 < high
    low, high = found["coefficients_after"]["N"]["intervals"]["0.95"]
    assert low < 2e-3 < high
    # The better model's curve is that of the log, images and all.
    psd = found["curves"]["psd"]
    ratio = np.array(psd["density"]) / np.array(psd["model_after"])
    frequency = np.array(psd["frequency_hz"])
    assert np.mean(ratio[frequency > 10]) == pytest.approx(1.0, abs=0.03)
    allan = found["curves"]["allan"]
    ratio = np.array(allan["deviation"]) / np.array(allan["model_after"])
    assert np.all(np.abs(ratio[:8] - 1) < 0.03)
