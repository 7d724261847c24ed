"""From a recording to its explanation, on records drawn here by recipes of their own."""

import json
import re
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import butter, fftconvolve, firwin, lfilter, welch

import allanfit
from allanfit.cli import main
from allanfit.compilation import platform
from allanfit.explain import explain_recording
from allanfit.explain._effect import Effect
from allanfit.explain._explain import _doubted
from allanfit.recording import RecordingError

RATE, SAMPLES = 50.0, 30_000


def written(folder, values, name="gyro.npz", **more):
    path = folder / name
    np.savez(path, gyro_x=values, rate_hz=RATE, units='{"gyro_x": "deg/s"}', **more)
    return path


def noise(seed: int) -> np.ndarray:
    """White noise of N = 0.005 and a random walk of K = 2e-4, in deg/s."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.standard_normal(SAMPLES)) * 2e-4 * RATE**-0.5
    return 0.005 * RATE**0.5 * rng.standard_normal(SAMPLES) + walk


def explained(folder, values, **options):
    recording = allanfit.load(written(folder, values))
    # `wandering` is sampled with emcee, as is usual.
    found = explain_recording(recording, posterior=False, **options)
    return found.to_dict()["channels"][0]


def beside_temperature(values, celsius):
    recording = allanfit.recording_of(
        {"gyro_x": values, "temperature": celsius},
        rate_hz=RATE,
        units={"gyro_x": "deg/s", "temperature": "degC"},
    )
    return explain_recording(recording, posterior=False).to_dict()["channels"][0]


@pytest.fixture(scope="module")
def wandering(tmp_path_factory):
    """A Gauss-Markov process of 0.014 deg/s and 4 s beside the noise, explained on the way out."""
    folder = tmp_path_factory.mktemp("explain")
    rng = np.random.default_rng(7)
    decay = np.exp(-1 / (4 * RATE))
    state, drive = np.zeros(SAMPLES), rng.standard_normal(SAMPLES)
    for k in range(1, SAMPLES):
        state[k] = decay * state[k - 1] + np.sqrt(1 - decay**2) * 0.014 * drive[k]
    path = written(folder, noise(8) + state)
    page, document = folder / "page.html", folder / "explain.json"
    assert main(["explain", str(path), "--json", str(document), "--report", str(page)]) == 0
    return document, page


@pytest.mark.parametrize("seed", [11, 12])
def test_nothing_is_claimed_where_nothing_is_left_out(tmp_path, seed):
    """Nominal false-alarm rate 1 % a record; seeds fixed."""
    channel = explained(tmp_path, noise(seed))
    assert channel["verdict"] == "consistent"
    assert channel["effects"] == channel["mismatch"] == []
    assert channel["improvement"] is None
    assert channel["coefficients_after"] == channel["coefficients_before"]


@pytest.mark.parametrize("length", [40, 65])
def test_short_stretches_are_explained_or_refused_in_one_sentence(tmp_path, length):
    place = np.arange(10 * (length + 40))
    values = np.where(place % (length + 40) < length, noise(11)[: place.size], np.nan)
    recording = allanfit.load(written(tmp_path, values))
    if length < 64:
        with pytest.raises(RecordingError, match="explain needs one of 64"):
            explain_recording(recording, posterior=False)
    else:
        channel = explain_recording(recording, posterior=False).to_dict()["channels"][0]
        assert channel["verdict"] == "consistent"


def test_a_low_p_value_of_the_fit_does_not_contradict_a_consistent_verdict(tmp_path):
    """One test in a hundred is as low by chance; the verdict is of all together."""
    found = explain_recording(allanfit.load(written(tmp_path, noise(11))), posterior=False)
    (channel,) = found.channels
    assert channel.findings == ()
    estimate = eqx.tree_at(
        lambda each: each.goodness_of_fit, channel.before.estimate, jnp.asarray(0.0042)
    )
    low = replace(channel, before=replace(channel.before, estimate=estimate))
    assert low.verdict == "consistent"
    (told,) = low.findings
    assert told.startswith("The five-term model alone fits with p = 0.0042, which is low for one")


def test_a_model_that_does_not_fit_explains_nothing(tmp_path):
    """What is named in it is less sure, and the reader is told."""
    found = explain_recording(allanfit.load(written(tmp_path, noise(11))), posterior=False)
    effect = Effect("gauss_markov", 0.98, {"power_law": 0.02}, {})
    fits = replace(found.channels[0], effects=(effect,), p_value_after=0.01)
    assert fits.verdict == "explained"
    assert not any("doubtful" in each for each in fits.advice)
    misfit = replace(fits, p_value_after=1e-6)
    assert misfit.verdict == "unexplained"
    assert any("doubtful" in each for each in misfit.advice)
    rounding = Effect("output_rounding", 0.99, {}, {})
    (less, as_sure) = _doubted((effect, rounding))
    assert (less.probability, less.alternatives) == (0.49, {"power_law": 0.01})
    assert as_sure == rounding


def test_a_rail_among_coarse_codes_hides_no_noise(tmp_path):
    """White noise of N = 0.005 in codes of 0.4 of its deviation, of which 5 % stand at the last."""
    sigma = 0.005 * RATE**0.5
    width = 0.4 * sigma
    values = np.round(np.minimum(noise(11), 1.6 * sigma) / width) * width
    channel = explained(tmp_path, values)
    names = [effect["name"] for effect in channel["effects"]]
    assert names == ["output_rounding", "saturation"]
    # Four standard errors.
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.02)


def test_a_filter_in_the_processor_is_named_and_simulated(tmp_path):
    """Butterworth of second order at 15 Hz: its zero at 25 Hz makes up nothing else."""
    rng = np.random.default_rng(31)
    passed = np.asarray(lfilter(*butter(2, 15.0, fs=RATE), noise(32)))
    recording = allanfit.load(written(tmp_path, passed + 1e-9 * rng.standard_normal(SAMPLES)))
    found = explain_recording(recording, posterior=False)
    channel = found.to_dict()["channels"][0]
    (effect,), (place,) = channel["effects"], channel["mismatch"]
    assert effect["name"] == "low_pass"
    # White noise that is too little below the corner makes up for what is too much above.
    number = r"([0-9.e-]+)"
    told = re.search(rf"{number} times \(at {number} Hz\) and {number} times", place["sentence"])
    assert told is not None
    below, where, above = map(float, told.groups())
    assert below > 1 > above
    assert where < 15.0
    parameters = effect["parameters"]
    assert parameters["digital"]["value"] == 1
    for name, truth in (("cutoff_frequency", 15.0), ("order", 2.0)):
        low, high = parameters[name]["intervals"]["0.95"]
        assert low * 0.995 < truth < high * 1.005
    document = tmp_path / "explain.json"
    document.write_text(json.dumps(found.to_dict()))
    drawn = tmp_path / "drawn.npz"
    length = ["--duration", f"{SAMPLES / RATE}", "--rate", f"{RATE}", "--seed", "1"]
    assert main(["simulate", str(document), *length, "--output", str(drawn)]) == 0
    again = allanfit.load(drawn).channels[0].samples
    # Means of octaves of the spectrum, of which the last falls by ten thousand.
    edges = np.array([0.5, 2.0, 8.0, 15.0, 20.0, 23.0, 24.5])
    powers = []
    for values in (recording.channels[0].samples, again):
        frequency, density = welch(values, RATE, nperseg=1024)
        index = np.digitize(frequency, edges)
        powers.append([density[index == k].mean() for k in range(1, edges.size)])
    np.testing.assert_allclose(np.divide(*powers), 1.0, atol=0.12)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_corner_beyond_nyquist_may_be_anywhere_there(tmp_path, seed):
    """Of a digital filter in steps of a quarter sample, whose spectrum folds but once.

    What an analogue filter of that corner folds is not it: taken at its word the second one's
    interval ended at the sampling rate.
    """
    fine = np.random.default_rng(seed).standard_normal(4 * SAMPLES)
    passed = lfilter(*butter(2, 1.3 * RATE, fs=4 * RATE), fine)[3::4]
    (low_pass,) = explained(tmp_path, passed)["effects"]
    assert low_pass["name"] == "low_pass"
    low, high = low_pass["parameters"]["cutoff_frequency"]["intervals"]["0.95"]
    assert low < 1.3 * RATE < high
    assert "only what folds is seen" in low_pass["sentence"]


def test_a_gauss_markov_process_is_named_modelled_and_proven(wandering):
    channel = json.loads(wandering[0].read_text())["channels"][0]
    assert channel["verdict"] == "explained"
    (effect,) = channel["effects"]
    assert effect["name"] == "gauss_markov"
    low, high = effect["parameters"]["sigma"]["intervals"]["0.95"]
    assert low < 0.014 < high
    low, high = effect["parameters"]["correlation_time"]["intervals"]["0.95"]
    assert low < 4.0 < high
    score = channel["improvement"]["held_out_log_score"]
    assert score["difference"] > 2 * score["standard_error"] > 0
    assert channel["improvement"]["p_value_before"] < 0.01
    assert channel["improvement"]["p_value_after"] > 0.01
    # The walk, which took the process for its own, is itself again.
    low, high = channel["coefficients_after"]["K"]["intervals"]["0.95"]
    assert low < 2e-4 < high
    assert channel["coefficients_before"]["K"]["intervals"]["0.95"][0] > 2e-4
    (mismatch,) = channel["mismatch"]
    assert mismatch["low"] < 1 / (2 * np.pi * 4.0) < mismatch["high"]


def test_the_page_tells_it(wandering):
    page = wandering[1].read_text()
    assert "Gauss-Markov" in page
    assert "held out" in page


def test_the_improved_model_simulates_what_it_found(wandering, tmp_path):
    drawn = tmp_path / "drawn.npz"
    arguments = ["simulate", str(wandering[0]), "--duration", "600", "--rate", str(RATE)]
    assert main([*arguments, "--seed", "1", "--output", str(drawn)]) == 0
    values = np.load(drawn)["gyro_x"]
    # Means over 2 s: white noise leaves 0.0035, the process and the walk are what is more.
    means = values[: values.size // 100 * 100].reshape(-1, 100).mean(axis=1)
    assert np.std(np.diff(means)) > 1.5 * 0.005


def test_steps_are_placed_and_not_taken_for_a_walk(tmp_path):
    jump = np.where(np.arange(SAMPLES) >= 10_000, 0.03, 0.0)
    channel = explained(tmp_path, noise(9) + jump)
    (effect,) = channel["effects"]
    assert effect["name"] == "step"
    (time,) = effect["parameters"]["times"]["value"]
    assert abs(time - 200.0) < 0.02 * SAMPLES / RATE
    low, high = effect["parameters"]["amplitude"]["intervals"]["0.95"]
    assert low < 0.03 < high


def test_a_simulation_with_a_wrong_coefficient_is_told_from_one_without_physics(tmp_path):
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("unit: deg/s\nN: 0.004\nK: 2.0e-4\n")
    channel = explained(tmp_path, noise(13), simulation=wrong)
    first = channel["mismatch"][0]
    assert (first["cause"], first["coefficient"]) == ("coefficient", "N")
    assert "too small" in first["sentence"]


def test_a_simulation_of_other_channels_is_refused(tmp_path):
    one = written(tmp_path, noise(14))
    two = tmp_path / "two.npz"
    np.savez(two, a=noise(15), b=noise(16), rate_hz=RATE)
    with pytest.raises(ValueError, match=r"The simulation has channels a, b"):
        explain_recording(allanfit.load(one), simulation=two)


def test_two_resonances_differ_in_two_places(tmp_path):
    """White noise through two resonators, at 3 and 12 Hz."""
    rng = np.random.default_rng(41)
    values = noise(42)
    for frequency, quality in ((3.0, 8.0), (12.0, 12.0)):
        angle, loss = 2 * np.pi * frequency / RATE, np.pi * frequency / quality / RATE
        poles = [1.0, -2 * np.exp(-loss) * np.cos(angle), np.exp(-2 * loss)]
        rung = np.asarray(lfilter([1.0], poles, rng.standard_normal(SAMPLES)))
        values = values + 0.012 * rung / rung.std()
    found = explained(tmp_path, values)
    assert [effect["name"] for effect in found["effects"]] == ["resonance", "resonance"]
    bands = sorted((entry["low"], entry["high"]) for entry in found["mismatch"])
    for (low, high), frequency in zip(bands, (3.0, 12.0), strict=True):
        assert low < frequency < high


def test_a_line_that_swings_as_a_sine_is_one_that_wanders(tmp_path):
    """About 12 Hz, .3 Hz to either side in 100 s: most of the time it is where it turns."""
    time = np.arange(SAMPLES) / RATE
    swung = 0.3 * 100 / (2 * np.pi) * np.sin(2 * np.pi * time / 100)
    line = 0.02 * np.cos(2 * np.pi * (12 * time + swung))
    found = explained(tmp_path, noise(9) + line)
    assert found["verdict"] == "explained"
    assert [effect["name"] for effect in found["effects"]] == ["drifting_line"]
    assert found["effects"][0]["probability"] > 0.9
    assert any("does not wander as the model has it" in sentence for sentence in found["advice"])


def test_it_is_as_exact_where_jax_is_left_as_it_is():
    """A windowed sinc passes a billionth of the power above: single precision was lost there."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal(20_100) + 1e-4 * np.cumsum(rng.standard_normal(20_100))
    values = lfilter(firwin(31, 0.08), [1.0], values)[100:]
    recording = allanfit.recording_of(values, rate_hz=RATE, unit="deg/s")
    found = []
    for wide in (True, False):
        with jax.enable_x64(wide):
            channels = explain_recording(recording, posterior=False).to_dict()["channels"]
        found.append(channels[0])
    told = [[effect["sentence"] for effect in channel["effects"]] for channel in found]
    assert told[0] == told[1]
    assert "low-pass" in told[0][0]
    for symbol in "NBK":
        after = [channel["coefficients_after"][symbol]["value"] for channel in found]
        assert after[0] == pytest.approx(after[1], rel=1e-6)


def test_it_runs_on_the_cpu_beside_an_accelerator(monkeypatch):
    """Thousands of small programs, which an accelerator takes longer to begin than they last."""
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    on = []
    allanfit.explain(
        np.random.default_rng(5).standard_normal(1000),
        rate_hz=100.0,
        unit="deg/s",
        posterior=False,
        announce=lambda channel: on.append(platform()),
    )
    assert on == ["cpu"]
    assert platform() == "gpu"


def test_the_square_of_temperature_is_told():
    """A room that swings by 2 K: bias of 0.01 K^-2 of its square, in deg/s, and none of itself."""
    time = np.arange(SAMPLES) / RATE
    kelvin = 2 * np.sin(2 * np.pi * 3 * time / time[-1]) + np.sin(2 * np.pi * 7 * time / time[-1])
    values = noise(17) + 0.01 * (kelvin - kelvin.mean()) ** 2
    found = beside_temperature(values, 25 + kelvin)
    (effect,) = found["effects"]
    assert effect["name"] == "temperature"
    assert effect["parameters"]["quadratic"]["unit"] == "deg/s/K^2"
    low, high = effect["parameters"]["quadratic"]["intervals"]["0.95"]
    assert low < 0.01 < high < 0.015
    low, high = effect["parameters"]["sensitivity"]["intervals"]["0.95"]
    assert low < 0 < high
    assert "not temperature but the square" in effect["sentence"]


def test_k_beside_a_swing_of_temperature_is_a_limit():
    """A room that swings every quarter of an hour wanders too, which was K and nothing else."""
    rng, rate = np.random.default_rng(24), 20.0
    time = np.arange(72_000) / rate
    room = np.sin(2 * np.pi * time / 900) + 0.003 * np.cumsum(rng.standard_normal(time.size))
    values = rng.standard_normal(time.size) + 0.6 * room
    recording = allanfit.recording_of(values, rate_hz=rate, unit="deg/s")
    (found,) = explain_recording(recording, posterior=False).to_dict()["channels"]
    (effect,) = found["effects"]
    assert effect["name"] == "temperature"
    assert effect["parameters"]["time_scale"]["value"] == pytest.approx(900, rel=0.05)
    walk = found["coefficients_after"]["K"]
    assert not walk["resolved"]
    low, high = walk["intervals"]["0.95"]
    # Of a step in a sample, over the root of the sampling interval.
    assert low == 0 < 0.6 * 0.003 * rate**0.5 < high


def test_a_resonance_of_averaged_samples_has_the_size_that_it_had_before(tmp_path):
    """Means over an interval leave sin(x)/x of it, x = pi f dt: .79 at 0.38 of the rate."""
    rng, parts = np.random.default_rng(12), 16
    place, quality = 0.38 * RATE, 12.0
    turn = 2 * np.pi * place / (RATE * parts)
    decay = np.exp(-turn / (2 * quality))
    driven = lfilter([1.0], [1, -2 * decay * np.cos(turn), decay**2], rng.standard_normal(2**19))
    fast = 0.02 * driven / driven.std()
    values = fast[: SAMPLES * parts].reshape(SAMPLES, parts).mean(axis=1)
    values = values + 0.005 * RATE**0.5 * rng.standard_normal(SAMPLES)
    (effect,) = explained(tmp_path, values, sampling="averaged")["effects"]
    assert effect["name"] == "resonance"
    assert effect["parameters"]["sigma"]["value"] == pytest.approx(0.02, rel=0.06)


def test_a_course_and_noise_that_hide_behind_one_walk_are_found_together(tmp_path):
    """Each alone gains 7 to 11 in twice the log-likelihood, and chance makes that of it."""
    rate, samples = 10.0, 25_000
    time, rng = np.arange(samples) / rate, np.random.default_rng(8)
    keeps = np.exp(-1 / rate / 12.0)
    wander = 0.004 * np.sqrt(1 - keeps**2) * rng.standard_normal(samples)
    x = 0.006 * rate**0.5 * rng.standard_normal(samples) + lfilter([1], [1, -keeps], wander)
    x += 0.05 * np.exp(-time / 180)
    order = np.arange(1, samples)
    half = np.cumprod(np.append(1.0, (order - 0.5) / order))
    x += 0.001 * fftconvolve(rng.standard_normal(samples), half)[:samples]
    since = np.maximum(time - 1700, 0)
    x += 0.2 * np.exp(-since / 2.5) * np.sin(2 * np.pi * 1.4 * since)
    np.savez(tmp_path / "a.npz", gyro_x=x, rate_hz=rate, units='{"gyro_x": "deg/s"}')
    found = explain_recording(allanfit.load(tmp_path / "a.npz"), posterior=False)
    (channel,) = found.to_dict()["channels"]
    effects = {effect["name"]: effect["parameters"] for effect in channel["effects"]}
    assert effects.keys() == {"disturbance", "warm_up", "gauss_markov"}
    low, high = effects["warm_up"]["amplitude"]["intervals"]["0.95"]
    assert low < 0.05 < high


def test_a_thermometer_that_is_behind_says_the_sensitivity_of_the_sensor():
    """0.02 deg/s/K at once, of a room that swings in 40 and 100 s, logged 5 s late."""
    time, rng = np.arange(SAMPLES) / RATE, np.random.default_rng(18)
    room = np.sin(2 * np.pi * time / 97) + 0.6 * np.sin(2 * np.pi * time / 41)
    share = 1 - np.exp(-1 / RATE / 5.0)
    shown = lfilter([share], [1, share - 1], room) + 1e-3 * rng.standard_normal(SAMPLES)
    found = beside_temperature(noise(18) + 0.02 * room, 25 + shown)
    (effect,) = found["effects"]
    assert effect["name"] == "temperature"
    # What it shows, less how fast it rises, is a seventh less.
    assert effect["parameters"]["sensitivity"]["value"] == pytest.approx(0.02, rel=0.02)


def test_of_a_warm_up_and_temperature_the_likelier_is_named():
    """A board that warms up: both fit, and chance finds a warm-up less often."""
    named = set()
    for seed in range(3):
        rng = np.random.default_rng((5, seed))
        celsius = 30 + 6 * (1 - np.exp(-np.arange(SAMPLES) / (SAMPLES / 3)))
        shown = celsius + 0.03 * rng.standard_normal(SAMPLES)
        found = beside_temperature(noise(60 + seed) + 0.08 * (celsius - 30), shown)
        for effect in found["effects"]:
            named.add(effect["name"])
            others = [each["probability"] for each in effect["alternatives"]]
            assert effect["probability"] >= max(others, default=0.0)
    assert named & {"warm_up", "temperature"}


def test_a_line_is_as_strong_as_by_its_times_where_samples_are_lost(tmp_path):
    """Closed up, its phase turns by two thirds of a turn at each loss, and nothing stays there.

    A line of amplitude A over T beside white noise N has 1 + A^2 T/(4 N^2) times its power, in
    the two ordinates or three that its band holds.
    """
    rng = np.random.default_rng(21)
    time = np.arange(SAMPLES) / RATE
    kept = rng.random(SAMPLES) > 0.03
    values = noise(21) + 0.006 * np.sin(2 * np.pi * 17.3 * time)
    path = written(tmp_path, values[kept], time_s=time[kept])
    document = explain_recording(allanfit.load(path), posterior=False).to_dict()["channels"][0]
    (place,) = (each for each in document["mismatch"] if each["effect"] == "sinusoid")
    over = 0.006**2 * SAMPLES / RATE / (4 * 0.005**2)
    assert over / 2 < place["ratio"] < 2 * over
    assert f"{place['ratio']:.3g} times" in place["sentence"]


def test_an_array_with_its_rate_is_a_recording_of_it():
    samples = np.random.default_rng(4).standard_normal(2000)
    given = {"rate_hz": 100.0, "unit": "deg/s"}
    recording = allanfit.recording_of(samples, **given)
    found = allanfit.explain(samples, **given, posterior=False).to_dict()
    assert found == allanfit.explain(recording, posterior=False).to_dict()
    with pytest.raises(TypeError, match=r"allanfit\.recording_of; or arrays with their rate_hz"):
        allanfit.explain(samples)
    for each in ({"rate_hz": 100.0}, {"unit": "deg/s"}):
        with pytest.raises(ValueError, match="knows its rate and unit"):
            allanfit.explain(recording, **each)
