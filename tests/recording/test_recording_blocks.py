"""Files in blocks against the same files read as a whole."""

import gzip
import json
import sys
import warnings

import h5py
import numpy as np
import polars as pl
import pytest

from allanfit.recording import RecordingError, load, read_in_blocks

ROWS = 50_000
RATE_HZ = 100.0
CODES = np.random.default_rng(7).integers(-5000, 5000, (ROWS, 2))


@pytest.fixture
def columns():
    """Two channels with a gap in time; one misses values at a block's end, one hangs for blocks."""
    time = 1_700_000_000_000_000_000 + 10_000_000 * np.arange(ROWS)
    time[30_000:] += 5_000_000_000
    x, y = CODES.T / 1000
    x[9_990:10_010] = np.nan
    x[10_020] = np.nan
    y[12_000:16_000] = y[12_000]
    return {"time": time, "gyro_x": x, "gyro_y": y}


def collected(blocks):
    """Samples and stretches by channel, as `load` tells them."""
    stretches = {channel.name: [[]] for channel in blocks.channels}
    for run in blocks:
        stretches[run.channel][-1].append(run.samples)
        if run.ends:
            stretches[run.channel].append([])
    joined = {
        name: [np.concatenate([np.empty(0), *pieces]) for pieces in each]
        for name, each in stretches.items()
    }
    return {name: [each for each in found if each.size >= 16] for name, found in joined.items()}


def write(path, columns):
    named = {f"{name} [{'ns' if name == 'time' else 'deg/s'}]": columns[name] for name in columns}
    if path.suffix in (".csv", ".txt", ".gz"):
        frame = pl.DataFrame(named).with_columns(pl.selectors.float().fill_nan(None))
        text = frame.write_csv().encode()
        if path.suffix == ".txt":
            text = text.replace(b"\n", b"\r\n")
        if path.stem.startswith("wide"):
            text = text.decode().encode("utf-16")
        path.write_bytes(gzip.compress(text) if path.suffix == ".gz" else text)
    elif path.suffix == ".parquet":
        pl.DataFrame(named).write_parquet(path)
    elif path.suffix == ".npz":
        units = dict.fromkeys(("gyro_x", "gyro_y"), "deg/s") | {"time": "ns"}
        np.savez_compressed(path, **columns, units=json.dumps(units))
    else:
        with h5py.File(path, "w") as file:
            for name, column in columns.items():
                data = file.create_dataset(f"imu/{name}", data=column, compression="gzip")
                data.attrs["unit"] = "ns" if name == "time" else "deg/s"


@pytest.mark.parametrize(
    "name",
    ["a.csv", "a.txt", "a.csv.gz", "wide.csv", "wide.txt", "a.parquet", "a.npz", "a.h5"],
)
def test_blocks_hold_what_the_whole_file_holds(name, columns, tmp_path):
    path = tmp_path / name
    write(path, columns)
    read = []
    blocks = read_in_blocks(path, block_samples=5000, progress=lambda *share: read.append(share))
    found, whole = collected(blocks), load(path)
    assert blocks.rate_hz == pytest.approx(RATE_HZ, rel=1e-9)
    assert list(found) == ["gyro_x", "gyro_y"]
    for channel in whole.channels:
        expected = [channel.samples[start:stop] for start, stop in channel.stretches]
        assert len(expected) == 3
        assert [each.size for each in found[channel.name]] == [each.size for each in expected]
        for one, other in zip(found[channel.name], expected, strict=True):
            np.testing.assert_array_equal(one, other)
    assert [each.si_unit for each in blocks.channels] == ["rad/s", "rad/s"]
    assert any("break 1 time" in finding for finding in blocks.findings)
    assert "Left out of gyro_x as missing or not finite: 21 samples." in blocks.findings
    assert "Left out of gyro_y as frozen, repeats of one value: 3" in " ".join(blocks.findings)
    assert not any(
        "Left out as" in told for channel in blocks.channels for told in channel.findings
    )
    assert len(read) > 2
    assert read[-1][0] == read[-1][1]
    assert read == sorted(read)


@pytest.mark.parametrize("start", [1, 15_300, 18_970, 18_975, 19_000, 19_900, 49_000])
@pytest.mark.parametrize("by", [7, -7])
def test_wrong_stamps_are_told_alike_wherever_a_block_ends(start, by, columns, tmp_path):
    """The first block tells of up to 18,976 samples, and of what it does not the next one."""
    time = 10_000_000 * np.arange(ROWS)
    time[start : start + 900] += by * 1_000_000_000
    time[4_000] = 0
    path = tmp_path / "a.npz"
    write(path, {"time": time, "gyro_x": CODES[:, 0] / 1000, "gyro_y": CODES[:, 1] / 1000})
    blocks, whole = read_in_blocks(path, block_samples=5000), load(path)
    found = collected(blocks)
    assert [samples.size for samples in found["gyro_x"]] == [ROWS]
    assert blocks.rate_hz == pytest.approx(RATE_HZ, rel=1e-9)
    assert whole.rate_hz == pytest.approx(RATE_HZ, rel=1e-9)
    assert blocks.findings == whole.findings
    assert "901 time stamps do not fit" in whole.findings[0]


@pytest.mark.parametrize("name", ["a.csv", "a.parquet", "a.npz", "a.h5"])
def test_between_blocks_the_caller_may_print_and_warn(name, columns, tmp_path):
    write(tmp_path / name, columns)
    before = sys.stdout, list(warnings.filters)
    blocks = read_in_blocks(tmp_path / name, block_samples=5000)
    assert all((sys.stdout, warnings.filters) == before for _ in blocks)
    assert (sys.stdout, warnings.filters) == before


def test_a_mapped_array_needs_its_rate(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, CODES)
    with pytest.raises(RecordingError, match="give it with --rate"):
        read_in_blocks(path)
    found = collected(read_in_blocks(path, rate_hz=50.0, unit="deg/s", block_samples=7000))
    (samples,) = found["channel_2"]
    np.testing.assert_allclose(samples, CODES[:, 1] * (np.pi / 180), rtol=1e-15)


def test_only_the_last_line_may_be_short(tmp_path):
    lines = [
        f"{value:.6f},{value / 3:.6f}" for value in np.random.default_rng(5).normal(size=40_000)
    ]
    path = tmp_path / "gyro.csv"

    def written(short):
        cut = [line.partition(",")[0] if k == short else line for k, line in enumerate(lines)]
        path.write_text("gyro_x [deg/s],gyro_y [deg/s]\n" + "\n".join(cut) + "\n")
        return read_in_blocks(path, rate_hz=100.0, block_samples=1024)

    # Here and there, and everywhere about the end of the first block, which has half a MB.
    end = int(np.searchsorted(np.cumsum([len(line) + 1 for line in lines]), 2**19))
    for short in (100, *range(end - 6, end + 6), 39_998):
        with pytest.raises(RecordingError, match=f"line {short + 2} has 1 field"):
            collected(written(short))
    assert collected(written(39_999))["gyro_x"][0].size == 40_000


def test_a_word_in_a_later_block_is_told_with_its_line(tmp_path):
    path = tmp_path / "a.csv"
    lines = ["data", *(f"{code / 1000}" for code in CODES[:, 0])]
    lines[45_000] = "stop"
    path.write_text("\n".join(lines))
    with pytest.raises(RecordingError, match=r"line 45001, column data: 'stop' is not a number"):
        list(read_in_blocks(path, rate_hz=50.0, block_samples=4000))


@pytest.mark.parametrize("name", ["a.npz", "a.csv.gz", "a.h5", "a.parquet", "a.npy"])
def test_damage_is_one_sentence(name, columns, tmp_path):
    path = tmp_path / name
    write(path, columns) if name != "a.npy" else np.save(path, CODES)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(RecordingError, match="cut off"):
        list(read_in_blocks(path, rate_hz=50.0, block_samples=5000))


def test_what_has_no_samples_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("x\n")
    with pytest.raises(RecordingError):
        read_in_blocks(tmp_path / "a.csv", rate_hz=1.0)
    with pytest.raises(RecordingError, match="There is no file"):
        read_in_blocks(tmp_path / "none.csv")
    with pytest.raises(RecordingError, match="at least 1024"):
        read_in_blocks(tmp_path / "a.csv", block_samples=0)
    path = tmp_path / "counter.npy"
    np.save(path, np.arange(1000))
    with pytest.raises(RecordingError, match="as a counter"):
        read_in_blocks(path, rate_hz=1.0)


def test_a_sensor_that_hangs_for_longer_than_a_block(tmp_path):
    path, samples = tmp_path / "a.npy", np.random.default_rng(9).standard_normal(40_000)
    samples[10_000:30_000] = samples[10_000]
    np.save(path, samples)
    ((*pieces,),) = collected(read_in_blocks(path, rate_hz=50.0, block_samples=4096)).values()
    (channel,) = load(path, rate_hz=50.0).channels
    expected = [channel.samples[start:stop] for start, stop in channel.stretches]
    np.testing.assert_array_equal(np.concatenate(pieces), np.concatenate(expected))


def test_values_too_large_in_a_later_block_are_refused(tmp_path):
    path, samples = tmp_path / "a.npy", np.random.default_rng(9).standard_normal(40_000)
    samples[30_000] = 1e200
    np.save(path, samples)
    with pytest.raises(RecordingError, match=r"values as large as 1e\+200, which no sensor gives"):
        list(read_in_blocks(path, rate_hz=50.0, block_samples=4096))


def test_mistakes_are_told_of_the_first_block_too(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, gyro_x=CODES[:, 0], rate_hz=100.0, units=json.dumps({"gyro_x": "rad/s"}))
    findings = read_in_blocks(path, block_samples=7000).findings
    assert any(each.startswith("In the first samples: All samples of gyro_x") for each in findings)


def test_an_archive_in_blocks_keeps_the_rules_of_the_whole(tmp_path):
    path = tmp_path / "a.npz"
    x, y = CODES[:5000].T / 1000

    def stored(**others):
        np.savez(path, gyro_x=x, **others)
        return [lambda **kw: load(path, **kw), lambda **kw: blocks_of(path, **kw)]

    about = {"rate_hz": np.array([50.0]), "units": np.array(['{"gyro_x": "deg/s"}'])}
    whole, parts = stored(**about, matrix=np.eye(3), label=np.array(["a"] * 9000))
    for found in (whole(), parts()):
        assert (found.rate_hz, found.channels[0].unit) == (50.0, "deg/s")
        assert [channel.name for channel in found.channels] == ["gyro_x"]
        assert [each[:28] for each in found.findings[:2]] == [
            "The array matrix is left out",
            "The array label is left out:",
        ]
    for read in stored(**about, accel_x=y[:4000], temperature=y[:10]):
        with pytest.raises(RecordingError, match=r"gyro_x has \d+ and accel_x has \d+"):
            read()
        assert not any("accel" in each for each in read(channels="gyro_x").findings)
        assert [each.name for each in read(channels="accel_x").channels] == ["accel_x"]
    found = collected(read_in_blocks(path, channels="accel_x", block_samples=1024))
    np.testing.assert_array_equal(np.concatenate(found["accel_x"]), y[:4000])
    for others, message in (
        ({"rate_hz": about["rate_hz"].repeat(2)}, "rate_hz must be a single number"),
        ({"units": about["units"].repeat(2)}, "`units` must be a JSON string"),
        ({"words": np.array([None])}, "holds Python objects, which are not read"),
    ):
        for read in stored(**(about | others)):
            with pytest.raises(RecordingError, match=message):
                read()


def test_groups_in_blocks_keep_the_rules_of_the_whole(tmp_path):
    path = tmp_path / "a.h5"

    def stored(arrays):
        with h5py.File(path, "w") as file:
            file.attrs["rate_hz"] = 50.0
            for name, values in arrays.items():
                file[name] = values
        return [lambda **kw: load(path, **kw), lambda **kw: blocks_of(path, **kw)]

    gyro, time = CODES[:5000] / 1000, np.arange(5000) / 50
    for read in stored({"gyro": gyro, "accel": gyro[:4000]}):
        with pytest.raises(RecordingError, match=r"accel \(4000 samples\), gyro \(5000 samples\)"):
            read()
        assert len(read(topic="accel").channels) == 2
    later = {"a/gyro": gyro, "a/time": time, "b/temp": gyro[:4000, 0], "b/time": time[:4000]}
    for read in stored(later):
        with pytest.raises(RecordingError, match=r"a \(5000 samples\), b \(4000 samples\)"):
            read()
    # What is no series of numbers says nothing of how long one is.
    cube = {"gyro": gyro, "cube": np.ones((40, 40, 40)), "words": np.array([b"a"] * 6000)}
    whole, parts = (read() for read in stored(cube))
    assert parts.findings[:2] == whole.findings[:2]
    assert "it has the shape (40, 40, 40) of float64" in whole.findings[0]


def blocks_of(path, **options):
    """A recording in blocks, with the findings of all of them."""
    blocks = read_in_blocks(path, block_samples=1024, **options)
    list(blocks)
    return blocks


@pytest.mark.parametrize("gaps", [{30_000: 5.0}, {9_000: 2.5, 21_000: 7.25, 40_000: 1.5}])
def test_gaps_are_told_where_and_for_how_long_as_of_the_whole(gaps, tmp_path):
    time = np.arange(ROWS) / RATE_HZ
    for at, length in gaps.items():
        time[at:] += length
    longest = max(gaps, key=gaps.__getitem__)
    np.savez(tmp_path / "a.npz", time_s=time, gyro_x=CODES[:, 0] / 1000)
    where = f"{gaps[longest] + 1 / RATE_HZ:.4g} s at {time[longest - 1]:.6g} s: about "
    where += f"{round(sum(gaps.values()) * RATE_HZ)} samples are missing there"
    blocks = read_in_blocks(tmp_path / "a.npz", unit="deg/s", block_samples=4096)
    assert sum(run.samples.size for run in blocks) == ROWS
    for found in (load(tmp_path / "a.npz", unit="deg/s"), blocks):
        (told,) = (each for each in found.findings if "samples are missing there" in each)
        assert where in told
        if len(gaps) > 1:
            assert "11.28 s in all" in told
