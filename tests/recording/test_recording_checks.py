"""Findings on samples, each beside healthy samples that must stay silent."""

import numpy as np
import pytest

from allanfit.recording import load
from allanfit.recording._checks import code_width, rails, split
from allanfit.recording._frozen import frozen
from allanfit.recording._spikes import about_spikes

SIZE = 30_000


def white(seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(SIZE)


def low_passed(samples: np.ndarray) -> np.ndarray:
    """Five samples averaged: neighbours are alike, as behind the filter of a real sensor."""
    return np.convolve(samples, np.full(5, 5**-0.5), mode="same")


def drift() -> np.ndarray:
    return 0.02 * np.cumsum(white(4))


def rounded(samples: np.ndarray, width: float) -> np.ndarray:
    return width * np.round(samples / width)


def findings(samples: np.ndarray, archive) -> tuple[str, ...]:
    recording = load(archive(data=samples))
    assert recording.findings == ()
    return recording.channels[0].findings


@pytest.mark.parametrize(
    "samples",
    [
        white(),
        white().astype(np.float32),
        (9.81 + 1e-3 * white()).astype(np.float32),
        (1e-8 * white()).astype(np.float32),
        white() + drift(),
        low_passed(white()),
        rounded(white(), 0.1),
        rounded(white(), 0.5),
        rounded(low_passed(white()), 0.5),
        rounded(white() + drift(), 0.5) + 10,
        np.round(white(), 6),
        np.append(white(), 1e6),
        white() * np.repeat([1.0, 5.0], SIZE // 2),
        3 * np.sin(np.arange(SIZE) / 7) + 0.1 * white(),
        np.round(white() + 0.03 * rounded(white(8), 1.0), 4),
        white()[:256],
    ],
    ids=[
        "float64",
        "float32",
        "float32 on gravity",
        "tiny",
        "drift",
        "low-pass",
        "fine codes",
        "codes of half the noise",
        "codes and low-pass",
        "codes and drift",
        "six decimals",
        "one wild value",
        "variance doubled",
        "line",
        "mixed codes",
        "short",
    ],
)
def test_healthy_samples_are_silent(samples, archive):
    assert findings(samples, archive) == ()


@pytest.mark.parametrize("width", [1e-9, 0.5])
def test_spikes_are_neither_rails_nor_repeats(width, archive):
    spikes = 8 * (np.random.default_rng(5).random(SIZE) < 0.05) * white(6)
    (finding,) = findings(rounded(white() + spikes, width), archive)
    assert "stand alone" in finding
    assert "all of exactly" not in finding


@pytest.mark.parametrize("width", [1e-9, 0.05])
def test_a_dead_band_is_no_slow_sensor(width, archive):
    x = rounded(white(), width)
    (finding,) = findings(np.where(np.abs(x) < 0.3, 0.0, x), archive)
    assert "of the samples are exactly 0 deg/s" in finding
    assert "dead band" in finding


@pytest.mark.parametrize("repeat", [1.05, 2, 3, 10, 100])
def test_held_samples_are_found(repeat, archive):
    held = white()[(np.arange(SIZE) / repeat).astype(int)]
    (finding,) = findings(held, archive)
    assert "of the samples repeat the one before, where chance explains" in finding
    assert "read faster than it gives fresh values" in finding
    stated = float(finding.removeprefix("over ").split(" %")[0])
    assert stated == pytest.approx(100 * (1 - 1 / repeat), rel=0.02, abs=0.3)


def test_few_values_that_fill_in_for_lost_ones_are_counted(archive):
    """Sixty of noise with codes of a billionth, of which chance makes no two alike."""
    filled = rounded(white(), 1e-9)
    at = np.arange(1, 61) * (SIZE // 80)
    filled[at] = filled[at - 1]
    (finding,) = findings(filled, archive)
    assert finding.startswith(f"60 of the {SIZE} samples are exactly the one before")
    # Half as many neighbours are alike by rounding to a ten-thousandth, and nothing is said.
    assert findings(rounded(white(), 1e-4), archive) == ()


def test_held_samples_are_found_among_coarse_codes(archive):
    held = rounded(white()[np.arange(SIZE) // 2], 0.7)
    (finding,) = findings(held, archive)
    assert "read faster" in finding


@pytest.mark.parametrize("held", [False, True])
def test_codes_that_a_converter_misses_are_not_held(held, archive):
    """Every eighth code is the one below: neighbours are equal more often, and all others too."""
    codes = np.floor(white()[np.arange(SIZE) // (1 + held)] / 0.4)
    codes[codes % 8 == 7] -= 1
    assert any("read faster" in finding for finding in findings(0.4 * codes, archive)) is held


@pytest.mark.parametrize("width", [1.1, 2.2, 4.4])
def test_a_code_width_as_large_as_the_noise(width, archive):
    (finding,) = findings(rounded(white(), width), archive)
    assert finding.startswith(f"The code width, {width:.3g} deg/s, is ")
    assert finding.endswith("before: rounding changes N, and `allanfit explain` tells by how much.")


def test_a_code_met_once_in_a_thousand_samples(archive):
    samples = np.zeros(SIZE)
    samples[500::1000] = 0.1
    (finding,) = findings(samples, archive)
    assert finding == (
        "The code width, 0.1 deg/s, is larger than the noise, and over 99 % of the samples repeat "
        "the one before: rounding hides part of the noise."
    )


def test_a_single_step_between_two_values(archive):
    (finding,) = findings(np.repeat([0.0, 0.1], 500), archive)
    assert "The code width, 0.1 deg/s, is larger than the noise" in finding


@pytest.mark.parametrize("width", [1e-3, 0.05, 1.0])
def test_the_code_width(width):
    assert code_width(rounded(white(), width)) == pytest.approx(width, rel=1e-9)
    assert code_width(np.float64(np.float32(rounded(white(), width) + 9.8))) == pytest.approx(
        width, rel=1e-3
    )
    assert code_width(np.zeros(500)) == 0.0
    assert code_width(white()) < 0.01


def test_the_code_width_of_two_codes_in_a_long_recording():
    # Two codes by turns: any even stride would meet only one of them.
    assert code_width(np.tile([0.0, 0.3], 400_000)) == pytest.approx(0.3)


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize("width", [None, 0.05])
def test_saturation_is_found_on_each_rail(both, width, archive):
    samples = white() if width is None else rounded(white(), width)
    told = findings(np.clip(samples, -1.5 if both else None, 1.5), archive)
    assert len(told) == 1 + both
    assert told[-1].endswith("at the extreme value 1.5 deg/s: the output was saturated.")
    assert told[-1].startswith(("6.7 %", "6.8 %", "6.9 %", "7 %", "7.1 %"))


@pytest.mark.parametrize("rail", [1.9, 2.63])
def test_a_rail_between_two_codes(archive, rail):
    samples = np.minimum(rounded(white(), 0.25), rail)
    (told,) = findings(samples, archive)
    assert told.endswith(f"at the extreme value {rail} deg/s: the output was saturated.")


def test_broken_values_split_and_short_stretches_are_left_out(archive):
    samples = white()
    samples[[1_000, 1_010, 20_000]] = [np.nan, np.inf, -np.inf]
    recording = load(archive(data=samples))
    assert recording.channels[0].stretches == ((0, 1_000), (1_011, 20_000), (20_001, SIZE))
    assert recording.channels[0].findings == (
        "Left out as missing or not finite: 3 samples (0.03 s); the longest stretch between has "
        "189.9 s.",
        "Left out in stretches shorter than 16 samples: 9 samples (0.09 s).",
    )


def test_split_at_breaks_and_at_both_ends():
    finite = np.ones(100, dtype=bool)
    assert split(finite, ()) == ((0, 100),)
    assert split(finite, (40,)) == ((0, 40), (40, 100))
    assert split(finite, (10, 90)) == ((10, 90),)
    finite[[0, 40, 99]] = False
    assert split(finite, ()) == ((1, 40), (41, 99))
    assert split(finite, (40, 60)) == ((1, 40), (41, 60), (60, 99))
    assert split(np.zeros(100, dtype=bool), (50,)) == ()


@pytest.mark.parametrize(("clipped", "found"), [(30, True), (5, True), (1, False)])
def test_a_few_samples_on_a_rail_are_enough(clipped, found):
    """Five of 400,000 equal extremes are a converter's end; noise has one of each."""
    x = np.random.default_rng(3).standard_normal(400_000)
    rail = np.sort(x)[-clipped]
    ends = rails(np.minimum(x, rail), 1e-9)
    assert ends == ((rail,) if found else ())


@pytest.mark.parametrize("number", [3, 90])
def test_what_a_logger_fills_in_is_no_rail(number, archive):
    """Zeros where gravity is measured; N follows from the mean square of second differences."""
    x = 9.8 + 0.02 * white()
    places = np.random.default_rng(1).permutation(SIZE // 40)[:number] * 40 + 20
    filled = x.copy()
    filled[places] = 0.0
    assert rails(filled, 1e-9) == ()
    (told,) = findings(filled, archive)
    assert f"{number} samples (" in told
    assert "all of exactly 0" in told
    ratio = np.std(np.diff(filled, 2)) / np.std(np.diff(x, 2))
    assert f"{ratio:.3g} times" in told


@pytest.mark.parametrize("levels", [(-40.0, 40.0), (40.0,)])
def test_spikes_that_are_cut_off_stand_at_a_rail(levels):
    """At both ends, or at one that some do not reach."""
    x = white()
    places = np.random.default_rng(1).permutation(SIZE)[:60]
    heights = 60 * np.random.default_rng(2).standard_normal(60)
    x[places] += heights if len(levels) == 2 else np.abs(heights)
    assert rails(np.clip(x, -40, 40), 1e-9) == levels


@pytest.mark.parametrize("what", ["steps", "knocks", "tails", "few"])
def test_what_does_not_stand_alone_is_no_spike(what):
    x = white()
    if what == "steps":
        x += 100 * (np.arange(SIZE) // 5_000 % 2)
    elif what == "knocks":
        ring = 40 * np.exp(-np.arange(200) / 50) * np.sin(np.arange(200))
        for at in (3_000, 9_000, 20_000):
            x[at : at + 200] += ring
    elif what == "tails":
        x = np.random.default_rng(3).laplace(size=SIZE)
    else:
        x[[5_000, 9_000]] += 9
    assert about_spikes(x, "m/s^2") == ()


@pytest.mark.parametrize("width", [0.1, 0.5])
def test_rounded_noise_has_no_rails(width):
    for seed in range(40):
        x = np.round(np.random.default_rng(seed).standard_normal(20_000) / width) * width
        assert rails(x, width) == ()


def test_counts_of_none_and_one_have_no_rails():
    """An angle that is read faster than it turns by a code, as a laser gyro's."""
    angle = np.cumsum(0.2 + 0.03 * np.random.default_rng(8).standard_normal(20_000))
    counts = np.diff(np.floor(angle))
    assert set(counts) == {0.0, 1.0}
    assert rails(counts, 1.0) == ()
    # Differences of what was scaled before are equal to some digits.
    assert rails(np.diff(np.floor(angle) * 2e-6) * 200, 4e-4) == ()


def test_codes_beside_a_wave_have_no_rails():
    """A wave stays longest where it turns, so that the last codes have many samples."""
    wave = 5 * np.sin(2 * np.pi * 0.0123 * np.arange(SIZE))
    for noise in (0.5, 1.0):
        assert rails(np.round(wave + noise * white()), 1.0) == ()


@pytest.mark.parametrize(("level", "width"), [(1.6, 0.4), (1.0, 0.25), (-1.6, 0.4)])
def test_a_rail_among_coarse_codes(level, width):
    """The last code has less than three times as many samples as the one before it."""
    x = white()
    clipped = np.minimum(x, level) if level > 0 else np.maximum(x, level)
    ends = rails(np.round(clipped / width), 1.0)
    assert ends == (np.round(level / width),)


def test_coarse_codes_of_healthy_sensors_have_no_rails():
    """Tails that fall more slowly, that wander, and that belong to several levels."""
    rng = np.random.default_rng(5)
    time = np.arange(SIZE)
    for noise in (1.0, 2.0, 4.0):
        steady = noise * white()
        for healthy in (
            steady + noise * 0.03 * np.cumsum(rng.standard_normal(SIZE)),
            steady + 6 * noise * (time > SIZE / 3),
            steady + 9 * np.sin(2 * np.pi * 0.0123 * time),
            steady * np.where(time % 50 == 0, 5, 1),
            noise * rng.laplace(size=SIZE),
        ):
            assert rails(np.round(healthy), 1.0) == ()


@pytest.mark.parametrize(
    ("samples", "width"),
    [
        (np.empty(0), 0.0),
        (np.array([3.0]), 0.0),
        (np.array([3.0, 4.0]), 1.0),
        (np.arange(200_000) * 0.5, 0.5),
        (np.append(np.arange(50_000.0), 1e9), 1.0),
        (np.round(30 * np.cumsum(white())), 1.0),
    ],
    ids=["none", "one", "two", "ramp", "ramp and a wild value", "wandering far"],
)
def test_the_code_width_of_any_samples(samples, width):
    assert code_width(samples) == width


def test_noise_that_wanders_far_has_no_codes():
    """Values that are evenly dense, without a step that would be wide for their range."""
    assert code_width(np.cumsum(np.random.default_rng(1).standard_normal(200_000))) < 0.01


def test_frozen_samples_are_left_out(archive):
    """A sensor that hangs, and a logger that fills up with zeros: the first of each is measured."""
    samples = white() + 3
    samples[5_000:5_200] = samples[5_000]
    samples[20_000:21_000] = 0.0
    recording = load(archive(data=samples))
    assert recording.channels[0].stretches == ((0, 5_001), (5_200, 20_001), (21_000, SIZE))
    (told,) = recording.channels[0].findings
    assert told.startswith("Left out as frozen: 1198 samples in 2 runs (12 s) repeat one value")


def slow(samples: np.ndarray, codes: float) -> np.ndarray:
    """A drift of a few codes beside little noise: each code lasts."""
    return rounded(drift() + 0.02 * samples, codes)


@pytest.mark.parametrize(
    "samples",
    [
        np.repeat(white()[:300], 100),
        white()[np.cumsum(np.random.default_rng(5).random(SIZE) < 0.04)],
        slow(white(), 0.2),
        rounded(white(), 4.0),
        np.clip(white() + 4 * np.sin(np.arange(SIZE) / 3000), -3, 3),
        drift()[SIZE // 2] + np.where(np.arange(SIZE) < 60, 0, white()),
    ],
    ids=["held by a clock", "held at random", "slow", "coarse", "at rails", "briefly"],
)
def test_what_repeats_for_another_reason_is_not_frozen(samples):
    assert not frozen(samples).any()


def test_values_of_many_sizes_are_read(archive):
    """Codes of the smallest step would be more than memory holds."""
    rng = np.random.default_rng(6)
    load(archive(data=rng.standard_normal(SIZE) * 10.0 ** rng.uniform(-20, 20, SIZE)))
