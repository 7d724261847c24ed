"""An audit of Ashraf and Nafees: where the printed numbers come from, and what 600 s can tell.

The four coefficients of each axis turn out to be one reading of the Allan curve, at 20 s, put
through four formulas. Sensors with the printed coefficients are then recorded many times under
the paper's protocol, and read in three ways: at that one point, with a ruler on the slopes, and
by allanfit. At last the rate-table readings are set against the biases printed beside them.

    python examples/paper_audit.py --output FOLDER
"""

import argparse
import math
from pathlib import Path

import jax
import matplotlib
import numpy as np

jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of backend)
from paper_curves import DT, RATE_HZ, SAMPLES, STYLE, printed_coefficients  # noqa: E402

import allanfit  # noqa: E402
from allanfit.compilation import shorten_compilation  # noqa: E402
from allanfit.physics import standard_model  # noqa: E402

READ_AT_S = 20.0
FLICKER_FLOOR = math.sqrt(2 * math.log(2) / math.pi)  # of the Allan deviation, for B = 1
RATE_TABLE = Path(__file__).with_name("rate_table.csv")
REPORTED_BIAS = {"roll": -6.83, "pitch": 1.17, "yaw": -9.76}  # deg/s, printed by the paper
SYMBOLS = "QNBK"
COLOURS = {"one point": "#E69F00", "ruler": "#D55E00", "allanfit": "#0072B2"}


def one_point_reading(sigma, tau=READ_AT_S):
    """The coefficients as the paper has them from sigma(tau); N with its slope the wrong way."""
    return {
        "Q": sigma * tau / math.sqrt(3),
        "N": sigma / math.sqrt(tau),
        "B": sigma / FLICKER_FLOOR,
        "K": sigma * math.sqrt(3 / tau),
    }


def sigma_behind(coefficients):
    """The sigma(20 s) that each printed coefficient was made of, if it was."""
    for_one = one_point_reading(1.0)
    return {symbol: coefficients[symbol] / for_one[symbol] for symbol in SYMBOLS}


def depth_of_random_walk(coefficients):
    """How far below the highest of the other lines N's line lies, where it comes closest."""
    tau = np.geomspace(DT, SAMPLES * DT, 2001)
    others = np.maximum.reduce(
        [
            math.sqrt(3) * coefficients["Q"] / tau,
            FLICKER_FLOOR * coefficients["B"] * np.ones_like(tau),
            coefficients["K"] * np.sqrt(tau / 3),
        ]
    )
    return float((others * np.sqrt(tau) / coefficients["N"]).min())


def tables_from_one_point(axes):
    lines = [
        "1. Each axis is one number, sigma(20 s): what each printed coefficient says it was",
        f"{'':17}{'from Q':>11}{'from N*':>11}{'from B':>11}{'from K':>11}{'spread':>9}"
        f"{'N line below':>15}",
    ]
    for name, (_, coefficients) in axes.items():
        sigma = list(sigma_behind(coefficients).values())
        spread = max(sigma) / min(sigma) - 1
        shown = "".join(f"{value:>11.4g}" for value in sigma)
        depth = depth_of_random_walk(coefficients)
        lines.append(f"{name:17}{shown}{spread:>9.1%}{depth:>13.1f} x")
    lines.append(
        "* by N = sigma/sqrt(tau); the slope of -1/2 gives sigma sqrt(tau), 20 times as much."
    )
    return "\n".join(lines)


def readings(coefficients, records, seed):
    """Of each of many 600 s records: the reading at one point, the ruler's, and the fit."""
    model = standard_model(coefficients)
    keys = jax.random.split(jax.random.key(seed), records)
    draw = jax.jit(jax.vmap(lambda key: model.sample(key, SAMPLES, DT, "point")))
    samples = draw(keys)
    size = round(READ_AT_S / DT)
    variance = allanfit.allan_variance(samples, RATE_HZ, [size], overlapping=False)
    one_point = one_point_reading(np.sqrt(variance[:, 0]))
    read = [allanfit.slope_reading(each, RATE_HZ) for each in samples]
    fits = [allanfit.fit(each, RATE_HZ) for each in samples]

    def over_truth(values, symbol):
        return np.array([each[symbol] for each in values]) / coefficients[symbol]

    return {
        symbol: {
            "one point": np.asarray(one_point[symbol]) / coefficients[symbol],
            "ruler": over_truth(read, symbol),
            "value": over_truth([fit.coefficients for fit in fits], symbol),
            "interval": over_truth([fit.intervals for fit in fits], symbol),
            "resolved": np.array([fit.resolved[symbol] for fit in fits]),
        }
        for symbol in SYMBOLS
    }


def covers(interval):
    return (interval[:, 0] <= 1) & (interval[:, 1] >= 1)


def first_record(found, coefficients):
    """What allanfit says of a single record of the paper's length."""
    lines = [
        "2. A roll gyro with the printed coefficients (rad, s), recorded once for 600 s at 50 Hz",
        f"{'':3}{'truth':>11}{'95 % interval':>26}",
    ]
    for symbol, each in found.items():
        truth = coefficients[symbol]
        low, high = truth * each["interval"][0]
        verdict = "resolved" if each["resolved"][0] else "not resolved: a limit"
        lines.append(f"{symbol:3}{truth:>11.3g}{f'{low:.3g} to {high:.3g}':>26}   {verdict}")
    return "\n".join(lines)


def many_records(found):
    records = len(found["Q"]["value"])
    lines = [
        f"3. The same roll gyro recorded {records} times: median reading over truth",
        f"{'':3}{'one point':>11}{'ruler':>9}{'no slope':>10}{'allanfit':>10}{'resolved':>10}"
        f"{'95 % intervals that hold the truth':>37}",
    ]
    for symbol, each in found.items():
        ruler, none = each["ruler"], np.isnan(each["ruler"])
        read = "-" if none.all() else f"{np.nanmedian(ruler):.2f}"
        held = f"{covers(each['interval']).sum()} of {records}"
        lines.append(
            f"{symbol:3}{np.median(each['one point']):>11.2f}{read:>9}{none.mean():>10.0%}"
            f"{np.median(each['value']):>10.2f}{each['resolved'].mean():>10.0%}{held:>37}"
        )
    return "\n".join(lines)


def rate_table_biases():
    """Bias, 95 % interval and the paper's own number [deg/s], by axis."""
    # The tables give revolutions a minute: 6 deg/s.
    found = allanfit.calibrate.rate_table(RATE_TABLE, unit="rpm")
    return {
        name: (6 * axis.bias.value, [6 * end for end in axis.bias.intervals["0.95"]], axis)
        for name, axis in found.axes.items()
    }


def rate_table_audit():
    lines = [
        "4. Gyro bias [deg/s] from the printed rate-table readings, and as the paper reports it",
        f"{'':7}{'bias':>7}{'95 % interval':>19}{'significant':>13}{'reported':>10}",
    ]
    for name, (bias, (low, high), axis) in rate_table_biases().items():
        interval = f"{low:+.2f} to {high:+.2f}"
        significant = "yes" if axis.bias.significant else "no"
        reported = REPORTED_BIAS[name]
        where = "" if low <= reported <= high else "   outside the interval"
        lines.append(
            f"{name:7}{bias:>+7.2f}{interval:>19}{significant:>13}{reported:>+10.2f}{where}"
        )
    return "\n".join(lines)


def draw(found, file):
    """All readings over truth, a panel a coefficient."""
    titles = {
        "Q": "Q, quantization",
        "N": "N, random walk",
        "B": "B, bias instability",
        "K": "K, rate random walk",
    }
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 4, figsize=(10, 4), sharey=True, layout="constrained")
        for panel, (symbol, each) in zip(panels, found.items(), strict=True):
            panel.axhline(1, color="black", linewidth=1)
            for place, method in enumerate(("one point", "ruler")):
                value = np.sort(each[method])  # readings that found no slope go last, unseen
                across = place + np.linspace(-0.3, 0.3, len(value))
                panel.plot(across, value, "o", color=COLOURS[method], markersize=2.5)
                missing = np.isnan(value).sum()
                if missing:
                    panel.text(
                        place,
                        0.12,
                        f"no slope\nin {missing} of\n{len(value)}",
                        ha="center",
                        va="bottom",
                    )
            _intervals(panel, each)
            panel.set(title=titles[symbol], yscale="log", ylim=(0.1, 100), xlim=(-0.5, 2.9))
            panel.set_xticks(
                [0, 1, 2.2], ["one point\nat 20 s", "slopes\nby ruler", "allanfit\n95 %"]
            )
            panel.grid(which="major", axis="y", color="#E5E5E5", linewidth=0.5)
        panels[0].set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
        panels[0].set_ylabel("reading over truth")
        figure.suptitle(
            f"{len(found['Q']['value'])} records of 600 s of one gyro; the line is the truth. "
            "Open circles: not resolved, the bar is a limit."
        )
        figure.savefig(file, dpi=150)
        plt.close(figure)


def _intervals(panel, each):
    order = np.argsort(each["interval"][:, 1])
    across = 2.2 + np.linspace(-0.5, 0.5, len(order))
    low, high = np.maximum(each["interval"][order], 1e-3).T
    panel.vlines(across, low, high, color=COLOURS["allanfit"], linewidth=0.8, alpha=0.5)
    for seen, face in ((True, COLOURS["allanfit"]), (False, "white")):
        shown = each["resolved"][order] == seen
        panel.plot(
            across[shown],
            each["value"][order][shown],
            "o",
            color=COLOURS["allanfit"],
            markerfacecolor=face,
            markersize=2.5,
            markeredgewidth=0.7,
        )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("allanfit-examples"))
    parser.add_argument("--records", type=int, default=48, help="of 600 s, all fitted")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    shorten_compilation(options.output / "compiled")
    axes = printed_coefficients()
    print(tables_from_one_point(axes), end="\n\n")
    _, roll = axes["roll gyro"]
    found = readings(roll, options.records, seed=1)
    print(first_record(found, roll), end="\n\n")
    print(many_records(found), end="\n\n")
    print(rate_table_audit())
    draw(found, options.output / "paper-audit.png")


if __name__ == "__main__":
    main()
