"""The simulator against closed forms, the strengths against simulation, the seal, the scorer.

Bounds of statistical checks are four standard deviations or more: fewer than one false alarm in
ten thousand each, and seeds are fixed.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.fft import dct

from benchmarks.concealed._catalogue import INSIDE, OUTSIDE, draw, plans
from benchmarks.concealed._converter import SampleHold
from benchmarks.concealed._device import Device, Surroundings, simulate
from benchmarks.concealed._effect import at_strength
from benchmarks.concealed._key import SealBroken, open_key, seal
from benchmarks.concealed._row import Row
from benchmarks.concealed._score import score
from benchmarks.concealed._slow import Step, WarmUp
from benchmarks.concealed._spectral import GaussMarkov, LowPass, Resonance, Sinusoid
from benchmarks.concealed._strength import (
    basis,
    best_five_terms,
    bins,
    five_terms,
    holding_band,
    information,
)

PLAIN = Surroundings()


def device(averaged=False, samples=32_768, **coefficients):
    coefficients = coefficients or {"Q": 2e-3, "N": 1e-2, "B": 4e-3, "K": 5e-4}
    return Device("test", "u", 10.0, samples, averaged, "fractional", "white", coefficients, 0.0)


def ordinates(data, about):
    """Squares of cosine coefficients as a one-sided density, less mean and slope."""
    time = np.arange(data.size)
    x = data - np.polyval(np.polyfit(time, data, 1), time)
    return dct(x, norm="ortho") ** 2 * 2 * about.dt


def grouped(data, about, features=()):
    grid = bins(about, features)
    power = ordinates(data.astype(float), about)[: grid.first[-1] + grid.count[-1]]
    return grid, np.add.reduceat(power, grid.first) / grid.count


EFFECTS = {
    "nothing": (),
    "relaxation": (GaussMarkov(0.03, 2.0),),
    "resonance": (Resonance(0.03, 2.0, 8.0),),
    "filter": (LowPass(1.5, 2),),
}


@pytest.mark.parametrize("averaged", [False, True])
@pytest.mark.parametrize("name", [*EFFECTS, "relaxations make the flicker"])
def test_spectrum_is_as_computed(name, averaged):
    about, effects = device(averaged), EFFECTS.get(name, ())
    if name not in EFFECTS:
        about = replace(about, flicker="relaxations")
    spectra = []
    for seed in range(3):
        grid, mean = grouped(simulate(about, effects, PLAIN, (5, seed))["data"], about)
        spectra.append(mean)
    density = effects[0].density if effects else lambda d, f: five_terms(d)(f)
    # Twelve bands; the first hundred ordinates, which know the ends of a walk, apart.
    ratio = np.mean(spectra, axis=0) / density(about, grid.frequency)
    for some in np.array_split(np.flatnonzero(grid.first > 100), 12):
        count = grid.count[some].sum()
        error = np.average(ratio[some], weights=grid.count[some]) - 1
        # Narrow bins against the density at their middle: 1 % more.
        assert abs(error) < 4.5 * np.sqrt(2 / (3 * count)) + 0.012


def test_best_five_terms_finds_five_terms():
    about = device()
    grid = bins(about)
    design = basis(about, grid.frequency)
    true = five_terms(about)(grid.frequency)
    np.testing.assert_allclose(best_five_terms(design, true, grid.count), true, rtol=1e-4)
    assert information(about)[1].sum() < 1e-3


def test_strength_of_a_line_is_twice_its_expected_gain():
    about = device(N=1e-2, samples=4096)
    line = at_strength(Sinusoid(1.0, 1.7, 0.3), about, 36.0)
    assert isinstance(line, Sinusoid)
    template = line.amplitude * np.sin(
        2 * np.pi * 1.7 * (np.arange(4096) + 1) * about.dt + line.phase
    )
    gains = []
    for seed in range(100):
        data = simulate(about, (line,), PLAIN, (6, seed))["data"].astype(float)
        variance = about.term("N") ** 2 / about.dt
        gains.append((np.sum(data**2) - np.sum((data - template) ** 2)) / variance)
    # The gain is normal about lambda with variance 4 lambda.
    assert abs(np.mean(gains) - 36) < 4.5 * np.sqrt(4 * 36 / 100)


def test_strength_of_a_relaxation_is_twice_its_expected_gain():
    about = device(N=1e-2, B=3e-3, K=2e-4, samples=32_768)
    effect = at_strength(GaussMarkov(1.0, 2.0), about, 50.0)
    assert effect is not None
    grid = bins(about)
    true = effect.density(about, grid.frequency)
    best = best_five_terms(basis(about, grid.frequency), true, grid.count)
    gains = []
    for seed in range(60):
        _, mean = grouped(simulate(about, (effect,), PLAIN, (7, seed))["data"], about)
        gains.append(np.sum(grid.count * (np.log(best / true) + mean / best - mean / true)))
    spread = np.std(gains) / np.sqrt(len(gains))
    assert abs(np.mean(gains) - 50) < 4.5 * spread
    assert spread < 3


def test_strength_of_a_step_is_that_of_its_best_line():
    """In white noise: h^2/(N^2) times what mean and slope leave of the step, less refitted K."""
    about = device(N=1e-2, samples=20_000)
    effect = Step(1e-3, (1000.0,), 1)
    mean = effect.mean(about)
    time = np.arange(mean.size)
    left = mean - np.polyval(np.polyfit(time, mean, 1), time)
    bound = np.sum(left**2) * about.dt / about.term("N") ** 2
    assert 0.4 * bound < effect.strength(about) < bound


@pytest.mark.parametrize("kind", [*INSIDE, *OUTSIDE], ids=lambda kind: kind.name)
def test_every_effect_is_drawn_at_the_strength_asked(kind):
    concealed = draw((kind,), (8, len(kind.name)))
    answer = concealed.answer()
    (effect,) = answer["effects"]
    assert effect["lambda"] == pytest.approx(
        min(kind.levels, key=lambda level: abs(level - effect["lambda"])), rel=0.05
    )
    assert effect["name"] in effect["accepted"]
    json.dumps(answer)
    if effect["band_hz"]:
        assert 0 < effect["band_hz"][0] < effect["band_hz"][1] <= concealed.device.rate_hz / 2


def test_a_set_is_drawn_as_announced():
    kinds = plans(3, 400)
    assert kinds == plans(3, 400) != plans(4, 400)
    assert sum(not k for k in kinds) == 168
    assert sum(len(k) == 2 for k in kinds) == 40
    assert sum(len(k) == 1 and k[0].outside for k in kinds) == 20


def test_same_seed_same_log_and_repeats_repeat():
    about, effect = device(samples=4096), SampleHold(0.25)
    one, two = (simulate(about, (effect,), PLAIN, (9, 1))["data"] for _ in range(2))
    np.testing.assert_array_equal(one, two)
    share = np.mean(np.diff(one) == 0)
    assert abs(share - 0.25) < 4.5 * np.sqrt(0.25 * 0.75 / 4096)


def test_warm_up_is_located_at_low_frequency():
    about = device()
    grid, contribution = WarmUp(0.02, 500.0, 1).information(about)
    low, high = holding_band(grid, contribution)
    assert high < 5e-3
    inside = (grid.frequency > low * 0.999) & (grid.frequency < high * 1.001)
    assert contribution[inside].sum() >= 0.8 * contribution.sum()


def test_a_changed_key_is_noticed(tmp_path):
    digest = seal(tmp_path, [{"recording": "00000"}])
    assert (tmp_path / "seal.txt").read_text().strip() == digest
    assert open_key(tmp_path) == [{"recording": "00000"}]
    key = tmp_path / "key.json"
    key.write_text(key.read_text().replace("00000", "00001"))
    with pytest.raises(SealBroken, match="changed since it was sealed"):
        open_key(tmp_path)


def entry(effects=(), **truth):
    return {
        "recording": "00000",
        "device": {"profile": "p", "averaged": False, "flicker": "f", "angle": "white"},
        "surroundings": {"temperature": False, "stamps": False, "code_width": 0.0},
        "duration_s": 1000.0,
        "effects": list(effects),
        "coefficients": {"N": 1.0, "B": 1.0, "K": 1.0},
        "inexact": [],
        **truth,
    }


def cause(name="gauss_markov", strength=25.0, **more):
    return {
        "name": name,
        "parameters": {},
        "lambda": strength,
        "line": False,
        "outside": False,
        "accepted": [name],
        "member_lambda": 1e6,
        "band_hz": [1.0, 2.0],
        "times_s": [],
        "scored": {},
        **more,
    }


def said(name=None, probability=0.9, verdict=None, parameters=None, **more):
    effects = (
        [{"name": name, "probability": probability, "parameters": parameters or {}}] if name else []
    )
    verdict = verdict or ("explained" if name else "consistent")
    return {"verdict": verdict, "effects": effects, "mismatch": [], **more}


def test_scorer_by_hand():
    parameter = {"sigma": {"value": 1.0, "intervals": {"0.95": [0.9, 1.1]}}}
    band = [{"domain": "frequency", "low": 1.0, "high": 4.0}]
    rows = [
        Row(entry(), said(), 1.0),
        Row(entry(), said("step"), 1.0),
        Row(
            entry([cause(scored={"sigma": 1.05})]),
            said("gauss_markov", parameters=parameter, mismatch=band),
            1.0,
        ),
        Row(entry([cause()]), said("resonance"), 1.0),
        Row(entry([cause()]), said(), 1.0),
        Row(entry([cause()]), said(verdict="unexplained"), 1.0),
        Row(entry([cause("chirp", 100.0, outside=True)]), said(verdict="unexplained"), 1.0),
        Row(
            entry([cause("sinusoid", 64.0, line=True, scored={"frequency": 5.0})]),
            said("sinusoid", parameters={"frequency": {"value": 5.0005}}),
            9.0,
        ),
        Row(entry([cause("step", 50.0), cause("sinusoid", 64.0)]), said("step"), 1.0),
    ]
    scores = score(rows)
    figure = {f["name"]: f for f in scores["figures"]}
    number = {n["name"]: n["value"] for n in scores["numbers"]}

    def hits(name):
        return figure[name]["hits"], figure[name]["total"]

    assert hits("nothing hidden: raises an alarm") == (1, 2)
    assert hits("found at lambda 25") == (3, 4)
    assert hits("class named, of those found at lambda 25, lines 36") == (1, 3)
    assert hits("... of all at lambda 25, lines 36") == (1, 4)
    assert hits("line found at lambda 64") == (1, 1)
    assert hits("line located, within 1/T or its width") == (1, 1)
    assert hits("outside the catalogue: called unexplained") == (1, 1)
    assert hits("in the catalogue: called unexplained") == (1, 5)
    assert hits("reported band or time meets the true one") == (1, 3)
    assert hits("95 % intervals of effect parameters") == (1, 1)
    assert hits("two causes: both named") == (0, 1)
    assert hits("two causes: at least one named") == (1, 1)
    # Clopper and Pearson: of 1 in 2, the bar ends at 1 - sqrt(0.975) and its mirror image.
    assert figure["nothing hidden: raises an alarm"]["bar_95"] == pytest.approx(
        [1 - np.sqrt(0.975), np.sqrt(0.975)]
    )
    # Five names at 0.9, of which three are right.
    assert number["expected calibration error of probabilities"] == pytest.approx(0.3)
    assert number["overlap of located bands, median IoU in ln f"] == pytest.approx(0.5)
    assert scores["confusion"]["gauss_markov"] == {
        "gauss_markov": 1,
        "resonance": 1,
        "consistent": 1,
        "unexplained": 1,
    }
    assert len(scores["failures"]) == 5
