"""What is said of filters with ripple in their pass band or lobes in their stop band?

    python -m benchmarks.rippled                 # 24 records, four minutes
    python -m benchmarks.rippled --records 100
    python -m benchmarks.rippled --front         # filters in front of the converter
    python -m benchmarks.rippled --floor         # and white noise behind the filter

White noise of N = 1 on a walk of K = 0.0001 to 0.001 a sample, through SciPy's Chebyshev, elliptic
and inverse Chebyshev filters by turns: 3 to 7 poles, a ripple of 0.05 to 1 dB, 40 or 60 dB of
attenuation, and an edge at 0.06 to 0.35 cycles a sample. With `--front` the filter is one at
sixteen times the rate, of which one value in sixteen is kept. With `--floor` white noise of 0.01 to
0.1 of the first is added to the samples.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import cheby1, cheby2, ellip, sosfilt, sosfreqz

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ = 100_000, 100.0
# Records begin when the filter has forgotten that it was empty.
BEFORE = 4_000
FAMILIES = ("Chebyshev", "elliptic", "inverse Chebyshev")


# Of a filter in front of the converter, over that of the samples.
FINE = 16


def draw(
    seed: int, *, front: bool = False, floor: bool = False
) -> tuple[np.ndarray, str, dict[str, float]]:
    """A record, what filtered it, and its order, cut-off [Hz], N and floor [dB] if it has one."""
    rng = np.random.default_rng((79, seed))
    fine = FINE if front else 1
    family, order = FAMILIES[seed % 3], int(rng.integers(3, 8))
    ripple, attenuation = float(rng.choice([0.05, 0.2, 0.5, 1.0])), float(rng.choice([40, 60]))
    edge = 10 ** rng.uniform(-1.2, -0.45)
    if family == "Chebyshev":
        sections = cheby1(order, ripple, 2 * edge / fine, output="sos")
    elif family == "elliptic":
        sections = ellip(order, ripple, attenuation, 2 * edge / fine, output="sos")
    else:
        sections = cheby2(order, attenuation, 2 * edge / fine, output="sos")
    samples = (SAMPLES + BEFORE) * fine
    x = np.sqrt(fine) * rng.standard_normal(samples)
    x += 10 ** rng.uniform(-4, -3) / fine**0.5 * np.cumsum(rng.standard_normal(samples))
    frequency = np.linspace(0, 0.5, 50_001)
    power = np.abs(sosfreqz(sections, 2 * np.pi * frequency / fine)[1]) ** 2
    # N is what is left at zero frequency, where filters of an even order have a valley.
    last = np.flatnonzero(power > power[0] / 2)[-1]
    truth = {"order": order, "cutoff_frequency": RATE_HZ * frequency[last], "N": RATE_HZ**-0.5}
    by = f"{family}, {order} poles, {ripple} dB, {attenuation:.0f} dB, {RATE_HZ * edge:.3g} Hz"
    values = np.asarray(sosfilt(sections, x))[BEFORE * fine :: fine] / np.sqrt(power[0])
    if floor:
        part = 10 ** rng.uniform(-2, -1)
        values = values + part * rng.standard_normal(values.size)
        truth["N"] *= float(np.hypot(1, part))
        truth["floor"] = 20 * float(np.log10(part / np.hypot(1, part)))
        by += f", floor {truth['floor']:.3g} dB"
    return values, by, truth


def main(arguments=None):
    options = record_options(__doc__, 24, arguments, "front", "floor")
    counted = ("cutoff_frequency", "N", *(("floor",) if options.floor else ()))
    rows = {
        family: {"alone": 0, "order": 0, **dict.fromkeys(counted, 0), "of": 0, "worst_N": 1.0}
        for family in FAMILIES
    }
    wrong = []
    for seed in track(range(options.records), console=Console(stderr=True)):
        x, by, truth = draw(seed, front=options.front, floor=options.floor)
        recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
        (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
        effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
        told = {**found["coefficients_after"], **effects.get("low_pass", {})}
        row = rows[FAMILIES[seed % 3]]
        row["of"] += 1
        row["alone"] += set(effects) == {"low_pass"}
        if "order" in told:
            row["order"] += bool(told["order"]["value"] == truth["order"])
        for name in counted:
            if name in told:
                low, high = told[name]["intervals"]["0.95"]
                row[name] += bool(low <= truth[name] <= high)
        part = told["N"]["value"] / truth["N"]
        if abs(np.log(max(part, 1e-9))) > abs(np.log(row["worst_N"])):
            row["worst_N"] = round(max(part, 1e-9), 3)
        if set(effects) != {"low_pass"}:
            wrong.append(f"{seed}, {by}: {', '.join(effects) or 'nothing'}; N {part:.3g} of itself")
    held = " | ".join(f"{name} held".replace("_frequency", "") for name in counted)
    print(f"| filter | and nothing else | order | {held} | of | worst N |")
    print("|---" * (5 + len(counted)) + "|")
    for family, row in rows.items():
        print(f"| {family} | " + " | ".join(str(value) for value in row.values()) + " |")
    print("\n".join(["", *wrong]))
    keep(options, "rippled", rows, otherwise=wrong)


if __name__ == "__main__":
    main()
