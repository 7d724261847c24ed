"""Output that wraps around is refused, and what looks like it is not."""

import numpy as np
import pytest

import allanfit
from allanfit.recording import RecordingError, load, read_in_blocks
from allanfit.recording._wraps import why_wraps, wrap

SIZE = 20_000
RNG = np.random.default_rng(21)
WHITE = RNG.standard_normal(SIZE)
# Behind a filter, and with a bias that wanders.
FILTERED = np.convolve(WHITE, np.full(5, 5**-0.5), "same")
DRIFTING = WHITE + 0.05 * np.cumsum(RNG.standard_normal(SIZE))
# Which of two levels is on, for long times.
LEVEL = np.cumsum(RNG.random(SIZE) < 0.01) % 2


def wrapped(noise: np.ndarray, bits: int, sigma: float, mean: float) -> np.ndarray:
    """Codes of noise about `mean` standard deviations below the upper end of the range."""
    half = 2 ** (bits - 1)
    return (np.round(half + sigma * (noise - mean)) + half) % 2**bits - half


def fill(codes: np.ndarray, bits: int, levels: np.ndarray) -> np.ndarray:
    """The same codes, at two levels so far apart that the range has 2**bits of them."""
    low, high = codes[levels == 0].min(), codes[levels == 1].max()
    return codes + levels * (2**bits - 1 - (high - low))


@pytest.mark.parametrize("scale", [1.0, 0.1, 9.80665 / 16384, 1 / 131])
@pytest.mark.parametrize(("bits", "sigma"), [(12, 30), (16, 300), (24, 2000), (24, 300_000)])
@pytest.mark.parametrize("noise", [WHITE, FILTERED, DRIFTING], ids=["white", "filtered", "drift"])
@pytest.mark.parametrize("mean", [0.0, 1.5, -2.0])
def test_the_period_is_found_in_any_unit(scale, bits, sigma, noise, mean):
    found = wrap(scale * wrapped(noise, bits, sigma, mean))
    assert found is not None
    assert found.bits == bits
    assert found.period == pytest.approx(scale * 2**bits, rel=1e-9)


def test_unsigned_codes_wrap_around_at_zero():
    found = wrap(np.round(200 * WHITE) % 2**16)
    assert found is not None
    assert found.period == 2**16


def test_what_is_unwrapped_as_told_is_the_noise():
    codes = wrapped(WHITE, 16, 300, 1.0)
    found = wrap(codes)
    assert found is not None
    plain = np.unwrap(codes, period=found.period)
    assert np.std(plain) == pytest.approx(300, rel=0.02)
    assert wrap(plain) is None


BESIDE = {
    "white": np.round(1000 * WHITE),
    "white that spans 2^12 codes": np.round(4095 / np.ptp(WHITE) * (WHITE - WHITE.min())),
    "white wider than the range": np.round(700 * WHITE) % 4096 - 2048,
    "telegraph": fill(np.round(300 * WHITE), 16, LEVEL),
    "telegraph among coarse codes": fill(np.round(0.7 * WHITE), 8, LEVEL),
    "telegraph of even noise": fill(np.round(600 * RNG.random(SIZE)), 16, LEVEL),
    "steps": fill(np.round(300 * WHITE), 16, np.arange(SIZE) // 2500 % 2),
    "two values": 255.0 * LEVEL,
    "saturated": np.clip(np.round(60_000 * WHITE), -32768, 32767),
    "saturated by a square wave": np.clip(
        np.round(300 * WHITE) + 65_400 * (LEVEL - 0.5), -32768, 32767
    ),
    "spikes of both signs at the rails": np.where(
        RNG.random(SIZE) < 0.02, RNG.choice([-32768.0, 32767.0], SIZE), np.round(300 * WHITE)
    ),
    "spikes": np.round(300 * WHITE) + np.round(2e4 * (RNG.random(SIZE) < 0.02) * FILTERED),
    "a value for what is missing": np.where(
        RNG.random(SIZE) < 0.02, -32768.0, np.round(300 * (WHITE - WHITE.max())) + 32767
    ),
    "coarse": np.round(0.4 * WHITE),
    "bit at one": (np.round(300 * WHITE).astype(int) | 256).astype(float),
    "bit at zero": (np.round(300 * WHITE).astype(int) & ~4).astype(float),
    "bit that flips": (
        np.round(300 * WHITE).astype(int) ^ ((RNG.random(SIZE) < 0.01).astype(int) << 14)
    ).astype(float),
    "angle": np.round(np.cumsum(300 * WHITE)),
    "angle of 360 degrees": np.round(np.cumsum(3 * WHITE) % 360, 2),
    "wave over the range": np.round(32767 * np.sin(2.9 * np.arange(SIZE))),
    "no codes": DRIFTING,
    "short": WHITE[:2],
    "none": WHITE[:0],
}


@pytest.mark.parametrize("scale", [1.0, 1 / 131])
@pytest.mark.parametrize("kind", BESIDE)
def test_nothing_else_wraps_around(kind, scale):
    assert why_wraps(scale * BESIDE[kind]) == ""


def test_noise_at_levels_that_fill_a_range_does_not():
    """Of 200 telegraphs whose range is made to be 2^k codes none is refused."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        size = int(rng.choice([1000, 5000]))
        noise = np.round(np.exp(rng.uniform(-1, 5)) * rng.standard_normal(size))
        levels = np.cumsum(rng.random(size) < rng.choice([0.5, 0.05, 0.01])) % 2
        assert wrap(fill(noise, int(rng.choice([12, 16])), levels)) is None


def test_the_channel_is_refused_with_what_to_do(archive, tmp_path):
    codes = 0.1 * wrapped(WHITE, 16, 300, 1.5)
    message = (
        r"data cannot be analysed: its output wraps around: \d+ times it jumps by 65536 codes "
        r"\(6.55e\+03 deg/s\) from one end of its range to the other; .* "
        r"numpy.unwrap\(samples, period=6553.6\)"
    )
    path = archive(data=codes)
    with pytest.raises(RecordingError, match=message):
        load(path)
    with pytest.raises(RecordingError, match=message):
        read_in_blocks(path)
    with pytest.raises(RecordingError, match=message):
        allanfit.recording_of(codes, rate_hz=100.0, unit="deg/s")
    with pytest.raises(ValueError, match=r"data cannot be analysed: its output wraps around"):
        allanfit.fit(codes, 100.0)


def test_among_other_channels_it_is_left_out(archive):
    recording = load(archive(gyro_x=WHITE, gyro_y=wrapped(WHITE, 16, 300, 1.5)))
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    assert any(
        each.startswith("The channel gyro_y is left out: its output wraps around")
        for each in recording.findings
    )
