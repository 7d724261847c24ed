"""Does it matter? One filter, five sets of noise numbers, and the errors that it really makes.

A gyro of known noise lies still for three hours and is identified. The same gyro then drives for
an hour, many times over: a filter integrates its rate to an angle, which is measured once a minute
except in four outages of five minutes. A filter is consistent if its errors are as large as it
says: the square of the angle's error over the variance that the filter predicts (NEES), averaged
over drives, is then 1 within what chance allows. All sets of numbers become a filter in the same
way, by allanfit's export to Kalman matrices. Only the numbers differ.

    python examples/filter_consistency.py --output FOLDER
"""

import argparse
import copy
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import matplotlib
import numpy as np
from scipy.linalg import block_diag
from scipy.stats import chi2

jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of backend)
from paper_audit import READ_AT_S, one_point_reading  # noqa: E402
from paper_curves import STYLE  # noqa: E402

import allanfit  # noqa: E402
from allanfit.compilation import shorten_compilation  # noqa: E402
from allanfit.export import export  # noqa: E402
from allanfit.physics import standard_model  # noqa: E402

RATE_HZ = 10.0
TRUTH = {"N": 5e-3, "B": 2e-3, "K": 1e-4}  # deg/s/sqrt(Hz), deg/s, deg/s/sqrt(s)
STILL_S, DRIVE_S = 3 * 3600.0, 3600.0
BLOCK_S = 10.0  # the filter's output; its inputs come at RATE_HZ
FIX_EVERY_S, FIX_SIGMA = 60.0, 0.05  # s, deg
OUTAGES_S = ((600, 900), (1500, 1800), (2400, 2700), (3300, 3600))
TURN_ON_SIGMA = 0.5  # deg/s, of the constant bias that no still recording can foretell
COLOURS = {
    "paper's one point": "#E69F00",
    "slopes by ruler": "#D55E00",
    "data sheet": "#CC79A7",
    "allanfit": "#0072B2",
    "truth": "black",
}


def filter_numbers(still, fit):
    """Coefficients by where they come from; what is not named is not in the filter."""
    size = round(READ_AT_S * RATE_HZ)
    sigma = allanfit.allan_variance(still, RATE_HZ, [size], overlapping=False)[0] ** 0.5
    ruler = allanfit.slope_reading(still, RATE_HZ)
    return {
        "paper's one point": {s: float(v) for s, v in one_point_reading(sigma).items()},
        "slopes by ruler": {s: float(v) for s, v in ruler.items() if np.isfinite(v)},
        "data sheet": sheet(),
        "allanfit": fitted(fit),
        "truth": TRUTH,
    }


def sheet():
    """A kind data sheet, right about this very unit: N, and the lowest point of its Allan curve.

    It is silent about K, as sheets are.
    """
    size = jnp.geomspace(1, 3000, 1000) * RATE_HZ
    variance = standard_model(TRUTH).allan_variance(size, 1 / RATE_HZ, "point")
    return {"N": TRUTH["N"], "B": float(np.sqrt(variance.min()))}


def fitted(fit):
    """What a fit resolves, and the limit of K where it does not: a bias may always wander."""
    numbers = {s: float(fit.coefficients[s]) for s in TRUTH if fit.resolved[s]}
    return {"K": float(fit.upper_limits["K"]), **numbers}


@dataclass(frozen=True)
class Filter:
    """Angle and bias states over blocks of samples, with the covariances that it predicts.

    Neither covariance nor gain depends on the measurements, so that all drives share them.
    """

    transition: np.ndarray
    gains: np.ndarray
    """Shape (blocks, states); zero where there is no fix."""
    sigma: np.ndarray
    """Of the angle after each block, before a fix, shape (blocks,) [deg]."""


def design(matrices, blocks, fixes):
    """The Kalman filter of some noise numbers: x = (angle, the sensor's bias states)."""
    discrete = {name: np.array(rows) for name, rows in matrices["discrete"].items()}
    states = matrices["states"]
    dt = 1 / RATE_HZ
    # The angle grows by the measured rate less what the bias states say, and less white noise.
    step = block_diag(np.eye(1), discrete["Phi"])
    step[:1, 1:] = -dt * discrete["H"]
    noise = block_diag(dt**2 * discrete["Rd"], discrete["Qd"])
    transition, drive = np.eye(len(step)), np.zeros_like(step)
    for _ in range(round(BLOCK_S * RATE_HZ)):
        transition = step @ transition
        drive = step @ drive @ step.T + noise
    unknown = TURN_ON_SIGMA**2
    initial = [unknown if s["initial_variance"] is None else s["initial_variance"] for s in states]
    covariance = np.diag([FIX_SIGMA**2, *initial])
    gains, sigma = np.zeros((blocks, len(step))), np.zeros(blocks)
    for block in range(blocks):
        covariance = transition @ covariance @ transition.T + drive
        sigma[block] = np.sqrt(covariance[0, 0])
        if fixes[block]:
            gain = covariance[:, 0] / (covariance[0, 0] + FIX_SIGMA**2)
            keep = np.eye(len(step))
            keep[:, 0] -= gain
            # Joseph's form stays positive where a fix is much better than the prediction.
            covariance = keep @ covariance @ keep.T + FIX_SIGMA**2 * np.outer(gain, gain)
            gains[block] = gain
    return Filter(transition, gains, sigma)


def angle_errors(design, rate_error, fix_error, fixes):
    """Estimated less true angle [deg] after each block of each drive, before a fix.

    The filter is linear and its rates are exact but for the sensor's noise: its error is the same
    wherever the vehicle turns, so that drives need no road.
    """
    state = np.zeros((len(rate_error), len(design.transition)))
    state[:, 0] = fix_error[:, -1]  # the first angle is a fix, too
    errors = np.zeros_like(rate_error)
    for block, gain in enumerate(design.gains):
        state = state @ design.transition.T
        state[:, 0] += rate_error[:, block]
        errors[:, block] = state[:, 0]
        if fixes[block]:
            state += np.outer(fix_error[:, block] - state[:, 0], gain)
    return errors


def drives(count, seed):
    """Integral of the gyro's error over each block [deg], and the errors of the fixes [deg]."""
    model = standard_model(TRUTH)
    samples, in_block = round(DRIVE_S * RATE_HZ), round(BLOCK_S * RATE_HZ)

    def one(key):
        noise = model.sample(key, samples, 1 / RATE_HZ, "point")
        return jnp.sum(noise.reshape(-1, in_block), axis=1) / RATE_HZ

    noise_key, bias_key, fix_key = jax.random.split(jax.random.key(seed), 3)
    noise = jax.jit(lambda keys: jax.lax.map(one, keys))(jax.random.split(noise_key, count))
    bias = TURN_ON_SIGMA * jax.random.normal(bias_key, (count, 1))
    fix = FIX_SIGMA * jax.random.normal(fix_key, (count, noise.shape[1] + 1))
    return np.asarray(noise + BLOCK_S * bias), np.asarray(fix)


def fix_schedule():
    """Whether the angle is measured at the end of each block."""
    end = BLOCK_S * np.arange(1, round(DRIVE_S / BLOCK_S) + 1)
    outage = np.any([(start < end) & (end < stop) for start, stop in OUTAGES_S], axis=0)
    return end, (end % FIX_EVERY_S == 0) & ~outage


def kalman_matrices(document, coefficients):
    """The export of a fit's JSON with other coefficients in it."""
    changed = copy.deepcopy(document)
    for symbol, entry in changed["channels"][0]["coefficients"].items():
        entry["resolved"] = symbol in coefficients
        entry["value"] = coefficients.get(symbol, 0.0)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fit.json"
        file.write_text(json.dumps(changed))
        return json.loads(export(file, "kalman").text)["channels"][0]


def still_record(seed):
    return allanfit.simulate(TRUTH, duration_s=STILL_S, rate_hz=RATE_HZ, seed=seed)


def run(stills, count, seed):
    """By set of numbers, a list with an entry a still recording: numbers, sigma and errors."""
    end, fixes = fix_schedule()
    rate_error, fix_error = drives(count, seed)
    found = {name: [] for name in COLOURS}
    for index in range(stills):
        still = still_record(seed + index)
        fit = allanfit.fit(still, RATE_HZ)
        if index == 0:
            document = fit.to_dict("gyro", "deg/s")
        for name, numbers in filter_numbers(still, fit).items():
            filter_ = design(kalman_matrices(document, numbers), len(end), fixes)
            errors = angle_errors(filter_, rate_error, fix_error, fixes)
            found[name].append((numbers, filter_.sigma, errors))
    return end, found


def nees(sigma, errors):
    return np.mean((errors / sigma) ** 2, axis=0)


def band(count):
    """Where the mean of `count` squares of standard normals lies with 95 %."""
    return chi2.ppf([0.025, 0.975], count) / count


def table(end, found):
    stills = len(found["truth"])
    count = len(found["truth"][0][2])
    low, high = band(count)
    last = np.searchsorted(end, [stop for _, stop in OUTAGES_S])
    lines = [
        f"{count} drives of {DRIVE_S / 3600:g} h; angle error [deg] after outages of 300 s",
        f"{'':18}{'N':>9}{'B':>9}{'K':>9}{'predicted':>11}{'actual':>8}"
        f"{'NEES after each outage':>25}{'mean, ' + str(stills) + ' still records':>25}",
    ]
    for name, each in found.items():
        numbers, sigma, errors = each[0]
        shown = "".join(f"{numbers[s]:>9.2g}" if s in numbers else f"{'-':>9}" for s in "NBK")
        actual = np.sqrt(np.mean(errors[:, last] ** 2))
        predicted = np.sqrt(np.mean(sigma[last] ** 2))
        after = " ".join(f"{value:.2f}" for value in nees(sigma, errors)[last])
        means = [np.mean(nees(*rest)[last]) for _, *rest in each]
        spread = " to ".join(f"{mean:.2f}" for mean in sorted({min(means), max(means)}))
        lines.append(f"{name:18}{shown}{predicted:>11.3f}{actual:>8.3f}{after:>25}{spread:>25}")
    lines.append(f"Chance alone leaves the NEES between {low:.2f} and {high:.2f} (95 %).")
    return "\n".join(lines)


def draw(end, found, file):
    """Predicted against actual errors over time, a panel a set of numbers, and the NEES of all."""
    count = len(found["truth"][0][2])
    shown = [name for name in found if name != "truth"]
    minutes = end / 60
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(10, 6.5), layout="constrained")
        panels = figure.subplot_mosaic(
            [shown, ["NEES"] * len(shown)], gridspec_kw={"height_ratios": (1, 1.2)}
        )
        for name in shown:
            _, sigma, errors = found[name][0]
            panel = panels[name]
            panel.plot(minutes, sigma, color=COLOURS[name], linewidth=1, label="predicted sigma")
            actual = np.sqrt(np.mean(errors**2, axis=0))
            panel.plot(minutes, actual, "--", color="black", linewidth=0.8, label="actual rms")
            panel.set(title=name, yscale="log", ylim=(0.03, 20), xlabel="time [min]")
            panel.set_yticks([0.1, 1, 10], ["0.1", "1", "10"])
            panel.legend(loc="upper left")
        panels[shown[0]].set_ylabel("angle error [deg]")
        for name in shown[1:]:
            panels[name].tick_params(labelleft=False)
        low, high = band(count)
        panel = panels["NEES"]
        panel.axhspan(low, high, color="#DDDDDD", label="95 % band of chance")
        for name in found:
            _, sigma, errors = found[name][0]
            style = {"linestyle": ":", "linewidth": 1.5} if name == "truth" else {}
            panel.plot(minutes, nees(sigma, errors), color=COLOURS[name], label=name, **style)
        panel.set(
            yscale="log",
            ylim=(0.05, 10),
            xlabel="time [min]",
            ylabel="actual over predicted\nsquared error (NEES)",
        )
        panel.set_yticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
        panel.legend(ncols=3, loc="upper left")
        for panel in panels.values():
            panel.set_xlim(0, minutes[-1])
            panel.set_xticks(np.arange(0, 61, 15))
            for start, stop in OUTAGES_S:
                panel.axvspan(start / 60, stop / 60, color="#F3F3F3", zorder=-1)
        figure.suptitle(f"{count} drives of one gyro; no fixes in the shaded outages")
        figure.savefig(file, dpi=150)
        plt.close(figure)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("allanfit-examples"))
    parser.add_argument("--drives", type=int, default=200)
    parser.add_argument("--stills", type=int, default=8, help="still recordings, all fitted")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    shorten_compilation(options.output / "compiled")
    end, found = run(options.stills, options.drives, seed=1)
    print(table(end, found))
    draw(end, found, options.output / "filter-consistency.png")


if __name__ == "__main__":
    main()
