"""Explanations written by hand: effects added to the curves of a fit, the five terms refitted."""

import copy
import math
from typing import Any

import numpy as np
from scipy.optimize import nnls

KEYS = {"allan": ("tau_s", "deviation"), "psd": ("frequency_hz", "density")}


def _powers(curve: dict[str, Any], kind: str) -> tuple[np.ndarray, np.ndarray]:
    """The model and its terms as what adds: variances or densities."""
    power = 2 if kind == "allan" else 1
    terms = np.array(list(curve["terms"].values())) ** power
    return np.array(curve["model"]) ** power, terms


def add_effects(curves: dict[str, Any], effects: dict[str, dict[str, np.ndarray]]) -> dict:
    """Curves of a sensor with effects beside its terms, `effects[name][kind]` variances."""
    found: dict[str, Any] = {"time": None, "lines": []}
    rows, totals = [], []
    for kind in KEYS:
        model, terms = _powers(curves[kind], kind)
        total = model + sum(effect[kind] for effect in effects.values())
        rows.append((terms / total).T)
        totals.append(total)
    weights, _ = nnls(np.vstack(rows), np.ones(sum(map(len, totals))))
    for kind, total in zip(KEYS, totals, strict=True):
        x_key, data_key = KEYS[kind]
        curve = curves[kind]
        power = 0.5 if kind == "allan" else 1.0
        model, terms = _powers(curve, kind)
        gain = (total / model) ** power
        found[kind] = {
            x_key: curve[x_key],
            data_key: (np.array(curve[data_key]) * gain).tolist(),
            "band_95": (np.array(curve["band_95"]) * gain).tolist(),
            "model_before": ((weights @ terms) ** power).tolist(),
            "model_after": (total**power).tolist(),
            "effects": {name: (each[kind] ** power).tolist() for name, each in effects.items()},
        }
    return found


def gauss_markov(curves: dict[str, Any], sigma: float, time: float) -> dict[str, np.ndarray]:
    """Variances of exponentially correlated noise, IEEE Std 952, annex C."""
    tau = np.array(curves["allan"]["tau_s"]) / time
    frequency = np.array(curves["psd"]["frequency_hz"])
    shape = 1 - (3 - 4 * np.exp(-tau) + np.exp(-2 * tau)) / (2 * tau)
    return {
        "allan": 2 * sigma**2 / tau * shape,
        "psd": 4 * sigma**2 * time / (1 + (2 * math.pi * frequency * time) ** 2),
    }


def sinusoid(curves: dict[str, Any], amplitude: float, line: float) -> dict[str, np.ndarray]:
    """Variances of a line, all of it in one bin of the spectrum."""
    x = math.pi * line * np.array(curves["allan"]["tau_s"])
    frequency = np.array(curves["psd"]["frequency_hz"])
    density = np.zeros_like(frequency)
    bin_ = np.argmin(abs(frequency - line))
    density[bin_] = amplitude**2 / 2 / np.gradient(frequency)[bin_]
    return {"allan": amplitude**2 * (np.sin(x) ** 2 / x) ** 2, "psd": density}


def zoom(line: float, floor: float, height: float, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    offset = np.arange(-30, 31) / 3600
    model = floor + height * np.sinc(offset * 3600) ** 2
    density = model * rng.exponential(size=61)
    return {
        "frequency_hz": (line + offset).tolist(),
        "density": density.tolist(),
        "model": model.tolist(),
        "line_hz": line,
    }


def parameter(value: Any, unit: str, width: float = 0.0) -> dict[str, Any]:
    bounds = {
        level: [value * (1 - share * width), value * (1 + share * width)]
        for level, share in (("0.68", 0.5), ("0.95", 1.0))
        if width
    }
    return {"value": value, "unit": unit, "intervals": bounds}


def mismatch(domain: str, low: float, high: float, ratio: float, p: float, sentence: str) -> dict:
    return {
        "domain": domain,
        "low": low,
        "high": high,
        "unit": "Hz" if domain == "frequency" else "s",
        "ratio": ratio,
        "p_value": p,
        "sentence": sentence,
    }


def scaled(coefficients: dict[str, Any], factors: dict[str, float]) -> dict[str, Any]:
    """Coefficients with values, limits and intervals multiplied."""
    found = copy.deepcopy(coefficients)
    for symbol, factor in factors.items():
        entry = found[symbol]
        entry["value"] *= factor
        for level, bounds in entry["intervals"].items():
            entry["intervals"][level] = [factor * bound for bound in bounds]
    return found


def plain(channel: dict[str, Any], name: str, verdict: str) -> dict[str, Any]:
    """A channel of a fit as one of an explanation in which nothing was found yet."""
    keys = ["unit", "si_unit", "kind", "rate_hz", "samples", "duration_s", "sampling", "mean"]
    return {
        "channel": name,
        **{key: channel[key] for key in keys},
        "verdict": verdict,
        "false_alarm_probability": 0.37,
        "mismatch": [],
        "effects": [],
        "coefficients_before": channel["coefficients"],
        "coefficients_after": {},
        "improvement": None,
        "witnesses": [],
        "advice": [],
        "findings": [],
        "curves": add_effects(channel["curves"], {}),
    }


def improvement(gain: float, error: float, p_after: float) -> dict[str, Any]:
    return {
        "held_out_log_score": {
            "before": -10234.4,
            "after": -10234.4 + gain,
            "difference": gain,
            "standard_error": error,
        },
        "p_value_before": 1.3e-19,
        "p_value_after": p_after,
    }


def in_spectrum(gyro: dict[str, Any]) -> dict[str, Any]:
    """A Gauss-Markov process and a sinusoid."""
    found = plain(gyro, "gyro_x", "explained")
    curves = gyro["curves"]
    effects = {
        "gauss_markov": gauss_markov(curves, 3e-3, 2.0),
        "sinusoid": sinusoid(curves, 3e-2, 13.02),
    }
    found["curves"] = add_effects(curves, effects)
    found["curves"]["lines"] = [zoom(13.02, 5e-5, 1.6, 1), zoom(26.04, 5e-5, 4e-4, 2)]
    after = gyro["coefficients"]
    found |= {
        "false_alarm_probability": 4e-7,
        "coefficients_before": scaled(after, {"N": 1.31, "B": 2.4, "K": 1.08}),
        "coefficients_after": after,
        "improvement": improvement(247.2, 21.3, 0.37),
        "mismatch": [
            mismatch(
                "frequency",
                13.019,
                13.022,
                31.2,
                1e-19,
                "A line at 13.02 Hz stands 31 times above the five terms.",
            ),
            mismatch(
                "frequency",
                0.041,
                0.32,
                2.94,
                3.1e-9,
                "From 0.041 Hz to 0.32 Hz the spectrum is 2.9 times the five terms.",
            ),
            mismatch(
                "tau",
                1.2,
                7.9,
                1.42,
                6e-5,
                "Between 1.2 s and 7.9 s the Allan deviation has a bump that no sum of the five "
                "terms can follow.",
            ),
        ],
        "effects": [
            {
                "name": "gauss_markov",
                "probability": 0.974,
                "alternatives": [
                    {
                        "name": "random_telegraph",
                        "probability": 0.026,
                        "told_apart_by": "the histogram of 2 s means, with 40 min more",
                    }
                ],
                "parameters": {
                    "sigma": parameter(3.02e-3, "deg/s", 0.04),
                    "correlation_time": parameter(2.03, "s", 0.11),
                },
                "sentence": "The recording holds exponentially correlated noise, as of trapped "
                "charge, a control loop or a package that relaxes.",
            },
            {
                "name": "sinusoid",
                "probability": 0.9996,
                "alternatives": [],
                "parameters": {
                    "amplitude": parameter(3.01e-2, "deg/s", 0.006),
                    "frequency": parameter(13.0204, "Hz", 2e-6),
                },
                "sentence": "The recording holds a sinusoid, as of a motor or of the mains; if the "
                "sensor does not filter, it may be the alias of 86.98 Hz or 113.02 Hz.",
            },
        ],
        "witnesses": [
            {
                "name": "kurtosis",
                "statistic": 3.02,
                "p_value": 0.21,
                "sentence": "The distribution is normal in its tails: no outliers, no levels.",
            },
            {
                "name": "local_variance",
                "statistic": 61.2,
                "p_value": 0.4,
                "sentence": "The noise level is the same from start to end.",
            },
        ],
        "advice": [
            "Look for a source of vibration at 13.02 Hz or one of its aliases.",
            "Give a filter a Gauss-Markov state of 2.0 s beside the random walk.",
        ],
    }
    return found


def in_time(gyro: dict[str, Any]) -> dict[str, Any]:
    """Steps of the mean and an hour with a louder stretch."""
    found = plain(gyro, "gyro_y", "explained")
    rng = np.random.default_rng(5)
    time = np.linspace(15, 3585, 120)
    model = 0.0123 + 2e-3 * (time > 900) - 1.2e-3 * (time > 2460)
    loud = (time > 1500) & (time < 2100)
    deviation = np.where(loud, 0.08, 0.05) * (1 + 0.02 * rng.standard_normal(120))
    found["curves"]["time"] = {
        "time_s": time.tolist(),
        "mean": (model + 3e-4 * rng.standard_normal(120)).tolist(),
        "deviation": deviation.tolist(),
        "model": model.tolist(),
        "intervals": [[1500.0, 2100.0]],
    }
    found |= {
        "false_alarm_probability": 0.0004,
        "coefficients_before": scaled(gyro["coefficients"], {"N": 1.02, "B": 1.3, "K": 8.2}),
        "coefficients_after": gyro["coefficients"],
        "improvement": improvement(58.3, 11.2, 0.08),
        "mismatch": [
            mismatch("time", 890, 910, 7.1, 1e-8, "The mean changes by 2.0e-3 deg/s at 15 min."),
            mismatch("time", 1500, 2100, 1.6, 3e-6, "The noise is 1.6 times as strong."),
        ],
        "effects": [
            {
                "name": "step",
                "probability": 0.83,
                "alternatives": [
                    {
                        "name": "disturbance",
                        "probability": 0.15,
                        "told_apart_by": "the other axes, if the sensor was knocked",
                    },
                    {"name": "random_telegraph", "probability": 0.02, "told_apart_by": None},
                ],
                "parameters": {
                    "amplitude": parameter(2e-3, "deg/s", 0.12),
                    "times": parameter([900.0, 2460.0], "s"),
                },
                "sentence": "The mean jumps twice.",
            },
            {
                "name": "variance_modulation",
                "probability": 0.96,
                "alternatives": [],
                "parameters": {
                    "ratio": parameter(1.6, "", 0.03),
                    "intervals": parameter([[1500.0, 2100.0]], "s"),
                },
                "sentence": "The noise level changes, as when something runs nearby.",
            },
        ],
        "advice": ["Leave out 25 min to 35 min, or give a filter the louder N there."],
    }
    return found


def bump(accelerometer: dict[str, Any]) -> dict[str, Any]:
    """A hump of no known shape, and strings that would do harm if they were not escaped."""
    found = plain(accelerometer, "<script>alert('$x_1$')</script>", "unexplained")
    curves = accelerometer["curves"]
    frequency = np.array(curves["psd"]["frequency_hz"])
    tau = np.array(curves["allan"]["tau_s"])
    hump = {
        "psd": 2e-6 * np.exp(-((np.log(frequency / 5) / 0.5) ** 2)),
        "allan": 4e-6 * np.exp(-((np.log(tau * 5 / 0.37) / 0.8) ** 2)),
    }
    found["curves"] = add_effects(curves, {"bump": hump})
    found |= {
        "false_alarm_probability": 1e-15,
        "coefficients_before": scaled(accelerometer["coefficients"], {"Q": 3.0, "N": 2.6}),
        "coefficients_after": accelerometer["coefficients"],
        "improvement": improvement(803.0, 34.0, 2.2e-4),
        "mismatch": [
            mismatch(
                "frequency", 2.6, 9.4, 48.0, 1e-30, "A hump <img src=x> around 5 Hz, 48 times."
            ),
            mismatch("frequency", 0.3, 1.1, 0.44, 1e-7, "Beside it the five terms are too high."),
        ],
        "effects": [
            {
                "name": "bump",
                "probability": 1.0,
                "alternatives": [],
                "parameters": {"frequency": parameter(5.01, "Hz", 0.02)},
                "sentence": "A hump about 5 Hz that nothing in the catalogue makes.",
            }
        ],
        "advice": ["Send <b>this</b> page to the maker."],
        "findings": ["A finding with <i>marks</i>."],
    }
    return found


def make_explanation(example: dict[str, Any]) -> dict[str, Any]:
    """All three verdicts, made of the channels of a fit document."""
    gyro, accelerometer = example["channels"][:2]
    document = {
        "schema": "allanfit.explain/1",
        "recording": "bench <b>3</b>.csv",
        "checksum": "sha256:3f1c9a",
        "allanfit_version": "0.1.0",
        "findings": ["The time stamps repeat 2 times."],
        "channels": [
            in_spectrum(gyro),
            in_time(gyro),
            plain(gyro, "gyro_z", "consistent"),
            bump(accelerometer),
        ],
    }
    return copy.deepcopy(document)
