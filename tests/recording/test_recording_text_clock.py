"""Clocks written as dates and times, against what `datetime` makes of the instants."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

from allanfit.recording import RecordingError, contents, load, read_in_blocks

SIZE = 3000
NOISE = np.random.default_rng(8).standard_normal(SIZE).round(5)
START = datetime(2026, 11, 22, 8, 0, 0, tzinfo=UTC)
EAST = timezone(timedelta(hours=1))


def instants(start=START, rate_hz=100, lost=()):
    kept = np.delete(np.arange(SIZE + len(lost)), lost)
    return [start + timedelta(microseconds=int(k) * 1_000_000 // rate_hz) for k in kept]


def millis(form):
    """A form in which %f is milliseconds."""
    return lambda at: at.strftime(form.replace("%f", f"{at.microsecond // 1000:03d}"))


FORMS = {
    "German": millis("%d.%m.%Y %H:%M:%S,%f"),
    "German, short": millis("%d.%m.%y %H:%M:%S,%f"),
    "ISO": millis("%Y-%m-%dT%H:%M:%S.%f"),
    "ISO, us": lambda at: at.strftime("%Y-%m-%dT%H:%M:%S.%f"),
    "ISO, blank": millis("%Y-%m-%d %H:%M:%S.%f"),
    "ISO, Z": millis("%Y-%m-%dT%H:%M:%S.%fZ"),
    "ISO, offset": millis("%Y-%m-%dT%H:%M:%S.%f+01:00"),
    "American": millis("%m/%d/%Y %I:%M:%S.%f %p"),
    "American, bare": lambda at: f"{at.month}/{at.day}/{at:%Y} " + millis("%H:%M:%S.%f")(at),
    "British": millis("%d/%m/%Y %H:%M:%S.%f"),
    "slashes": millis("%Y/%m/%d %H:%M:%S.%f"),
    "time": millis("%H:%M:%S.%f"),
    "time, half days": millis("%I:%M:%S.%f %p"),
}


def write(path, stamps, name="Stamp"):
    """A table with semicolons, so that commas may be decimal ones."""
    comma = "," in stamps[0]
    rows = [f"{at};{str(x).replace('.', ',' if comma else '.')}" for at, x in zip(stamps, NOISE)]  # noqa: B905 - one longer
    path.write_text(f"{name};gyro_x [deg/s]\n" + "\n".join(rows))
    return path


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("hour", [8, 23])
def test_every_form_gives_rate_and_gap(form, hour, tmp_path):
    """Also over midnight, and over the end of a month."""
    start = START.replace(hour=hour, minute=59, second=45, day=30)
    stamps = instants(start, lost=range(1000, 1400))
    path = write(tmp_path / "a.csv", [FORMS[form](at) for at in stamps])
    recording = load(path)
    assert recording.rate_hz == pytest.approx(100, rel=1e-9)
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    assert recording.channels[0].stretches == ((0, 1000), (1000, SIZE))
    (finding,) = recording.findings
    assert finding.startswith("The time stamps have a gap of 4.01 s at 9.99 s: about 400 samples")
    (listed,) = contents(path)
    assert (listed.rate_hz, listed.units) == (pytest.approx(100), {"gyro_x": "deg/s"})


def test_whole_seconds_tell_the_rate(tmp_path):
    path = write(tmp_path / "a.csv", [at.strftime("%H:%M:%S") for at in instants()])
    recording = load(path)
    assert recording.rate_hz == pytest.approx(100, rel=0.05)
    assert "The time stamps are uneven" in recording.findings[0]


def test_a_change_of_the_offset_is_no_gap(tmp_path):
    """Clocks are set back by an hour, and say so."""
    stamps = instants()
    text = [
        (at.astimezone(EAST) if k < 1500 else at).isoformat(timespec="milliseconds")
        for k, at in enumerate(stamps)
    ]
    recording = load(write(tmp_path / "a.csv", text))
    assert (recording.rate_hz, recording.findings) == (100.0, ())


@pytest.mark.parametrize("date", ["%Y-%m-%d", "%d.%m.%Y", "%m/%d/%Y", "%d-%m-%Y"])
def test_date_and_time_in_columns_of_their_own(date, tmp_path):
    stamps = instants(START.replace(hour=23, minute=59, second=50))
    text = [f"{at.strftime(date)};{millis('%H:%M:%S.%f')(at)}" for at in stamps]
    recording = load(write(tmp_path / "a.csv", text, "Date;Time"))
    assert (recording.rate_hz, recording.findings) == (100.0, ())
    assert [channel.name for channel in recording.channels] == ["gyro_x"]


def test_days_between_dates_are_a_gap(tmp_path):
    stamps = instants()
    stamps = stamps[:1500] + [at + timedelta(days=3) for at in stamps[1500:]]
    recording = load(write(tmp_path / "a.csv", [at.isoformat() for at in stamps]))
    assert "a gap of 2.592e+05 s" in recording.findings[0]


def test_numbers_come_before_text(tmp_path):
    text = [f"{k / 50:.2f};{at.isoformat()}" for k, at in enumerate(instants())]
    recording = load(write(tmp_path / "a.csv", text, "time [s];written at"))
    assert recording.rate_hz == pytest.approx(50)
    assert recording.findings == ("The column written at holds text and is left out.",)


def test_without_a_header(tmp_path):
    path = tmp_path / "a.txt"
    rows = [f"{at.isoformat(' ')} {x}" for at, x in zip(instants(), NOISE, strict=True)]
    path.write_text("\n".join(rows).replace("+00:00", ""))
    recording = load(path)
    assert recording.rate_hz == pytest.approx(100)
    assert [channel.name for channel in recording.channels] == ["channel_3"]


def test_a_few_that_are_missing_or_no_times_are_said(tmp_path):
    text = [FORMS["ISO"](at) for at in instants()]
    text[7], text[1000] = "", "2026-11-22T"
    recording = load(write(tmp_path / "a.csv", text))
    assert recording.rate_hz == pytest.approx(100)
    assert recording.findings == ("Time stamps missing or not finite: 2.",)


@pytest.mark.parametrize("form", ["%m/%d/%Y %H:%M", "%H:%M", "%M:%S.%f"])
def test_times_to_the_minute_are_refused(form, tmp_path):
    path = write(tmp_path / "a.csv", [millis(form)(at) for at in instants()])
    with pytest.raises(RecordingError, match=r"such as '.*', and is left out: write them in full"):
        load(path)
    assert "write them in full" in load(path, rate_hz=100.0).findings[0]


@pytest.mark.parametrize("form", ["time", "American", "ISO", "German"])
def test_in_blocks_over_midnight(form, tmp_path):
    stamps = instants(START.replace(hour=23, minute=59, second=40), lost=range(200, 300))
    many = stamps + [stamps[-1] + timedelta(milliseconds=10 * k) for k in range(1, 60_000)]
    rows = [f"{FORMS[form](at)};{NOISE[k % SIZE]:.4f}" for k, at in enumerate(many)]
    path = tmp_path / "a.csv"
    path.write_text("Stamp;gyro_x [deg/s]\n" + "\n".join(rows))
    blocks = read_in_blocks(path, block_samples=1024)
    assert sum(run.samples.size for run in blocks) == len(many)
    assert blocks.rate_hz == pytest.approx(100)
    (finding,) = blocks.findings
    assert finding.startswith("The time stamps break 1 time")
