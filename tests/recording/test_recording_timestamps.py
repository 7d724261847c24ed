"""Time stamps: late ones told from lost ones, units, and rates that disagree."""

import re

import numpy as np
import pytest

from allanfit.recording import RecordingError, load
from allanfit.recording._timestamps import is_time, read_clock

EVEN = np.arange(20_000) / 100


def clock(stamps, *, name="time_s", unit="", given_hz=None):
    return read_clock(np.asarray(stamps), name, unit, given_hz)


def random() -> np.random.Generator:
    return np.random.default_rng(7)


@pytest.mark.parametrize(
    "stamps",
    [
        EVEN,
        EVEN[:256],
        EVEN + 1.7e9,
        EVEN.astype(np.float32),
        EVEN + 2e-4 * random().standard_normal(EVEN.size),
        EVEN * (1 + 2e-4 * np.sin(EVEN / 50)),
        np.append(EVEN, EVEN[-1] + 3),
    ],
    ids=["even", "short", "since 1970", "float32", "slight jitter", "drift", "late last packet"],
)
def test_healthy_stamps_are_silent(stamps):
    told = clock(stamps)
    assert (told.breaks, told.findings) == ((), ())
    assert told.rate_hz == pytest.approx(100, rel=3e-4)


def test_stamps_rounded_to_milliseconds_still_give_the_rate():
    told = clock((np.arange(20_000) / 95.2).round(3))
    assert told.rate_hz == pytest.approx(95.2, rel=1e-5)
    assert told.findings == ()


@pytest.mark.parametrize("lost", [0.0, 0.005, 0.05])
@pytest.mark.parametrize(
    ("rate_hz", "digits"),
    [(59.5, 3), (104, 3), (119, 3), (416, 3), (500, 3), (49.9, 2), (833, 6), (1660, 6)],
)
def test_losses_are_counted_where_stamps_are_rounded_up_to_half_an_interval(rate_hz, digits, lost):
    """Singly and in short runs, at rates of which the interval is no whole number of steps."""
    kept = random().random(100_000) >= lost
    if lost:
        for start in range(500, kept.size - 500, 5_000):
            kept[start : start + 4] = False
    told = clock((np.flatnonzero(kept) / rate_hz + 0.0123).round(digits))
    assert told.breaks == ()
    assert told.rate_hz == pytest.approx(rate_hz, rel=1e-5)
    assert told.lost == pytest.approx(1 - kept.mean(), abs=2e-5)


@pytest.mark.parametrize(
    ("name", "unit", "scale"),
    [
        ("time", "s", 1),
        ("Time", "", 1),
        ("time_s", "", 1),
        ("t", "ms", 1e3),
        ("T_ms", "", 1e3),
        ("timestamp", "us", 1e6),
        ("timestamp", "\N{MICRO SIGN}s", 1e6),
        ("timestamp_us", "", 1e6),
        ("time", "ns", 1e9),
        ("TIMESTAMP_NS", "", 1e9),
        ("time", "sec", 1),
    ],
)
def test_units_of_stamps(name, unit, scale):
    told = clock(EVEN * scale, name=name, unit=unit)
    assert told.rate_hz == pytest.approx(100)
    assert told.findings == ()


@pytest.mark.parametrize(("unit", "scale"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_a_unit_that_nobody_gave_is_inferred_and_said(unit, scale):
    told = clock(EVEN * scale, name="timestamp")
    assert told.rate_hz == pytest.approx(100)
    assert len(told.findings) == 1
    assert f"taken to be in {unit}, since" in told.findings[0]
    assert f"`timestamp [{unit}]`" in told.findings[0]


@pytest.mark.parametrize("origin", [46348 + 1 / 3, 35_000.0, 739_942.25])
def test_days_of_spreadsheets_are_told_and_said(origin):
    stamps = np.round(origin + EVEN / 86_400, 10)
    told = clock(stamps, name="Time")
    assert told.rate_hz == pytest.approx(100, rel=1e-6)
    assert "taken to be in days, as spreadsheets count them: they are about" in told.findings[0]
    stamps[[5, 7]] = np.nan
    assert clock(stamps, name="Time").rate_hz == pytest.approx(100, rel=1e-6)


def test_seconds_of_the_size_of_days_stay_seconds():
    assert clock(46_348 + EVEN, name="time").findings == ()
    assert clock(46_348 + EVEN / 100, name="time").rate_hz == pytest.approx(10_000)
    assert clock(46_348_000 + EVEN * 1000, name="time").rate_hz == pytest.approx(100)


def test_a_known_rate_decides_between_units():
    seconds = np.arange(5_000.0)
    assert clock(seconds, name="time", given_hz=1.0).rate_hz == 1.0
    assert clock(seconds, name="time", given_hz=1.0).findings == ()
    assert clock(seconds, name="time", given_hz=1000.0).rate_hz == 1000.0


@pytest.mark.parametrize("dtype", [np.int64, np.uint64])
def test_nanoseconds_since_1970_keep_their_digits(dtype):
    stamps = np.arange(5_000, dtype=dtype) * dtype(1_234_567) + dtype(1_700_000_000_123_456_789)
    assert clock(stamps, unit="ns").rate_hz == pytest.approx(1e9 / 1_234_567, rel=1e-8)


def test_a_gap_cuts_and_is_said():
    told = clock(np.delete(EVEN, slice(5_000, 5_300)))
    assert (told.rate_hz, told.breaks) == (100.0, (5_000,))
    assert told.findings == (
        "The time stamps have a gap of 3.01 s at 49.99 s: about 300 samples are missing there, and "
        "nothing is put in place.",
    )


def test_many_gaps_are_all_found():
    stamps, starts = EVEN.copy(), 100 + 390 * np.arange(50)
    lengths = random().uniform(0.5, 60, starts.size)
    for start, length in zip(starts, lengths, strict=True):
        stamps[start:] += length
    told = clock(stamps)
    assert told.breaks == tuple(starts)
    assert told.rate_hz == pytest.approx(100, rel=1e-6)
    assert "have 50 gaps" in told.findings[0]
    assert f"the longest {lengths.max() + 0.01:.4g} s at" in told.findings[0]


@pytest.mark.parametrize("jitter", [0.0, 0.02, 0.05])
def test_losses_are_counted_in_whole_samples_however_stamps_scatter(jitter):
    """Single samples and runs of up to nine; the scatter is that part of an interval."""
    rng = np.random.default_rng(4)
    kept = rng.random(EVEN.size) > 0.004
    for start in range(500, EVEN.size - 500, 1_000):
        kept[start : start + rng.integers(2, 10)] = False
    stamps = EVEN + jitter * 0.01 * rng.standard_normal(EVEN.size)
    told = clock(stamps[kept])
    assert told.rate_hz == pytest.approx(100, rel=2e-5)
    assert told.lost == pytest.approx(1 - np.mean(kept), rel=0.01)


def test_longer_losses_are_among_the_lost_where_single_ones_are():
    kept = np.ones(EVEN.size, bool)
    kept[1_000:1_030] = False
    assert clock(EVEN[kept]).lost == 0.0
    kept[5_000] = False
    assert clock(EVEN[kept]).lost == pytest.approx(31 / EVEN.size, rel=1e-3)


@pytest.mark.parametrize("fraction", [0.001, 0.01, 0.1])
def test_single_losses_are_counted_and_do_not_cut(fraction):
    lost = random().choice(np.arange(1, EVEN.size - 50), round(fraction * EVEN.size), replace=False)
    told = clock(np.delete(EVEN, lost))
    assert told.breaks == ()
    assert told.rate_hz == pytest.approx(100, rel=1e-4)
    (finding,) = told.findings
    counted = int(re.search(r"a few at a time: (\d+) sample", finding)[1])
    assert counted == pytest.approx(lost.size, abs=2)
    after, numbers = np.array(told.losses).T
    place = np.arange(EVEN.size - lost.size)
    place += np.cumsum(np.bincount(after, numbers, minlength=place.size)).astype(int)
    assert np.array_equal(place[:-50], np.delete(np.arange(EVEN.size), lost)[:-50])


def late(stamps: np.ndarray) -> np.ndarray:
    """A computer that stamps samples when it reads them, up to 0.6 s late and then all at once."""
    read = np.sort(random().uniform(0, EVEN[-1], 300))
    held = stamps.copy()
    for start in read:
        busy = (stamps >= start) & (stamps < start + 0.6)
        held[busy] = np.maximum(held[busy], start + 0.6)
    return held


@pytest.mark.parametrize(
    ("stamps", "rel"),
    [
        (np.repeat(EVEN[::5], 5), 1e-3),
        (np.repeat(EVEN[::200], 200), 2e-2),
        (np.repeat(EVEN[::16], 16) + np.tile(1e-4 * np.arange(16), EVEN.size // 16), 2e-3),
        (EVEN + 3e-3 * random().standard_normal(EVEN.size), 1e-3),
        (late(EVEN), 1e-3),
    ],
    ids=["repeats", "long bursts", "buffered", "jitter", "late"],
)
def test_uneven_stamps_are_no_gaps(stamps, rel):
    told = clock(stamps)
    assert told.breaks == ()
    assert told.rate_hz == pytest.approx(100, rel=rel)
    assert "the samples are taken as evenly spaced." in told.findings[-1]


def test_a_gap_among_bursts_is_found():
    told = clock(np.delete(np.repeat(EVEN[::5], 5), slice(5_002, 5_302)))
    assert told.breaks == (5_002,)
    assert told.rate_hz == pytest.approx(100, rel=1e-3)


def test_stamps_set_back():
    stamps = EVEN.copy()
    stamps[9_000:] -= 30
    told = clock(stamps)
    assert told.breaks == (9_000,)
    assert told.rate_hz == pytest.approx(100)
    assert told.findings == (
        "The time stamps step backward 1 time, far enough to cut the recording there 1 time.",
    )


@pytest.mark.parametrize("rate_hz", [5, 50, 95.2, 100, 104, 1_000, 1_660])
@pytest.mark.parametrize("seconds", [15.4, 90.7, 300])
def test_stamps_in_whole_seconds_give_the_rate(rate_hz, seconds):
    """Within a sample at either end, wherever in a second the recording begins and ends."""
    stamps = np.floor(np.arange(round(seconds * rate_hz)) / rate_hz + 0.37)
    told = clock(stamps, unit="s")
    assert told.rate_hz == pytest.approx(rate_hz, rel=1 / (rate_hz * (seconds - 3)))
    assert told.breaks == ()
    about = f"the others are 1000 ms later, and the mean interval is {1e3 / told.rate_hz:.4g} ms; "
    assert about in told.findings[0]
    within = float(re.search(r"The rate is known to within (.*) %\.", told.findings[0])[1])
    assert abs(told.rate_hz / rate_hz - 1) <= within / 100 < 2 / (rate_hz * (seconds - 3))


def test_breaks_of_a_coarse_clock_make_its_rate_less_sure():
    stamps = np.floor(EVEN)
    stamps[7_050:] -= 60
    (order, uneven) = clock(stamps).findings
    assert "step backward 1 time, far enough to cut" in order
    assert "known to within 0.51 %" in uneven


def test_stamps_of_busy_moments_are_no_coarse_clock():
    """Most of these repeat, and the new ones are as late as the busy moments are long."""
    assert "known to within" not in clock(late(EVEN)).findings[-1]


MIDDLE = 7_000


def wrong(by, at=MIDDLE, stamps=EVEN):
    """Stamps of which one, or some, are off by so many seconds."""
    stamps = stamps.copy()
    stamps[at] += by
    return stamps


def reordered(*rows):
    order = np.arange(EVEN.size)
    order[np.concatenate(rows)] = np.concatenate(rows[::-1])
    return EVEN[order]


def about(number, first, off):
    one = number == 1
    return (
        f"{number} time stamp{' does' if one else 's do'} not fit those before and after, damaged "
        f"or of rows out of order: {'at' if one else 'the first at'} sample {first}, off by {off} "
        "s. The samples stay in the order of the file, at the times that the other stamps tell.",
    )


@pytest.mark.parametrize(
    ("stamps", "number", "first", "off"),
    [
        *((wrong(by), 1, MIDDLE, f"{by:g}") for by in (0.02, 0.5, 2, 5, 10, 30, -0.03, -5, -70)),
        (wrong(1e6), 1, MIDDLE, "1e+06"),
        (wrong(30, slice(MIDDLE, MIDDLE + 200)), 200, MIDDLE, "30"),
        (wrong(-2, slice(MIDDLE, MIDDLE + 900)), 900, MIDDLE, "-2"),
        (wrong(1e6, 0), 1, 0, "1e+06"),
        (wrong(-70, -1), 1, EVEN.size - 1, "-70"),
        (wrong(30, 7_400, wrong(30)), 2, MIDDLE, "30"),
        (reordered([MIDDLE], [MIDDLE + 1]), 2, MIDDLE, "0.01"),
        (reordered([MIDDLE], [MIDDLE + 3]), 2, MIDDLE, "0.03"),
        (reordered([MIDDLE], [MIDDLE + 500]), 2, MIDDLE, "5"),
        # A hundred rows that come after the 900 that should follow them.
        (reordered(np.arange(5_000, 5_100), np.arange(5_100, 6_000)), 1_000, 5_000, "1"),
    ],
)
@pytest.mark.parametrize("scatter", [0.0, 1e-4])
def test_wrong_stamps_change_neither_rate_nor_samples(stamps, number, first, off, scatter):
    """A few of 20,000 at exactly 100 Hz."""
    told = clock(stamps + scatter * random().uniform(-1, 1, EVEN.size))
    assert told.rate_hz == pytest.approx(100, rel=1e-9 if not scatter else 2e-6)
    assert (told.breaks, told.lost, len(told.wrong)) == ((), 0.0, number)
    assert told.wrong[0] == first
    assert len(told.findings) == 1
    if not scatter:
        assert told.findings == about(number, first, off)


@pytest.mark.parametrize("share", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("value", [0.0, "random"])
def test_many_wrong_stamps(share, value):
    rng = random()
    stamps, off = EVEN.copy(), rng.random(EVEN.size) < share
    stamps[off] = rng.uniform(-1_000, 10_000, off.sum()) if value == "random" else value
    told = clock(stamps)
    assert told.rate_hz == pytest.approx(100, rel=1e-6)
    assert (told.breaks, told.lost) == ((), 0.0)
    assert set(np.flatnonzero(off)) <= set(told.wrong)
    assert len(told.wrong) <= 1.03 * off.sum()


def test_more_wrong_stamps_than_can_be_mended():
    """The clock is 5 s ahead for a thousand samples, three times."""
    stamps = EVEN[:16_000].copy()
    for start in (1_000, 6_000, 11_000):
        stamps[start : start + 1_000] += 5
    with pytest.raises(RecordingError, match="3000 of 16000 do not fit those before and after"):
        clock(stamps)


@pytest.mark.parametrize("before", [0, 1])
def test_a_wrong_stamp_at_a_gap_hides_none_of_it(before):
    stamps = EVEN.copy()
    stamps[MIDDLE:] += 30
    told = clock(wrong(1e6, MIDDLE - before, stamps))
    assert told.rate_hz == pytest.approx(100, rel=1e-9)
    assert told.breaks == (MIDDLE + 1 - before,)
    assert told.wrong == (MIDDLE - before,)
    assert "a gap of 30.01 s" in told.findings[-1]


def test_a_wrong_stamp_where_the_clock_is_set_back_changes_no_rate():
    stamps = EVEN.copy()
    stamps[MIDDLE + 1 :] -= 50
    told = clock(wrong(30, stamps=stamps))
    assert told.rate_hz == pytest.approx(100, rel=1e-9)
    assert told.breaks[-1] == MIDDLE + 1
    assert "step backward 1 time" in told.findings[-1]


@pytest.mark.parametrize("by", [-30, -0.5, 0.5, 30])
def test_a_clock_that_was_set_is_not_wrong(by):
    told = clock(wrong(by, slice(MIDDLE, None)))
    assert (told.rate_hz, told.breaks, told.wrong) == (pytest.approx(100), (MIDDLE,), ())


def test_wrong_stamps_among_losses_bursts_and_jitter():
    kept = random().random(EVEN.size) > 0.01
    told = clock(wrong(30, stamps=EVEN[kept]))
    assert told.rate_hz == pytest.approx(100, rel=1e-6)
    assert told.lost == pytest.approx(1 - kept.mean(), abs=2e-4)
    assert told.wrong == (MIDDLE,)
    for stamps in (
        np.repeat(EVEN[::20], 20),
        EVEN + 3e-3 * random().standard_normal(EVEN.size),
        late(EVEN),
    ):
        sound, told = clock(stamps), clock(wrong(30, stamps=stamps))
        assert (sound.wrong, told.wrong, told.breaks) == ((), (MIDDLE,), ())
        assert told.rate_hz == pytest.approx(sound.rate_hz, rel=1e-6)


def test_missing_stamps_are_said():
    stamps = EVEN.copy()
    stamps[[5, 6, 100]] = np.nan
    told = clock(stamps)
    assert (told.rate_hz, told.breaks) == (100.0, ())
    assert told.findings == ("Time stamps missing or not finite: 3.",)


@pytest.mark.parametrize(
    ("stamps", "message"),
    [
        (np.full(500, 5.0), "cannot be used: they do not increase"),
        (-np.arange(500.0), "499 of 500 are earlier than the one before"),
        (random().standard_normal(500), r"\d+ of 500 are earlier"),
        (np.full(500, np.nan), "500 of 500 are missing or not finite"),
        (np.arange(12.0), "there are only 12"),
    ],
)
def test_useless_stamps(stamps, message):
    with pytest.raises(RecordingError, match=message):
        clock(stamps)


def test_a_unit_that_is_no_time():
    with pytest.raises(RecordingError, match="their unit 'm' is none of h, min, s, ms, us and ns"):
        clock(EVEN, unit="m")


def test_a_letter_in_a_message_is_no_time():
    assert is_time("T")
    assert is_time("imu.ts")
    assert not is_time("imu.T")
    assert not is_time("imu.t")


@pytest.mark.parametrize(
    ("name", "unit", "seconds"),
    [
        ("time", "min", 60),
        ("Time", "h", 3600),
        ("seconds", "", 1),
        ("epoch_us", "", 1e-6),
        ("GPS_TOW", "s", 1),
        ("usec", "", 1e-6),
        ("msg.header.stamp_ns", "", 1e-9),
    ],
)
def test_what_loggers_call_their_stamps(name, unit, seconds):
    assert is_time(name, unit)
    told = clock(EVEN / seconds, name=name, unit=unit)
    assert (told.rate_hz, told.findings) == (pytest.approx(100, rel=1e-6), ())


@pytest.mark.parametrize(
    ("given_hz", "hint"),
    [
        (0.01, "is it the sampling interval in s, not the rate?"),
        (100_000.0, "off by a factor of 1000, is a unit mistaken?"),
        (0.1, "off by a factor of 1000, is a unit mistaken?"),
        (120.0, "check which is right."),
    ],
)
def test_a_rate_that_disagrees_is_said(given_hz, hint):
    (finding,) = clock(EVEN, given_hz=given_hz).findings
    assert finding.startswith(f"The rate of {given_hz:.6g} Hz, which is used, disagrees with")
    assert finding.endswith(hint)


def test_a_rate_that_agrees_is_silent():
    assert clock(EVEN, given_hz=101.0).findings == ()


def test_load_cuts_channels_at_gaps_and_uses_the_given_rate(archive, noise):
    time = np.arange(400) / 100
    time[150:] += 20
    recording = load(archive(gyro_x=noise[:, 0], time_s=time, rate_hz=None))
    assert recording.rate_hz == 100.0
    assert recording.channels[0].stretches == ((0, 150), (150, 400))
    assert load(archive(gyro_x=noise[:, 0], time_s=time), rate_hz=101.0).rate_hz == 101.0


def test_load_does_without_useless_stamps_when_the_rate_is_known(archive, noise):
    arrays = {"gyro_x": noise[:, 0], "time_s": np.zeros(400)}
    recording = load(archive(**arrays))
    assert recording.rate_hz == 100.0
    assert recording.findings == (
        "The time stamps cannot be used: they do not increase. Gaps, if there are any, are not "
        "seen.",
    )
    with pytest.raises(RecordingError, match=r"do not increase\. Give the rate with --rate\."):
        load(archive(**arrays, rate_hz=None))


def test_stamps_that_are_text_are_named_when_no_rate_is_known(write, noise):
    rows = [f"noon + {k / 100:05.2f},{value}" for k, value in enumerate(noise[:, 0])]
    path = write("clock.csv", "time,gyro_x [deg/s]\n" + "\n".join(rows))
    with pytest.raises(
        RecordingError,
        match=r"--rate, in Hz, or .*`time`\. The column time holds text",
    ):
        load(path)
    assert load(path, rate_hz=100.0).findings == ("The column time holds text and is left out.",)


@pytest.mark.parametrize(
    ("name", "ticks_per_s"),
    [
        ("time", 1),
        ("Zeit [s]", 1),
        ("Time since start (ms)", 1000),
        ("TimeUS", 1_000_000),
        ("sensor_timestamp_ns", 10**9),
        ("time stamp", 1),
        ("seconds_elapsed", 1),
        ("millis", 1000),
        ("Elapsed (sec)", 1),
        ("ts_ms", 1000),
    ],
)
def test_columns_of_time_have_many_names(name, ticks_per_s, tmp_path):
    path = tmp_path / "gyro.csv"
    noise = np.random.default_rng(3).normal(size=600)
    rows = [f"{k * ticks_per_s / 50:g},{value:.6f}" for k, value in enumerate(noise)]
    path.write_text(f"{name},gyro_x [deg/s]\n" + "\n".join(rows))
    recording = load(path)
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    assert recording.rate_hz == pytest.approx(50.0, rel=1e-4)
    assert not any("are taken to be in" in finding for finding in recording.findings)


def test_a_column_called_time_comes_before_others_with_its_unit(tmp_path):
    path = tmp_path / "gyro.csv"
    noise = np.random.default_rng(4).normal(size=600)
    rows = [f"{(k % 5) * 20},{k / 50:.2f},{value:.6f}" for k, value in enumerate(noise)]
    path.write_text("interval [ms],time,gyro_x [deg/s]\n" + "\n".join(rows))
    recording = load(path)
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    assert recording.rate_hz == pytest.approx(50.0)


def test_a_counter_of_32_bits_goes_on_where_it_begins_again():
    """`micros` of an Arduino for three hours, which begin again every 71.6 min."""
    micros = (4e9 + 1e6 * np.arange(1_080_000) / 100).astype(np.int64) % 2**32
    told = clock(micros, name="micros")
    assert told.breaks == ()
    assert told.rate_hz == pytest.approx(100, rel=1e-6)
    assert told.findings == (
        "The time stamps count to 2^32 and begin again 3 times; they are continued.",
    )


@pytest.mark.parametrize("missing", [slice(0, 1500), slice(-1500, None)])
def test_missing_stamps_at_the_ends_change_no_rate(missing):
    stamps = EVEN.copy()
    stamps[missing] = np.nan
    assert clock(stamps).rate_hz == pytest.approx(100, rel=1e-6)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
@pytest.mark.parametrize("rate_hz", [0.5, 1.0, 2000.0])
def test_stamps_since_1970_tell_their_unit(scale, unit, rate_hz):
    told = clock(scale * (1.7e9 + np.arange(20_000) / rate_hz), name="time")
    assert told.rate_hz == pytest.approx(rate_hz, rel=1e-3)
    assert told.unit == unit


def test_seconds_that_may_be_milliseconds_are_said():
    told = clock(np.arange(20_000) / 2, name="time")
    assert told.rate_hz == pytest.approx(2, rel=1e-6)
    assert "taken to be in s" in told.findings[0]
