"""A recording beside a simulation of the same, of something else, or of another strength."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain._effect import Effect
from allanfit.explain._mismatch import Located
from allanfit.explain.simulation._compare import compared
from allanfit.explain.simulation._document import simulation_document
from allanfit.explain.simulation._mistaken import as_if
from allanfit.explain.simulation._references import Reference, references, terms_of
from allanfit.explain.simulation._same_effect import pairs
from allanfit.identify import fit_series
from allanfit.physics import SYMBOLS
from allanfit.report._explain_rows import simulation_rows
from allanfit.report._explain_verdict import simulation_sentence

RATE, SAMPLES = 100.0, 4096


def written(path, values, unit, name="gyro_x"):
    units = {"units": json.dumps({name: unit})} if unit else {}
    np.savez(path, rate_hz=RATE, **{name: values}, **units)
    return path


def differences(fit, reference, seconds):
    """Of a recording with nothing beyond five terms."""
    return compared(fit, terms_of(fit), reference, [], [], seconds, lambda *_: ("", 1.0))


def test_a_simulation_of_the_same_sensor_differs_by_chance_only(tmp_path):
    """Of 30 pairs each below .005 with that chance: three or more happen once in 2000."""
    rng = np.random.default_rng(1)

    def noise():
        walk = np.cumsum(rng.standard_normal(SAMPLES))
        return 0.01 * walk + rng.standard_normal(SAMPLES)

    differing = 0
    for _ in range(30):
        recording = allanfit.load(written(tmp_path / "a.npz", noise(), "deg/s"))
        simulation = written(tmp_path / "b.npz", noise(), "deg/s")
        fit = fit_series(recording.channels[0].samples, RATE)
        (reference,) = references(simulation, recording, "point").values()
        differing += bool(differences(fit, reference, SAMPLES / RATE))
    assert differing < 3


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """Two records of noise with a resonance at 20 Hz, and a third without."""
    folder, paths = tmp_path_factory.mktemp("shaken"), []
    for seed, strength in ((5, 1.0), (6, 1.0), (7, 0.0)):
        rng = np.random.default_rng(seed)
        # Two poles on a circle of .95.
        pole = 2 * 0.95 * np.cos(2 * np.pi * 0.2)
        ring = lfilter([0.3], [1, -pole, 0.95**2], rng.standard_normal(4 * SAMPLES))
        x = rng.standard_normal(4 * SAMPLES) + strength * ring
        paths.append(written(folder / f"{seed}.npz", x, "deg/s"))
    return paths


def test_a_simulation_with_the_physics_agrees(shaken):
    one, other, bare = shaken
    same = explain_recording(allanfit.load(one), simulation=other, posterior=False)
    (channel,) = same.to_dict()["channels"]
    assert [effect["name"] for effect in channel["effects"]] == ["resonance"]
    assert channel["mismatch"] == []
    assert channel["simulation"]["recording"] == other.name
    said = simulation_sentence(channel)
    assert said.startswith(f"Compared with gyro_x of {other.name}: the simulation agrees")
    # Both records are of one process: each other's curves and white noise, within their spread.
    ours, theirs = (channel["curves"]["psd"][key] for key in ("density", "simulation"))
    assert np.mean(theirs[-10:]) == pytest.approx(np.mean(ours[-10:]), rel=0.1)
    assert None not in channel["curves"]["allan"]["simulation"]
    drawn = channel["simulation"]["coefficients"]["N"]
    assert drawn["intervals"]["0.95"][0] < 0.1 < drawn["intervals"]["0.95"][1]
    # The same without the other's own physics, as of a simulation that has none.
    (found,) = same.channels
    recording = allanfit.load(one)
    (reference,) = references(bare, recording, "point").values()
    entries = found.compared_with(reference, [])
    assert entries[0]["cause"] == "physics"
    assert "absent" in simulation_sentence({**channel, "mismatch": entries})
    # What the tool says is a simulation too.
    named = one.with_suffix(".json")
    named.write_text(json.dumps(same.to_dict()))
    (reference,) = references(named, recording, "point").values()
    entries = found.compared_with(reference, found.located)
    assert not [each for each in entries if not 0.8 < each["ratio"] < 1.25]


def test_a_simulation_with_physics_of_its_own_is_told(shaken):
    one, _, bare = shaken
    found = explain_recording(allanfit.load(bare), simulation=one, posterior=False)
    (channel,) = found.to_dict()["channels"]
    assert channel["verdict"] == "consistent"
    assert "which the recording has not" in channel["mismatch"][0]["sentence"]


def test_physics_that_is_absent_makes_no_coefficient_wrong(shaken, tmp_path):
    """A resonance makes the N of five terms larger than that of the sensor."""
    recording = allanfit.load(shaken[0])
    believed = tmp_path / "believed.yaml"
    # Noise of unit variance at 100 Hz.
    believed.write_text(f"unit: deg/s\nN: {np.sqrt(1 / RATE)}\n")
    found = explain_recording(recording, simulation=believed, posterior=False)
    (channel,) = found.to_dict()["channels"]
    assert channel["coefficients_before"]["N"]["value"] > 1.05 * np.sqrt(1 / RATE)
    assert {entry["coefficient"] for entry in channel["mismatch"]} == {None}
    assert {entry["absent_from"] for entry in channel["mismatch"]} == {"simulation"}
    assert "a resonance" in channel["mismatch"][0]["sentence"]


@pytest.mark.parametrize(
    ("wrong", "factor", "said"),
    [("N", 0.8, "N is too small"), ("K", 3.0, "K is too large"), ("R", 0.0, "it has no R")],
)
def test_the_coefficient_that_is_off_is_blamed_and_no_other(tmp_path, wrong, factor, said):
    true = {"N": 0.1, "K": 0.1, "R": 0.2}
    rng = np.random.default_rng(8)
    x = true["N"] * np.sqrt(RATE) * rng.standard_normal(4 * SAMPLES)
    x += np.cumsum(true["K"] / np.sqrt(RATE) * rng.standard_normal(4 * SAMPLES))
    x += true["R"] * np.arange(4 * SAMPLES) / RATE
    recording = allanfit.load(written(tmp_path / "a.npz", x, "deg/s"))
    believed = tmp_path / "believed.yaml"
    lines = {**true, wrong: factor * true[wrong]}
    believed.write_text("unit: deg/s\n" + "".join(f"{s}: {v}\n" for s, v in lines.items() if v))
    fit = fit_series(recording.channels[0].samples, RATE)
    (reference,) = references(believed, recording, "point").values()
    entries = differences(fit, reference, 4 * SAMPLES / RATE)
    assert {entry["coefficient"] for entry in entries} == {wrong}
    assert said in entries[0]["sentence"]


def test_a_simulation_without_noise_is_refused(tmp_path):
    values = np.random.default_rng(9).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    believed = tmp_path / "believed.yaml"
    believed.write_text("R: 0.1\n")
    with pytest.raises(ValueError, match="no noise to compare"):
        references(believed, recording, "point")


def test_the_curves_of_a_simulation_are_those_of_its_coefficients(tmp_path):
    """White noise has a deviation of N/sqrt(tau) and a density of 2 N^2; here given per hour."""
    values = np.random.default_rng(3).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    believed = tmp_path / "believed.yaml"
    believed.write_text("unit: deg/h\nN: 720\n")
    found = explain_recording(recording, simulation=believed, posterior=False)
    (channel,) = found.to_dict()["channels"]
    curves = channel["curves"]
    tau = np.array(curves["allan"]["tau_s"])
    np.testing.assert_allclose(curves["allan"]["simulation"], 0.2 / np.sqrt(tau), rtol=1e-6)
    # Where the ramp that is taken out takes nothing away.
    np.testing.assert_allclose(curves["psd"]["simulation"][10:], 2 * 0.2**2, rtol=1e-3)
    told = channel["simulation"]
    assert (told["recording"], told["channel"]) == ("believed.yaml", "data")
    entry = told["coefficients"]["N"]
    assert entry["value"] == pytest.approx(0.2)
    assert entry["unit"] == channel["coefficients_before"]["N"]["unit"]
    assert simulation_rows(channel)["N"].reading.value == "0.2"
    assert simulation_rows(channel)["K"].reading.value == "none"


def test_what_measures_something_else_is_refused(tmp_path):
    values = np.random.default_rng(2).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    for name, unit in (("gyro_x", "m/s^2"), ("accel_x", "m/s^2"), ("gyro_x", "counts")):
        other = written(tmp_path / "b.npz", values, unit, name)
        with pytest.raises(ValueError, match=f"in {re.escape(unit)}, the recording in deg/s"):
            explain_recording(recording, simulation=other)


def test_what_has_no_unit_is_in_the_recordings(tmp_path):
    values = np.random.default_rng(3).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    bare = written(tmp_path / "b.npz", values, "")
    lines = tmp_path / "c.yaml"
    lines.write_text("N: 0.1\n")
    for simulation in (bare, lines):
        (reference,) = references(simulation, recording, "point").values()
        # N of unit variance at 100 Hz is 0.1 deg/s/sqrt(Hz).
        assert reference.coefficients[1] == pytest.approx(0.1 * np.pi / 180, rel=0.1)
        assert reference.unit_assumed
        told = simulation_document(reference, None, recording.channels[0])
        assert told["assumed_unit"] == "deg/s"
        said = simulation_sentence({"simulation": told, "mismatch": []})
        assert f"{simulation.name}, which gives no unit and is taken to be in deg/s: " in said
    lines.write_text("unit: deg/s\nN: 0.1\n")
    (reference,) = references(lines, recording, "point").values()
    assert simulation_document(reference, None, recording.channels[0])["assumed_unit"] is None


def test_each_channel_of_a_simulation_has_its_own_unit(tmp_path):
    rng = np.random.default_rng(4)
    names = ("gyro_x", "accel_x")
    columns = {name: rng.standard_normal(SAMPLES) for name in names}
    units = json.dumps({"gyro_x": "deg/s", "accel_x": "mg"})
    np.savez(tmp_path / "a.npz", rate_hz=RATE, units=units, **columns)
    np.savez(tmp_path / "b.npz", rate_hz=RATE, **columns)
    recording = allanfit.load(tmp_path / "a.npz")
    found = references(tmp_path / "b.npz", recording, "point")
    for name, unit in zip(names, (np.pi / 180, 9.80665e-3), strict=True):
        assert found[name].coefficients[1] == pytest.approx(0.1 * unit, rel=0.1)


def line(amplitude, error, seed):
    """A sinusoid at 7 Hz as explain finds it, its amplitude known with an error."""
    rng = np.random.default_rng(seed)
    found = amplitude + error * rng.standard_normal()
    draws = {
        "amplitude": found + error * rng.standard_normal(400),
        "frequency": 7.0 + 1e-4 * rng.standard_normal(400),
    }
    entry = {"domain": "frequency", "low": 6.999, "high": 7.001, "unit": "Hz", "p_value": 1e-20}
    entry |= {"ratio": 9.0, "sentence": "A line.", "effect": "sinusoid"}
    return Located(entry, Effect("sinusoid", 0.99, {}, draws))


def test_effects_that_both_have_are_compared_by_their_parameters():
    """One in two hundred pairs of alike ones differ by chance: six of 400 or more, once in 60."""
    alike = [
        pairs([line(1.0, 0.05, seed)], [line(1.0, 0.05, 1000 + seed)], 0.005) for seed in range(400)
    ]
    assert sum(pair.off is not None for ((pair),) in alike) < 8
    ((pair),) = pairs([line(1.0, 0.05, 1)], [line(1.5, 0.05, 2)], 0.005)
    assert pair.off is not None
    assert pair.off.parameter == "amplitude"
    assert pair.off.interval[0] < 1.0 < pair.off.interval[1]
    # Another line is another one.
    elsewhere = line(1.0, 0.05, 3)
    elsewhere.entry.update(low=8.0, high=8.1)
    assert not pairs([line(1.0, 0.05, 1)], [elsewhere], 0.005)


def test_a_line_of_another_size_is_told_with_both_sizes():
    """No band of an octave shows it among a million ordinates."""
    rng = np.random.default_rng(12)
    fit = fit_series(rng.standard_normal(SAMPLES), RATE)
    reference = Reference(*terms_of(fit), "deg/s", "gyro", "a.npz", "gyro_x")
    found, theirs = [line(0.2, 0.01, 4)], [line(0.4, 0.01, 5)]
    (entry,) = compared(
        fit, terms_of(fit), reference, found, theirs, SAMPLES / RATE, lambda *_: ("mV", 0.01)
    )
    assert entry["cause"] == "coefficient"
    assert entry["coefficient"] == "sinusoid"
    assert "The simulation has a sinusoid whose amplitude is 3" in entry["sentence"]
    assert " mV, the recording's " in entry["sentence"]
    # What the simulation alone has is told if it is certain, what the recording has always.
    weak = line(0.4, 0.01, 5)
    weak.entry["p_value"] = 1e-4
    ends = SAMPLES / RATE, lambda *_: ("mV", 0.01)
    assert not compared(fit, terms_of(fit), reference, [], [weak], *ends)
    (entry,) = compared(fit, terms_of(fit), reference, [weak], [], *ends)
    assert entry["absent_from"] == "simulation"
    named = Reference(*terms_of(fit), "deg/s", "gyro", "a.npz", "gyro_x", undrawn=("sinusoid",))
    assert not compared(fit, terms_of(fit), named, [weak], [], *ends)


@pytest.mark.parametrize(
    ("factor", "kind", "word"),
    [
        (180 / np.pi, "gyro", "in deg and not in rad"),
        (1 / 60, "gyro", "in 1/sqrt(s) and not in 1/sqrt(h)"),
        (9.9, "accelerometer", "in m/s^2 and not in g"),
        (9.7, "gyro", None),
        (50.0, "gyro", None),
    ],
)
def test_a_coefficient_in_another_unit_is_said_to_be(factor, kind, word):
    fit = fit_series(np.random.default_rng(31).standard_normal(SAMPLES), RATE)
    values, _ = terms_of(fit)
    wrong = np.array([0.0, factor * values[1], 0.0, 0.0, 0.0])
    reference = Reference(wrong, np.zeros(5), "deg/s", kind, "a.yaml", "gyro_x")
    entry = differences(fit, reference, SAMPLES / RATE)[0]
    assert entry["coefficient"] == "N"
    assert ("as if it were" in entry["sentence"]) == (word is not None)
    assert word is None or word in entry["sentence"]


@pytest.mark.parametrize(
    ("symbol", "ours", "theirs", "words"),
    [
        # A simulator that draws N, or the recording's scatter, as the deviation of each sample.
        ("N", 100.0, 100.0, (None, "samples scattered by N and")),
        ("N", 100.0, 400.0, ("as the recording's do, at another rate", "scattered by N and")),
        # And one that adds K, or what one of the recording's samples adds, with each.
        ("K", 100.0, 100.0, (None, "each sample added K and")),
        ("K", 50.0, 200.0, ("what one of the recording's does", "each sample added K and")),
    ],
)
def test_what_a_rate_makes_of_a_coefficient_is_told(symbol, ours, theirs, words):
    """By drawing samples so, and what N and K they have by their definitions."""
    rng, samples = np.random.default_rng(5), 400_000
    deviation = ours**0.5 if symbol == "N" else ours**-0.5
    for drawn, word in zip((deviation, 1.0), words, strict=True):
        scatter = np.std(drawn * rng.standard_normal(samples))
        factor = scatter / theirs**0.5 if symbol == "N" else scatter * theirs**0.5
        said = as_if(symbol, "gyro", float(factor), ours, theirs)
        assert (said == "") == (word is None)
        assert word is None or word in said


def test_a_factor_that_tells_nothing_is_left_alone():
    assert as_if("N", "gyro", 1.004, 100.0, 101.0) == ""
    assert as_if("N", "gyro", 2.0, 100.0, 100.0) == ""
    assert as_if("B", "gyro", 10.0, 100.0, 100.0) == ""
    assert "how samples scatter" in as_if("N", "gyro", 10.05, 100.0, 100.0)


def test_a_term_that_may_be_none_is_no_fault_of_a_simulation_without_it():
    """Half of the recording's N, which has as much K as its lowest band may hide."""
    rng = np.random.default_rng(30)
    fit = fit_series(rng.standard_normal(SAMPLES), RATE)
    (q, n, b, _, r), errors = terms_of(fit)
    coefficients = np.array([0.0, n / 2, 0.0, 0.0, 0.0])
    reference = Reference(coefficients, np.zeros(5), "deg/s", "gyro", "a.yaml", "gyro_x")
    k = n * 2 * np.pi * RATE / SAMPLES * 4
    own = np.array([q, n, b, k, r]), np.array([errors[0], errors[1], errors[2], k / 3, errors[4]])
    ends = [], [], SAMPLES / RATE, lambda *_: ("", 1.0)
    blamed = [
        {
            entry["coefficient"]
            for entry in compared(fit, own, reference, *ends, resolved=np.array(resolved))
        }
        for resolved in ([False, True, False, True, False], [False, True, False, False, False])
    ]
    assert blamed == [{"N", "K"}, {"N"}]


@pytest.mark.parametrize("regular", [True, False])
def test_held_values_have_the_n_of_a_log_that_is_not_held(tmp_path, regular):
    """The simulation does not repeat, and its N is right: nothing of N is off."""
    rng = np.random.default_rng(6)
    count = 12 * SAMPLES
    # A clock of 0.55 of the log's, or fresh values by chance.
    fresh = np.diff(np.floor(0.55 * np.arange(count + 1))) > 0
    if not regular:
        fresh = rng.random(count) < 0.55
    values = rng.standard_normal(count)[np.maximum.accumulate(np.where(fresh, np.arange(count), 0))]
    repeat = 1 / 0.55
    believed = tmp_path / "believed.yaml"
    true = np.sqrt((repeat if regular else 2 * repeat - 1) / RATE)
    believed.write_text(f"unit: deg/s\nN: {true}\n")
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    found = explain_recording(recording, simulation=believed, posterior=False)
    (channel,) = found.to_dict()["channels"]
    assert [effect["name"] for effect in channel["effects"]] == ["sample_hold"]
    assert {entry["coefficient"] for entry in channel["mismatch"]} == {None}
    assert "values that are repeated" in channel["mismatch"][0]["sentence"]
    assert channel["improvement"]["held_out_log_score"]["difference"] > 1000


def test_a_step_of_a_simulation_is_told_with_its_time(tmp_path):
    """No band of frequencies says when."""
    rng = np.random.default_rng(8)
    one, other = (rng.standard_normal(4 * SAMPLES) for _ in range(2))
    other += 0.4 * (np.arange(other.size) >= 80 * RATE)
    paths = [written(tmp_path / f"{i}.npz", x, "deg/s") for i, x in enumerate((one, other))]
    found = explain_recording(allanfit.load(paths[0]), simulation=paths[1], posterior=False)
    (channel,) = found.to_dict()["channels"]
    assert channel["verdict"] == "consistent"
    said = " ".join(entry["sentence"] for entry in channel["mismatch"])
    (when,) = re.findall(r"a step of the bias, at ([0-9.]+) s", said)
    # Six times what (sigma/step)^2 says in samples.
    assert float(when) == pytest.approx(80, abs=0.4)


def test_a_walk_that_no_band_shows_is_told_by_all_of_them():
    """K of a half has some ten ordinates that tell, of which bands have a few each."""
    rng, seconds, told = np.random.default_rng(3), 4 * SAMPLES / RATE, []

    def fitted(size):
        walk = size * np.cumsum(rng.standard_normal(4 * SAMPLES))
        return fit_series(walk + rng.standard_normal(4 * SAMPLES), RATE)

    for _ in range(12):
        fit, other = fitted(0.02), fitted(0.01)
        reference = Reference(*terms_of(other), "deg/s", "gyro", "a.npz", "gyro_x")
        same = replace(reference, **spectrum_of(other))
        told += differences(fit, same, seconds)
    together = [each for each in told if "all frequencies together show" in each["sentence"]]
    assert len(together) >= 3
    for entry in together:
        assert (entry["cause"], entry["coefficient"]) == ("coefficient", "K")
        assert "its K is too small" in entry["sentence"]
        assert entry["high"] < 3.0
        assert entry["ratio"] > 1.5


def test_a_coefficient_that_the_spectrum_denies_is_not_off():
    """Other physics stands for it: the powers are alike."""
    fit = fit_series(np.random.default_rng(4).standard_normal(SAMPLES), RATE)
    values, deviations = terms_of(fit)
    off = values.copy()
    off[SYMBOLS.index("N")] *= 1.3
    reference = Reference(off, deviations, "deg/s", "gyro", "a.npz", "gyro_x", **spectrum_of(fit))
    assert not differences(fit, reference, SAMPLES / RATE)


def spectrum_of(fit):
    density = np.asarray(fit.estimate.statistics.density, float)
    return {
        "frequency": np.asarray(fit.design.frequency) * RATE,
        "density": density / RATE,
        "ordinates": np.asarray(fit.design.ordinates, float),
    }
