"""Temperature in a recording's fit, its JSON, text and page."""

import json
import re

import numpy as np
import pytest

import allanfit
from allanfit.identify import fit_recording
from allanfit.recording import load, save
from allanfit.report import format_text, write_page
from allanfit.temperature._channel import _coefficient

RATE_HZ, SAMPLES = 10.0, 3000
TIME = np.arange(SAMPLES) / RATE_HZ
WARM_UP = 25 - 2 * np.exp(-TIME / 60) + 0.4 * np.sin(2 * np.pi * TIME / 90)
UNITS = {"gyro_x": "deg/s", "temperature": "degC"}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    noise = allanfit.simulate(
        {"N": 5e-3, "B": 1e-3, "K": 5e-4}, duration_s=300.0, rate_hz=RATE_HZ, seed=1
    )
    step = WARM_UP - WARM_UP.mean()
    path = tmp_path_factory.mktemp("warm") / "warm.npz"
    data = np.asarray(noise) + 0.05 * step + 0.01 * step**2
    save(path, {"gyro_x": data, "temperature": WARM_UP}, UNITS, RATE_HZ)
    return load(path)


@pytest.fixture(scope="module")
def shown(recording):
    return fit_recording(recording, posterior=False).to_dict()


def test_the_document_has_the_effect_in_the_users_unit(shown, recording):
    json.dumps(shown, allow_nan=False)
    assert shown["checksum"] == recording.checksum
    (channel,) = shown["channels"]
    entry = channel["temperature"]
    assert entry["channel"] == "temperature"
    for name, unit, true in (
        ("linear", "deg/s/degC", 0.05),
        ("quadratic", "deg/s/degC^2", 0.01),
    ):
        low, high = entry[name]["intervals"]["0.95"]
        assert low < true < high
        assert entry[name]["unit"] == unit
        assert entry[name]["resolved"]
    assert entry["coefficients_kept"] == channel["coefficients"]
    kept, removed = (entry[f"coefficients_{how}"]["K"]["value"] for how in ("kept", "removed"))
    assert removed < 0.6 * kept
    assert any("Temperature (" in finding for finding in channel["findings"])
    assert any("still hold the effect" in finding for finding in channel["findings"])
    lengths = {len(values) for values in entry["slow"].values()}
    assert lengths == {120}


def test_the_effect_can_be_taken_out_of_the_main_numbers(recording, shown):
    result = fit_recording(recording, posterior=False, temperature="remove").to_dict()
    (channel,) = result["channels"]
    before = shown["channels"][0]["temperature"]
    assert channel["temperature"]["removed"]
    assert channel["coefficients"] == before["coefficients_removed"]
    assert channel["temperature"]["coefficients_kept"] == before["coefficients_kept"]
    assert any("are without the effect" in finding for finding in channel["findings"])
    assert "effect of temperature taken out" in " ".join(format_text(result).split())
    assert "effect of temperature taken out" not in " ".join(format_text(shown).split())


def test_temperature_can_be_left_alone(recording):
    (channel,) = fit_recording(recording, posterior=False, temperature="ignore").to_dict()[
        "channels"
    ]
    assert channel["temperature"] is None


def test_a_constant_temperature_is_said_and_the_fit_stands(recording, tmp_path):
    columns = {"gyro_x": recording.channels[0].samples, "temperature": np.full(SAMPLES, 21.0)}
    save(tmp_path / "flat.npz", columns, UNITS, RATE_HZ)
    (channel,) = fit_recording(load(tmp_path / "flat.npz"), posterior=False).to_dict()["channels"]
    assert channel["temperature"] is None
    assert channel["status"] == "converged"
    assert any("constant at 21 degC" in finding for finding in channel["findings"])


def test_text_and_page_show_it(shown, tmp_path):
    words = " ".join(format_text(shown).split())
    assert words.count("moves the output by") == 1
    write_page(shown, tmp_path / "fit.html")
    page = (tmp_path / "fit.html").read_text()
    assert page.count("<svg") == 4
    assert "Slow changes beside temperature" in page
    assert "<dt>Temperature</dt>" in page


def fitted(data, temperature, path, treatment="show"):
    save(path, {"gyro_x": data, "temperature": temperature}, UNITS, RATE_HZ)
    (channel,) = fit_recording(load(path), posterior=False, temperature=treatment).to_dict()[
        "channels"
    ]
    return channel


def test_a_warm_up_beside_a_free_ramp_is_told_without_nonsense(tmp_path):
    """A slope and a ramp may each run far off: neither share nor figure may follow them there."""
    time = TIME / TIME[-1]
    warming = 25 + 4 * (1 - np.exp(-0.7 * time))
    made = allanfit.simulate(
        {"N": 5e-3, "B": 1e-3, "K": 5e-4}, duration_s=300.0, rate_hz=RATE_HZ, seed=4
    )
    channel = fitted(np.asarray(made), warming, tmp_path / "even.npz", "remove")
    entry = channel["temperature"]
    assert entry["share_of_ramp"] > 0.9
    assert all(0 <= share <= 1 for share in entry["explained"].values())
    effect, line = entry["sentences"][0], entry["sentences"][-1]
    (told,) = re.findall(r"\(p = ([\d.e-]+)\)", effect)
    assert float(told) == pytest.approx(entry["p_value"], rel=0.05)
    assert ("No effect" in effect) == (entry["p_value"] >= 0.05)
    assert "explains" not in effect
    assert "can hardly be told from a rate ramp" in line
    # Taken out although nothing stands out of the noise: it is said.
    assert any("are without the effect" in finding for finding in channel["findings"])
    # What is drawn leaves less than it found.
    slow = {name: np.array(values) for name, values in entry["slow"].items()}
    assert not entry["curve"]["beside_ramp"]
    assert np.var(slow["residual"] - slow["effect"]) <= np.var(slow["residual"])


def test_a_ramp_that_is_resolved_is_taken_out_of_the_points(tmp_path):
    rng = np.random.default_rng(2)
    step = WARM_UP - WARM_UP.mean()
    data = 0.01 * rng.normal(size=SAMPLES) + 0.05 * step + 1e-3 * TIME
    channel = fitted(data, WARM_UP, tmp_path / "ramp.npz")
    entry = channel["temperature"]
    assert entry["curve"]["beside_ramp"]
    seen = np.array(entry["slow"]["residual"])
    # The ramp alone moves the means by 0.3.
    expected = 0.05 * (np.array(entry["slow"]["temperature_degC"]) - WARM_UP.mean())
    np.testing.assert_allclose(seen, expected, atol=0.02)


def test_digits_are_those_that_the_interval_warrants(shown):
    (channel,) = shown["channels"]
    low, high = channel["temperature"]["linear"]["intervals"]["0.95"]
    place = 1 - int(np.floor(np.log10((high - low) / 2)))
    told = f"[{low:.{place}f}, {high:.{place}f}] deg/s/degC"
    assert told in channel["temperature"]["sentences"][0]


def test_coefficients_have_the_digits_of_a_table():
    """Of a limit two, rounded up so that it stays one."""
    unresolved = {"resolved": False, "upper_limit_95": 3.13e-4, "unit": "deg/s/sqrt(s)"}
    assert _coefficient(unresolved) == "below 3.2e-4 deg/s/sqrt(s)"
    assert _coefficient({**unresolved, "upper_limit_95": None}) == "no limit"
    resolved = {"resolved": True, "value": 0.0012345, "intervals": {"0.95": [0.0011, 0.0014]}}
    assert _coefficient({**resolved, "unit": "g"}) == "0.00123 g"
