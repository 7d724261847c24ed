"""What explain has found, in a filter and in a simulation."""

import json
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import yaml

import allanfit
from allanfit.cli import main
from allanfit.coefficients import CoefficientsError, read_coefficients
from allanfit.export import FORMATS, discretise, export, read_fit, realise, stack
from allanfit.physics import (
    EFFECTS,
    GaussMarkov,
    LowPass,
    Resonance,
    Saturation,
    draw_recording,
    effect_from,
    parameter_unit,
    parameter_values,
    scaled,
    standard_model,
)


def test_a_filter_has_exact_states_for_stationary_effects(write_explained, make_channel):
    """Driven matrices have the autocovariance of the effects, at every lag."""
    path = write_explained(make_channel("gx", unresolved="QBKR"))
    exported = export(path, "kalman")
    (entry,) = json.loads(exported.text)["channels"]
    names = [state["name"] for state in entry["states"]]
    assert names == ["bias", "gauss_markov_1", "resonance_2", "resonance_2_rate"]
    (channel,) = read_fit(path).channels
    discrete = discretise(stack([realise(channel).parts]), channel.dt)
    states = slice(1, None)
    phi, drive, row = discrete.Phi[states, states], discrete.Qd[states, states], discrete.H[0, 1:]
    variance = np.diag([state["initial_variance"] for state in entry["states"][1:]])
    np.testing.assert_allclose(phi @ variance @ phi.T + drive, variance, rtol=1e-9, atol=1e-16)
    assert phi[0, 0] == pytest.approx(math.exp(-channel.dt / 30))
    for lag in (0, 1, 5, 40):
        time = lag * channel.dt
        omega, zeta = 2 * np.pi * 7, 1 / 8
        turning = omega * np.sqrt(1 - zeta**2)
        wave = np.cos(turning * time) + zeta * omega / turning * np.sin(turning * time)
        expected = 0.004**2 * np.exp(-time / 30)
        expected += 0.003**2 * np.exp(-zeta * omega * time) * wave
        found = row @ np.linalg.matrix_power(phi, lag) @ variance @ row
        assert found == pytest.approx(expected, rel=1e-10)
    assert [each["name"] for each in entry["effects"]] == [each.name for each in channel.effects]
    assert entry["effects"][0]["parameters"]["sigma"] == {"value": 0.004, "unit": "deg/s"}
    assert "not in these matrices" in entry["effects"][2]["how"]
    assert any(
        "for what explain found in gx: a sinusoid (amplitude 0.02" in each
        for each in exported.warnings
    )
    assert not any("a resonance" in each for each in exported.warnings)


def test_telegraph_noise_has_the_state_of_its_autocovariance(write_explained, make_channel):
    effects = {"random_telegraph": {"amplitude": (0.02, "deg/s"), "dwell_time": (8.0, "s")}}
    (channel,) = read_fit(write_explained(make_channel("gx"), effects=effects)).channels
    part = realise(channel).parts[-1]
    assert part.states[0].initial_variance == pytest.approx(1e-4)
    assert part.F[0, 0] == pytest.approx(-0.25)


def test_uneven_telegraph_noise_has_the_sum_of_its_two_rates(write_explained, make_channel):
    """Held 12.8 s at one level and 3.2 s at the other."""
    values = {"amplitude": (0.02, "deg/s"), "dwell_time": (8.0, "s"), "upper_share": (0.8, "")}
    written = write_explained(make_channel("gx"), effects={"random_telegraph": values})
    part = realise(read_fit(written).channels[0]).parts[-1]
    assert part.states[0].initial_variance == pytest.approx(0.02**2 * 0.8 * 0.2)
    assert part.F[0, 0] == pytest.approx(-(1 / 12.8 + 1 / 3.2))


@pytest.mark.parametrize("name", [name for name in FORMATS if name not in ("kalman", "yaml")])
def test_a_format_says_which_effects_it_cannot_hold(write_explained, make_channel, name):
    exported = export(write_explained(make_channel("gx")), name)
    plain = export(write_explained(make_channel("gx"), effects={}), name)
    for word in ("exponentially correlated", "a resonance", "a sinusoid", "strength changes"):
        assert sum(word in warning for warning in exported.warnings) == 1
        assert not any(word in warning for warning in plain.warnings)
    assert "explain found in gx: a sinusoid" in " ".join(
        line.lstrip("#% ") for line in exported.text.splitlines()
    )


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize(
    "flag",
    [
        "digital",
        "averaged",
        "recursive",
        "running_mean",
        "oversampled",
        "windowed",
        "last",
        "regular",
        "high_pass",
        "flat",
        None,
    ],
)
def test_every_format_takes_an_effect_that_says_what_kind_it_is(
    write_explained, make_channel, tmp_path, flag, name
):
    """What is 1 or not at all, as what a sensor's processor does."""
    effects = {"low_pass": {"cutoff_frequency": (20.0, "Hz"), "order": (2.0, "")}}
    if flag == "regular":
        effects = {"sample_hold": {"repeat": (2.0, "")}}
    if flag in ("high_pass", "flat"):
        shape = {"height": (0.2, ""), "frequency": (0.1, "Hz"), "width": (0.5, "")}
        effects = {"bump": shape}
    for parameters in effects.values():
        parameters |= {"droop": (0.4, "")} if flag is None else {flag: (1.0, "")}
    path, target = write_explained(make_channel("gx"), effects=effects), tmp_path / "out.yaml"
    exported = export(path, name)
    said = any("explain found in gx" in each for each in exported.warnings)
    assert said == (name != "yaml")
    exported.write(target)
    if name == "yaml":
        (found,) = read_coefficients(target)[0].effects
        assert vars(found)[flag or "droop"] == (0.4 if flag is None else True)


def test_an_export_takes_the_coefficients_beside_the_effects(write_explained, make_channel):
    for effects, bias in (({}, 0.014), ({"output_rounding": {"lsb": (0.1, "deg/s")}}, 0.002)):
        path = write_explained(make_channel("gx", B=2e-3), effects=effects)
        assert read_fit(path).channels[0].coefficients["B"].value == pytest.approx(bias)
        assert read_coefficients(path)[0].values["B"] == pytest.approx(bias)
    path = write_explained(make_channel("gx"), verdict="unexplained")
    assert "five terms and what explain names do not explain gx" in export(path, "ros").warnings[0]


@pytest.mark.parametrize("regular", [True, False])
def test_the_n_of_held_values_is_that_which_a_filter_meets(
    write_explained, make_channel, tmp_path, regular
):
    """N^2 is the density of the simulated log at low frequency; YAML keeps that of fresh values."""
    parameters = {"repeat": (1.9, "")} | ({"regular": (1.0, "")} if regular else {})
    path = write_explained(make_channel("gx"), effects={"sample_hold": parameters})
    exported = export(path, "kalibr")
    density = yaml.safe_load(exported.text)["gyroscope_noise_density"] * 180 / np.pi
    assert any("N at low frequency" in each for each in exported.warnings)
    target = tmp_path / "c.yaml"
    export(path, "yaml").write(target)
    (entry,) = read_coefficients(target)
    assert entry.values["N"] == pytest.approx(5e-3)
    drawn = allanfit.simulate(
        {"N": entry.values["N"]}, duration_s=4000.0, rate_hz=100.0, seed=1, effects=entry.effects
    )
    power = np.abs(np.fft.rfft(np.asarray(drawn))[1:4001]) ** 2 / 100.0 / 400_000
    # Up to 1 Hz, where the hold takes less than 1 %; 4,000 ordinates know it to 1.6 %.
    assert power.mean() == pytest.approx(density**2, rel=0.05)


def test_yaml_holds_every_effect_and_reads_back(write_explained, make_channel, tmp_path):
    path, target = write_explained(make_channel("gx"), make_channel("gy")), tmp_path / "c.yaml"
    export(path, "yaml").write(target)
    original, back = read_coefficients(path), read_coefficients(target)
    assert [each.name for each in back[1].effects] == [each.name for each in original[1].effects]
    for one, other in zip(original, back, strict=True):
        assert one.values == other.values
        for found, wanted in zip(one.effects, other.effects, strict=True):
            values, expected = parameter_values(found), parameter_values(wanted)
            assert values.keys() == expected.keys()
            assert all(np.array_equal(values[key], expected[key]) for key in values)
    assert yaml.safe_load(target.read_text())["channels"][0]["effects"][0]["sigma"] == 0.004


def test_simulate_from_explain_has_the_effects(write_explained, make_channel, tmp_path):
    """The command's samples are those of the function, and hold the line."""
    path, record = write_explained(make_channel("gx")), tmp_path / "r.npz"
    arguments = ["--duration", "100", "--rate", "100", "--seed", "3", "--output", str(record)]
    assert main(["simulate", str(path), *arguments]) == 0
    channel = allanfit.load(record).channels[0]
    samples = np.asarray(channel.samples / channel.factor)
    (entry,) = read_coefficients(path)
    expected = allanfit.simulate(
        entry.values,
        duration_s=100.0,
        rate_hz=100.0,
        seed=3 * 1_000_003,
        bias=entry.bias,
        effects=entry.effects,
    )
    np.testing.assert_allclose(samples, expected, rtol=1e-12)
    spectrum = np.abs(np.fft.rfft(samples - samples.mean())) / 5000
    assert spectrum.argmax() == 1300
    # Of white noise 0.05 rms beside 0.02: seven standard errors.
    assert spectrum[1300] == pytest.approx(0.02, abs=0.005)


def test_effects_in_lines_of_yaml(tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text(
        "unit: deg/s\nN: 5e-3\neffects:\n- {name: saturation, limit: 5e-2}\n"
        "- {name: step, amplitude: -0.1, times: [3, 4]}\n"
    )
    (entry,) = read_coefficients(path)
    assert [each.name for each in entry.effects] == ["saturation", "step"]
    samples = np.asarray(
        allanfit.simulate(
            entry.values, duration_s=8.0, rate_hz=100.0, seed=1, effects=entry.effects
        )
    )
    assert np.abs(samples).max() == 0.05
    assert (samples[450:] == -0.05).mean() > 0.99


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{name: gremlin}", "In c.yaml, effect 'gremlin' is not known; known are gauss_markov"),
        ("{name: warm_up, amplitude: 1}", "In c.yaml, warm_up lacks its parameter"),
        ("{name: outliers, fraction: 2, amplitude: 1}", "fraction of outliers must be between"),
        ("{name: low_pass, cutoff_frequency: 0, order: 1}", "of low_pass must be above zero"),
        ("{amplitude: 1}", "An effect in c.yaml needs its name and parameters"),
        ("saturation", "An effect in c.yaml needs its name and parameters"),
        ("{name: saturation, parameters: {limit: {unit: V}}}", "An effect in c.yaml needs its"),
    ],
)
def test_bad_effects_are_one_line(line, message, tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text(f"N: 1\neffects:\n- {line}\n")
    with pytest.raises(CoefficientsError, match=message):
        read_coefficients(path)


def test_without_effects_nothing_changes():
    found = allanfit.simulate({"N": 1.0, "R": 0.1}, duration_s=10.0, rate_hz=50.0, seed=4, bias=2.0)
    model = standard_model({"N": 1.0, "R": 0.1})
    expected = 2.0 + model.sample(jax.random.key(4), 500, 1 / 50, "point")
    np.testing.assert_array_equal(found, expected)


def test_effects_act_in_the_order_of_a_sensor():
    """Rounding comes last, whatever comes first in the list, and losses keep the length."""

    def effect(name, **parameters):
        return effect_from(name, parameters)

    effects = (
        effect("output_rounding", lsb=0.5),
        effect("sample_hold", repeat=4),
        effect("dropped_samples", fraction=0.2),
        effect("saturation", limit=2.0),
        effect("sinusoid", amplitude=3.0, frequency=0.1),
        effect("low_pass", cutoff_frequency=5.0, order=2),
        effect("outliers", fraction=0.1, amplitude=20.0),
    )
    model = standard_model({"N": 0.05})
    key = jax.random.key(5)
    one, other = (
        np.asarray(draw_recording(key, model, each, 1000, 0.01, "point", 0.25))
        for each in (effects, effects[::-1])
    )
    for samples in (one, other):
        assert samples.shape == (1000,)
        assert np.abs(samples).max() == 2
        np.testing.assert_array_equal(samples % 0.5, 0)
        np.testing.assert_array_equal(samples, np.repeat(samples[::4], 4))
    assert np.mean(np.abs(one) == 2) > 0.3


def test_a_filter_smooths_noise_and_leaves_the_ramp():
    low_pass = LowPass(jnp.asarray(1.0), jnp.asarray(2.0))
    model = standard_model({"N": 1e-6, "R": 1.0})
    drawn = draw_recording(jax.random.key(6), model, (low_pass,), 1000, 0.01, "point")
    np.testing.assert_allclose(drawn, 0.01 * np.arange(1000), atol=1e-5)


def test_effects_in_another_unit():
    """The samples of a scaled effect are scaled, for one of every kind of parameter."""
    samples = jax.random.normal(jax.random.key(7), (200,))
    for name, parameters in {
        "gauss_markov": {"sigma": 2, "correlation_time": 0.1},
        "power_law": {"exponent": 1.2, "density": 3},
        "temperature": {"sensitivity": 2, "quadratic": 3},
        "vibration_rectification": {"coefficient": 0.3},
        "sinusoid": {"amplitude": 1, "frequency": 3},
        "sample_hold": {"repeat": 3},
    }.items():
        effect, key = effect_from(name, parameters), jax.random.key(8)
        once = effect.apply(key, samples, 0.01, "point")
        many = scaled(effect, 40.0).apply(key, 40 * samples, 0.01, "point")
        np.testing.assert_allclose(many, 40 * once, rtol=1e-10, atol=1e-10)
    units = {
        (name, each.name): parameter_unit(each, "deg/s")
        for name, effect in EFFECTS.items()
        for each in effect.parameters
    }
    assert units["power_law", "density"] == "(deg/s)^2/Hz"
    assert units["temperature", "sensitivity"] == "deg/s/K"
    assert units["temperature", "quadratic"] == "deg/s/K^2"
    assert units["vibration_rectification", "coefficient"] == "1/(deg/s)"
    assert units["saturation", "limit"] == "deg/s"
    assert units["warm_up", "time_constant"] == "s"
    assert parameter_unit(Saturation.parameters[0], "V") == "V"
    assert parameter_unit(EFFECTS["power_law"].parameters[1], "V") == "V^2/Hz"


def test_coefficients_in_another_unit(write_explained, make_channel):
    (entry,) = read_coefficients(write_explained(make_channel("gx")))
    moved = entry.times(math.pi / 180, "rad/s")
    assert moved.values["N"] == pytest.approx(5e-3 * math.pi / 180)
    assert moved.bias == pytest.approx(0.25 * math.pi / 180)
    noise, resonance = moved.effects[:2]
    assert isinstance(noise, GaussMarkov)
    assert noise.sigma == pytest.approx(0.004 * math.pi / 180)
    assert noise.correlation_time == 30
    assert isinstance(resonance, Resonance)
    assert resonance.frequency == 7


def test_a_plan_from_explain(write_explained, make_channel, capsys):
    path = write_explained(make_channel("gx"))
    assert main(["plan", str(path), "--rate", "100", "--want", "N=1%"]) == 0
    assert "N" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["kalibr", "ros", "matlab", "kalman"])
def test_what_all_channels_have_alike_is_said_once(write_explained, make_channel, name):
    effects = {"dropped_samples": {"fraction": (7.28e-4, "")}}
    channels = [make_channel(f"g{axis}", unresolved="QR") for axis in "xyz"]
    exported = export(write_explained(*channels, effects=effects), name)
    (said,) = [each for each in exported.warnings if "missing" in each and "explain" in each]
    assert "explain found in gx, gy and gz: samples that are missing (fraction" in said
    # The JSON for a filter says of each effect of each channel how it entered, as it must.
    assert name == "kalman" or exported.text.count("samples that are missing") == 1


def test_what_channels_have_in_different_sizes_is_said_of_each(write_explained, make_channel):
    """One amplitude of two units is not one."""
    effects = {"sinusoid": {"amplitude": (0.02, ""), "frequency": (13.0, "Hz")}}
    path = write_explained(make_channel("gx"), make_channel("gy", unit="rad/s"), effects=effects)
    said = [each for each in export(path, "kalibr").warnings if "sinusoid" in each]
    assert [each.split(":")[0].split()[-1] for each in said] == ["gx", "gy"]
