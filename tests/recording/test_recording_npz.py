"""NumPy files: the shapes and types that are read, and those that are refused."""

import numpy as np
import pytest

from allanfit.recording import RecordingError, load


def test_one_axis_is_one_channel(tmp_path, noise):
    np.save(tmp_path / "one.npy", noise[:, 0])
    recording = load(tmp_path / "one.npy", rate_hz=50.0, unit="m/s^2")
    (channel,) = recording.channels
    assert (channel.name, channel.kind, recording.rate_hz) == ("data", "accelerometer", 50.0)
    np.testing.assert_array_equal(channel.samples, noise[:, 0])


@pytest.mark.parametrize("turned", [False, True])
def test_the_longer_of_two_axes_is_time(turned, tmp_path, noise):
    np.save(tmp_path / "two.npy", noise.T if turned else noise)
    recording = load(tmp_path / "two.npy", rate_hz=50.0, unit="rad/s")
    assert [channel.name for channel in recording.channels] == [
        "channel_1",
        "channel_2",
        "channel_3",
    ]
    np.testing.assert_array_equal(recording.channels[2].samples, noise[:, 2])


def test_fields_are_channels_and_time_stamps(tmp_path, noise):
    fields = np.zeros(400, dtype=[("time_s", "f8"), ("gyro_x", "f4")])
    fields["time_s"] = np.arange(400) / 200
    fields["gyro_x"] = noise[:, 0]
    np.save(tmp_path / "fields.npy", fields)
    recording = load(tmp_path / "fields.npy", unit="rad/s")
    assert (recording.rate_hz, recording.channels[0].name) == (200.0, "gyro_x")


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int16, np.uint8, ">f8"])
def test_any_real_type_becomes_float64(dtype, tmp_path, noise):
    values = (50 * noise[:, 0] + 128).clip(0, 255).astype(dtype)
    np.save(tmp_path / "typed.npy", values)
    (channel,) = load(tmp_path / "typed.npy", rate_hz=50.0, unit="counts").channels
    assert channel.samples.dtype == np.dtype(np.float64)
    np.testing.assert_array_equal(channel.samples, values.astype(float))


def test_an_archive_with_all_that_the_format_knows(archive, noise):
    path = archive(
        gyro_x=noise[:, 0].astype(np.float32),
        temperature=20 + noise[:, 1],
        mag_x=noise[:, 2],
        time_s=np.arange(400) / 100,
        units='{"gyro_x": "deg/s", "temperature": "degC", "withheld": "V"}',
    )
    recording = load(path)
    assert (recording.name, recording.rate_hz, recording.findings) == ("recording.npz", 100.0, ())
    (channel,) = recording.channels
    assert (channel.unit, channel.si_unit, channel.kind) == ("deg/s", "rad/s", "gyro")
    assert channel.factor == pytest.approx(np.pi / 180)
    np.testing.assert_allclose(channel.samples / channel.factor, noise[:, 0].astype(np.float32))
    assert [(aux.name, aux.unit, aux.kind) for aux in recording.auxiliary] == [
        ("temperature", "degC", "temperature"),
        ("mag_x", "", "other"),
    ]


def test_arrays_that_are_no_channels_are_left_out_and_said(archive, noise):
    recording = load(archive(gyro_x=noise[:, 0], matrix=np.eye(3), device="unit 7"))
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    assert recording.findings == (
        "The array matrix is left out: a channel is a 1-D array of real numbers, and it is 2-D of "
        "float64.",
    )


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.array([1, "a", None], dtype=object), "holds Python objects, which are not read"),
        (np.ones(400, dtype=complex), "values of type complex128, and real numbers are needed"),
        (np.array(["a"] * 400), "values of type <U1, and real numbers are needed"),
        (np.ones((8, 8, 8)), r"shape \(8, 8, 8\), and \(samples,\) or \(samples, channels\)"),
        (np.float64(1.0), r"shape \(\), and"),
        (np.zeros(400, dtype=[("x", "f8", 3)]), r"x has shape \(400, 3\)"),
    ],
)
def test_arrays_of_another_kind_are_refused(array, message, tmp_path):
    np.save(tmp_path / "bad.npy", array, allow_pickle=True)
    with pytest.raises(RecordingError, match=message):
        load(tmp_path / "bad.npy", rate_hz=100.0)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"gyro_x": np.array([None] * 400)}, "holds Python objects, which are not read"),
        ({"gyro_x": np.eye(3)}, "holds no channel: store each as a 1-D array"),
        ({"rate_hz": np.array([1.0, 2.0])}, "rate_hz must be a single number; pass --rate"),
        ({"rate_hz": np.array("fast")}, "rate_hz must be a single number"),
        ({"rate_hz": -1.0}, r"rate_hz in recording\.npz is -1"),
        ({"rate_hz": np.nan}, r"a number of samples a second from 1e-06"),
        ({"units": "deg/s"}, "`units` must be a JSON string that gives each channel a unit"),
        ({"units": '["deg/s"]'}, "`units` must be a JSON string"),
        ({"units": '{"gyro_x": 1}'}, "`units` must be a JSON string"),
        ({"units": np.array([1.0, 2.0])}, "`units` must be a JSON string"),
        ({"gyro_y": np.ones(300)}, "gyro_x has 400 and gyro_y has 300"),
        ({"time_s": np.arange(300.0)}, "gyro_x has 400 and time_s has 300"),
    ],
)
def test_bad_entries_of_an_archive(arrays, message, archive, noise):
    with pytest.raises(RecordingError, match=message):
        load(archive(**({"gyro_x": noise[:, 0]} | arrays)))


def test_damaged_files(archive, noise, write, tmp_path):
    whole = archive(gyro_x=noise[:, 0]).read_bytes()
    np.save(tmp_path / "whole.npy", noise)
    array = (tmp_path / "whole.npy").read_bytes()
    flipped = bytearray(whole)
    flipped[400] ^= 0xFF
    for name, data in {
        "cut.npz": whole[:-100],
        "middle.npz": whole[: len(whole) // 2],
        "flipped.npz": bytes(flipped),
        "text.npz": b"gyro_x\n1.0\n",
        "cut.npy": array[:-100],
        "header.npy": array[:20],
        "keys.npy": array.replace(b" 'fortran", b"b'fortran"),
        "quotes.npy": array.replace(b"'fortran", b"''fortran"),
        "text.npy": b"gyro_x\n1.0\n",
    }.items():
        with pytest.raises(RecordingError, match=rf"{name} is not a complete \.np[yz] file"):
            load(write(name, data), rate_hz=100.0)


def test_an_ending_that_belongs_to_the_other_kind(write, archive, noise, tmp_path):
    np.save(tmp_path / "whole.npy", noise)
    with pytest.raises(RecordingError, match=r"array\.npz is an \.npy file in truth: rename it"):
        load(write("array.npz", (tmp_path / "whole.npy").read_bytes()))
    with pytest.raises(RecordingError, match=r"zip\.npy is an \.npz file in truth: rename it"):
        load(write("zip.npy", archive(gyro_x=noise[:, 0]).read_bytes()))


def test_a_unit_and_a_rate_by_other_names_are_not_passed_over_in_silence(archive, noise):
    """`unit="deg/s"` was, and the recording was in no unit."""
    path = archive(gyro_x=noise[:, 0], units=None, unit="deg/s", Fs=200.0, note="a bench")
    findings = [str(each) for each in load(path).findings]
    assert any(each.startswith("The value unit is not read") for each in findings)
    assert any(each.startswith("The number Fs is not read") for each in findings)
    assert not any("note" in each for each in findings)
