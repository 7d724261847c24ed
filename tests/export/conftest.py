"""Fits made by hand, with known numbers."""

import json

import pytest

UNITS = {
    "deg/s": ("deg", "deg/s/sqrt(Hz)", "deg/s", "deg/s/sqrt(s)", "deg/s^2"),
    "rad/s": ("rad", "rad/s/sqrt(Hz)", "rad/s", "rad/s/sqrt(s)", "rad/s^2"),
    "m/s^2": ("m/s", "m/s^2/sqrt(Hz)", "m/s^2", "m/s^2/sqrt(s)", "m/s^3"),
    "V": ("V s", "V/sqrt(Hz)", "V", "V/sqrt(s)", "V/s"),
}


def coefficient(symbol, unit, value, resolved):
    return {
        "name": f"term {symbol}",
        "unit": unit,
        "value": value,
        "resolved": resolved,
        "upper_limit_95": None if resolved else 2 * value,
        "intervals": {
            "0.68": [0.9 * value if resolved else 0.0, 1.1 * value],
            "0.95": [0.8 * value if resolved else 0.0, 1.2 * value],
        },
    }


def channel(name, unit="deg/s", rate_hz=100.0, samples=360_000, unresolved="QR", **values):
    values = {"Q": 1e-6, "N": 5e-3, "B": 2e-3, "K": 3e-4, "R": 1e-7, **values}
    return {
        "channel": name,
        "unit": unit,
        "rate_hz": rate_hz,
        "samples": samples,
        "sampling": "point",
        "mean": 0.25,
        "goodness_of_fit": {"p_value": 0.5, "consistent": True},
        "coefficients": {
            symbol: coefficient(
                symbol, UNITS[unit][index], values[symbol], symbol not in unresolved
            )
            for index, symbol in enumerate("QNBKR")
        },
    }


@pytest.fixture
def write_fit(tmp_path):
    """Writes the JSON of a fit with these channels, and returns its path."""

    def write(*channels, schema="allanfit.fit/1"):
        path = tmp_path / "fit.json"
        path.write_text(
            json.dumps({"schema": schema, "recording": "still.csv", "channels": channels})
        )
        return path

    return write


@pytest.fixture
def make_channel():
    return channel


EFFECTS = {
    "gauss_markov": {"sigma": (0.004, "deg/s"), "correlation_time": (30.0, "s")},
    "resonance": {
        "sigma": (0.003, "deg/s"),
        "frequency": (7.0, "Hz"),
        "quality_factor": (4.0, ""),
    },
    "sinusoid": {"amplitude": (0.02, "deg/s"), "frequency": (13.0, "Hz")},
    "variance_modulation": {"ratio": (3.0, ""), "intervals": ([[10.0, 20.0]], "s")},
}


@pytest.fixture
def write_explained(tmp_path):
    """Writes the JSON of explain with these channels, all with these effects."""

    def write(*channels, effects=EFFECTS, verdict="explained"):
        entries = []
        for entry in channels:
            left = {key: value for key, value in entry.items() if key != "coefficients"}
            after = entry["coefficients"]
            # Left out, the effects made B what it is not.
            before = {**after, "B": {**after["B"], "value": 7 * after["B"]["value"]}}
            named = [
                {
                    "name": name,
                    "probability": 0.9,
                    "alternatives": [],
                    "parameters": {
                        key: {"value": value, "unit": unit, "intervals": {"0.95": [0, 1]}}
                        for key, (value, unit) in parameters.items()
                    },
                    "sentence": "It is there.",
                }
                for name, parameters in effects.items()
            ]
            entries.append(
                {
                    **left,
                    "duration_s": entry["samples"] / entry["rate_hz"],
                    "verdict": verdict,
                    "effects": named,
                    "coefficients_before": before,
                    "coefficients_after": after if effects else {},
                }
            )
        document = {"schema": "allanfit.explain/1", "recording": "still.csv", "channels": entries}
        path = tmp_path / "explain.json"
        path.write_text(json.dumps(document))
        return path

    return write
