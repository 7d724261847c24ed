"""Are explain's chances true? The evidence for each effect in records with nothing left out.

    python -m benchmarks.chances [--records 300] [--samples 32768] [--seed 1]

Each record is a device of `benchmarks.concealed` without any effect. For every effect of the
catalogue the first round of the search says what it would gain and how likely chance is to gain as
much; the table sets the share of records below .05, .01 and .001 beside what those should be, and
gives the gains that chance exceeds as rarely. It goes on where it stopped.
"""

import argparse
import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
from rich.progress import track

from allanfit.curves import unit_scale
from allanfit.explain._chance import log_chance
from allanfit.explain._investigate import ALARM
from allanfit.explain._options import smooth_options
from allanfit.explain._state import begin
from allanfit.explain.courses._options import course_options
from allanfit.explain.lines._taken import line_options
from allanfit.explain.spectrum._search import bumps
from allanfit.explain.strength._lasting import about_spread
from allanfit.explain.values._rounded import about_format
from allanfit.identify import fit_series

from .concealed._device import Surroundings, draw_device, simulate

RESULTS = Path(__file__).parent / "results" / "chances"
LEVELS = (0.05, 0.01, 0.001)


def evidence(seed: int, index: int, samples: int) -> dict:
    """Gain and log chance of each effect in one record."""
    rng = np.random.default_rng((seed, 0, index))
    device = replace(draw_device(rng), samples=samples)
    log = simulate(device, (), Surroundings(temperature=True), (seed, 1, index))
    x = log["data"].astype(float)
    fit = fit_series(x, device.rate_hz)
    scale = np.asarray(unit_scale(device.dt))
    values = np.array(list(map(float, fit.coefficients.values()))) / scale
    state = begin(x, ((0, samples),), "point", values[:4] ** 2, ALARM)
    about_format(state)
    about_spread(state, 0)
    felt = log["temperature"] - log["temperature"].mean()
    best: dict[str, tuple[float, float]] = {}
    drivers = {"temperature": felt[:, None].astype(float)}
    options = line_options(state) + smooth_options(state) + course_options(state, drivers)
    for option in (each for each in options if np.isfinite(each.log_p)):
        old = best.get(option.name, (0.0, 0.0))
        best[option.name] = max(old[0], option.gain), min(old[1], option.log_p)
    for bump in bumps(state.model, state.data):
        best[bump.name] = bump.gain, log_chance(bump.name, bump.gain)
    for witness in state.witnesses:
        if witness["name"] != "lines":
            best[witness["name"]] = (0.0, float(np.log(max(witness["p_value"], 1e-300))))
    return {"profile": device.profile, "evidence": best}


def table(rows: list[dict]) -> str:
    """Shares and quantiles by effect; an effect that was not proposed counts as no evidence."""
    found = defaultdict(list)
    for row in rows:
        for name, (gain, log_p) in row["evidence"].items():
            found[name].append((gain, np.exp(log_p)))
    count = len(rows)
    head = "".join(f" p < {level:g} |" for level in LEVELS)
    lines = [f"| effect |{head} gain at .05 | .01 | largest |", "|---" * 7 + "|"]
    for name, pairs in sorted(found.items()):
        gains = np.zeros(count)
        gains[: len(pairs)] = [gain for gain, _ in pairs]
        shares = "".join(f" {sum(p < a for _, p in pairs) / count:.4f} |" for a in LEVELS)
        ends = np.quantile(gains, [0.95, 0.99])
        lines.append(f"| {name} |{shares} {ends[0]:.1f} | {ends[1]:.1f} | {gains.max():.1f} |")
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=300)
    parser.add_argument("--samples", type=int, default=32_768)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--again", action="store_true", help="forget earlier results")
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    RESULTS.mkdir(parents=True, exist_ok=True)
    file = RESULTS / f"{asked.seed}-{asked.samples}.jsonl"
    if asked.again:
        file.unlink(missing_ok=True)
    done = len(file.read_text().splitlines()) if file.exists() else 0
    with file.open("a") as stream:
        for index in track(range(done, asked.records)):
            stream.write(json.dumps(evidence(asked.seed, index, asked.samples)) + "\n")
            stream.flush()
    rows = [json.loads(line) for line in file.read_text().splitlines()][: asked.records]
    print(f"{len(rows)} records of {asked.samples} samples, seed {asked.seed}\n")
    print(table(rows))


if __name__ == "__main__":
    main()
