"""Draw the figures of the docs: `python docs/_site/figures.py`. Every draw has a seed."""

from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np

import allanfit

DOCS = Path(__file__).parents[1]
GYRO = {"Q": 5e-4, "N": 5e-3, "B": 2e-3, "K": 2e-4, "R": 2e-6}
_FACTOR = {
    "Q": lambda tau: np.sqrt(3) / tau,
    "N": lambda tau: 1 / np.sqrt(tau),
    "B": lambda tau: np.sqrt(2 * np.log(2) / np.pi) * np.ones_like(tau),
    "K": lambda tau: np.sqrt(tau / 3),
    "R": lambda tau: tau / np.sqrt(2),
}
_SLOPE = {"Q": "-1", "N": "-1/2", "B": "0", "K": "+1/2", "R": "+1"}


def anatomy() -> None:
    """An Allan deviation, and the asymptotes of its five terms."""
    rate, duration = 100.0, 4 * 3600.0
    samples = allanfit.simulate(GYRO, duration_s=duration, rate_hz=rate, seed=7)
    sizes = allanfit.cluster_sizes(samples.size)
    deviation = np.sqrt(allanfit.allan_variance(samples, rate, sizes))
    tau = np.geomspace(0.01, 2e4, 200)
    figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
    for symbol, factor in _FACTOR.items():
        label = f"{symbol}, slope {_SLOPE[symbol]}"
        axes.loglog(tau, GYRO[symbol] * factor(tau), "--", linewidth=1, label=label)
    axes.loglog(np.asarray(sizes) / rate, deviation, "k.", markersize=4, label="a recording of 4 h")
    total = np.sqrt(sum((GYRO[s] * factor(tau)) ** 2 for s, factor in _FACTOR.items()))
    axes.loglog(tau, total, "k", linewidth=1, alpha=0.6, label="the sum of the five")
    for at, symbol, place in ((1.0, "N", (0.03, 1.6e-3)), (3.0, "K", (0.03, 5e-4))):
        value = GYRO[symbol] * _FACTOR[symbol](np.array(at))
        axes.annotate(
            f"{symbol} is read at {at:g} s", (at, value), place,
            arrowprops={"arrowstyle": "-", "color": "0.4"}, color="0.2",
        )  # fmt: skip
    axes.set(
        xlim=(0.01, 2e4), ylim=(1e-4, 2e-1), xlabel="averaging time τ [s]",
        ylabel="Allan deviation [deg/s]",
    )  # fmt: skip
    axes.grid(color="0.9")
    axes.legend(frameon=False, fontsize=9, loc="upper center")
    figure.savefig(DOCS / "anatomy.png", dpi=110)


def how_long() -> None:
    """The length that a plan asks for each error, for the gyro of the page."""
    gyro = {symbol: GYRO[symbol] for symbol in "NBK"}
    wanted = np.geomspace(1e-4, 0.9, 25)
    figure, axes = plt.subplots(figsize=(7.2, 3.8), layout="constrained")
    for symbol in "NBK":
        found = [allanfit.plan(gyro, 100.0, {symbol: e}).durations_s[symbol] for e in wanted]
        known = [(length, 100 * e) for length, e in zip(found, wanted, strict=True) if length]
        axes.loglog(*np.transpose(known), label=symbol)
    axes.set(
        xlabel="length of the recording", ylabel="relative standard error [%]",
        xlim=(60, 2 * 86400), ylim=(0.01, 100),
    )  # fmt: skip
    axes.set_xticks([60, 600, 3600, 6 * 3600, 86400], ["1 min", "10 min", "1 h", "6 h", "1 day"])
    axes.set_yticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    axes.minorticks_off()
    axes.grid(color="0.9")
    axes.legend(frameon=False)
    figure.savefig(DOCS / "how-long.png", dpi=110)


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    anatomy()
    how_long()
