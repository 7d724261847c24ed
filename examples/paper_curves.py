"""The curves of Ashraf and Nafees, their way and beside it the way that loses least.

Six axes are simulated from the coefficients that the paper prints, under its own protocol: 30000
samples, 50 a second. Its way is the periodogram |X|^2/T, averaged in bins of equal width in log f,
and the Allan variance of seven cluster sizes without overlap. Beside it stand the mirror spectrum
and the overlapping Allan variance, with the bands that allanfit gives them. A table then says by
how much either errs, from records whose truth is known.

    python examples/paper_curves.py --output FOLDER
"""

import argparse
import csv
from pathlib import Path

import jax
import jax.numpy as jnp
import matplotlib
import numpy as np

jax.config.update("jax_enable_x64", True)
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of backend)

import allanfit  # noqa: E402
from allanfit.compilation import shorten_compilation  # noqa: E402
from allanfit.physics import standard_model  # noqa: E402

SAMPLES, DT = 30_000, 0.02
RATE_HZ = 1 / DT
CLUSTERS = np.array([10, 50, 100, 500, 1000, 5000, 10_000])
COEFFICIENTS = Path(__file__).with_name("paper_coefficients.csv")
BANDS_HZ = ((0.0016, 0.005), (0.005, 0.02), (0.02, 0.1), (0.1, 1.0), (1.0, 25.0))
TRUTH, PAPER, ALLANFIT, RAW = "black", "#D55E00", "#0072B2", "#BDBDBD"
STYLE = {"font.size": 8, "legend.fontsize": 8, "axes.axisbelow": True, "legend.frameon": False}


def printed_coefficients(path=COEFFICIENTS):
    """Unit and coefficients by axis, from the paper's tables VI and VII."""
    with path.open() as lines:
        return {
            row["axis"]: (row["unit"], {symbol: float(row[symbol]) for symbol in "QNBK"})
            for row in csv.DictReader(lines)
        }


def record(coefficients, seed):
    return allanfit.simulate(coefficients, duration_s=SAMPLES * DT, rate_hz=RATE_HZ, seed=seed)


def paper_deviation(samples):
    """Root Allan variance of consecutive clusters, at the paper's seven sizes."""
    return jnp.sqrt(allanfit.allan_variance(samples, RATE_HZ, CLUSTERS, overlapping=False))


def paper_spectrum(samples, bins_per_decade=16):
    """|X|^2/T of the record as it is, one-sided, averaged in logarithmic bins."""
    return allanfit.psd(samples, RATE_HZ, taper="none", bins_per_decade=bins_per_decade)


def errors(coefficients, records, seed):
    """Of either estimate: rms relative error of sigma, mean density over the truth by band."""
    model = standard_model(coefficients)
    sigma = jnp.sqrt(model.allan_variance(jnp.asarray(CLUSTERS, float), DT, "point"))

    def estimates(key):
        samples = model.sample(key, SAMPLES, DT, "point")
        overlapping = jnp.sqrt(allanfit.allan_variance(samples, RATE_HZ, CLUSTERS))
        deviations = jnp.stack([paper_deviation(samples), overlapping])
        spectra = paper_spectrum(samples), allanfit.psd(samples, RATE_HZ)
        return deviations / sigma - 1, tuple(_over_truth(model, each) for each in spectra)

    keys = jax.random.split(jax.random.key(seed), records)
    error, ratio = jax.jit(lambda keys: jax.lax.map(estimates, keys))(keys)
    return np.sqrt(np.mean(error**2, axis=0)), np.array([each.mean(axis=0) for each in ratio])


def _over_truth(model, spectrum):
    """Density over truth, averaged over the bins of each band."""
    ratio = spectrum.density / model.density(spectrum.frequency, DT, "point")
    inside = [(low <= spectrum.frequency) & (spectrum.frequency < high) for low, high in BANDS_HZ]
    return jnp.stack([jnp.mean(ratio, where=each) for each in inside])


def table(found, records):
    (clusters, overlapping), (plain, mirror) = found
    lines = [
        f"Allan deviation, roll gyro, {records} records: rms error relative to the truth",
        f"{'tau [s]':>10}{'differences':>13}{'clusters':>11}{'overlapping':>13}",
    ]
    for n, one, other in zip(CLUSTERS, clusters, overlapping, strict=True):
        differences = -(-SAMPLES // n) - 1
        lines.append(f"{n * DT:>10g}{differences:>13d}{one:>11.1%}{other:>13.1%}")
    lines += ["", "Power spectral density, the same records: mean over the truth"]
    lines.append(f"{'band [Hz]':>15}{'|X|^2/T':>10}{'mirror':>9}")
    for (low, high), one, other in zip(BANDS_HZ, plain, mirror, strict=True):
        lines.append(f"{f'{low:g} to {high:g}':>15}{one:>10.2f}{other:>9.2f}")
    # The first and the last angle error of a record have no neighbour that takes them back.
    lines.append("From 0.02 to 1 Hz both hold quantization of the record's ends; a fit counts it.")
    return "\n".join(lines)


def draw(axes, folder):
    """One figure a curve, a panel an axis."""
    with plt.rc_context(STYLE):
        allan, allan_panels = plt.subplots(2, 3, figsize=(10, 6), sharex=True, layout="constrained")
        psd, psd_panels = plt.subplots(2, 3, figsize=(10, 6), sharex=True, layout="constrained")
        for index, (name, (unit, coefficients)) in enumerate(axes.items()):
            samples = record(coefficients, seed=index)
            curves = allanfit.fit(samples, RATE_HZ).to_dict(name, unit)["channels"][0]["curves"]
            model = standard_model(coefficients)
            _allan_panel(allan_panels.flat[index], samples, curves["allan"], model)
            _psd_panel(psd_panels.flat[index], samples, curves["psd"], model)
            shown = unit.replace("m/s^2", "m/s²")
            squared = f"({shown})²/Hz"
            for panel, label in (
                (allan_panels.flat[index], f"Allan deviation [{shown}]"),
                (psd_panels.flat[index], f"PSD, one-sided [{squared}]"),
            ):
                panel.set(title=name, ylabel=label, xscale="log", yscale="log")
                panel.grid(which="major", color="#E5E5E5", linewidth=0.5)
        for panel in allan_panels[1]:
            panel.set_xlabel("averaging time τ [s]")
        for panel in psd_panels[1]:
            panel.set_xlabel("frequency [Hz]")
        for figure, panels, file in (
            (allan, allan_panels, "paper-allan-deviation.png"),
            (psd, psd_panels, "paper-psd.png"),
        ):
            handles, labels = panels[0, 0].get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
            figure.savefig(folder / file, dpi=150)
            plt.close(figure)


def _allan_panel(panel, samples, curve, model):
    tau = np.array(curve["tau_s"])
    truth = np.sqrt(model.allan_variance(jnp.asarray(tau / DT), DT, "point"))
    low, high = (np.array(edge, float) for edge in curve["band_95"])
    panel.fill_between(tau, low, high, color=ALLANFIT, alpha=0.25, linewidth=0, label="95 % band")
    panel.plot(tau, curve["deviation"], color=ALLANFIT, label="overlapping clusters")
    panel.plot(tau, truth, "--", color=TRUTH, linewidth=1, label="truth")
    deviation = paper_deviation(samples)
    panel.plot(CLUSTERS * DT, deviation, "s-", color=PAPER, markersize=4, label="the paper's way")


def _psd_panel(panel, samples, curve, model):
    raw, averaged = paper_spectrum(samples, None), paper_spectrum(samples)
    panel.plot(raw.frequency, raw.density, color=RAW, linewidth=0.3, label="|X|²/T, raw")
    frequency = np.array(curve["frequency_hz"])
    low, high = (np.array(edge, float) for edge in curve["band_95"])
    panel.fill_between(
        frequency, low, high, color=ALLANFIT, alpha=0.25, linewidth=0, label="95 % band"
    )
    panel.plot(
        frequency,
        curve["density"],
        ".-",
        markersize=3,
        color=ALLANFIT,
        linewidth=0.7,
        label="mirror spectrum",
    )
    truth = model.density(jnp.asarray(frequency), DT, "point")
    panel.plot(
        averaged.frequency,
        averaged.density,
        "s",
        color=PAPER,
        markersize=3,
        label="the paper's way",
    )
    panel.plot(frequency, truth, "--", color=TRUTH, linewidth=1, label="truth")
    # Single ordinates reach far down, where there is nothing to see.
    panel.set_ylim(truth.min() / 30, 30 * truth.max())


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("allanfit-examples"))
    parser.add_argument("--records", type=int, default=200, help="behind the table")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    shorten_compilation(options.output / "compiled")
    axes = printed_coefficients()
    draw(axes, options.output)
    _, roll = axes["roll gyro"]
    print(table(errors(roll, options.records, seed=1), options.records))


if __name__ == "__main__":
    main()
