"""Feeds the readers bytes that atheris bends toward code not reached yet; run by hand.

    pip install atheris
    python -m benchmarks.fuzz [CORPUS] [-max_total_time=600] [options of libFuzzer]

A reader may refuse a file with its own error and nothing else. What breaks that, hangs for ten
seconds or takes 2 GB of memory is written to the folder of the call, to become a case of
tests/hostile.
"""

import gzip
import io
import sys
import tempfile
import warnings
from pathlib import Path

import atheris  # pyright: ignore[reportMissingImports] - no part of any extra
import numpy as np
import polars as pl

with atheris.instrument_imports(include=["allanfit"]):
    from allanfit.calibrate._rate_file import read_rate_table
    from allanfit.coefficients import CoefficientsError, read_coefficients
    from allanfit.datasheet import DatasheetError
    from allanfit.recording import RecordingError, load
    from allanfit.recording._units import parse_unit

FOLDER = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
READERS = (
    *((suffix, lambda path: load(path, rate_hz=100.0)) for suffix in (".csv", ".npy", ".npz")),
    (".txt", load),
    (".csv.gz", lambda path: load(path, rate_hz=100.0)),
    (".yaml", read_coefficients),
    (".table", lambda path: read_rate_table(path, "rpm")),
    (".unit", lambda path: parse_unit(path.read_bytes().decode(errors="replace"))),
    *((suffix, load) for suffix in (".parquet", ".mat", ".ulg", ".bag", ".mcap", ".db3")),
)


def one(data: bytes) -> None:
    """The first byte chooses the reader, the others are the file."""
    if not data:
        return
    suffix, read = READERS[data[0] % len(READERS)]
    path = FOLDER / f"fuzz{suffix}"
    path.write_bytes(gzip.compress(data[1:], 1) if suffix == ".csv.gz" else data[1:])
    try:
        read(path)
    except (RecordingError, CoefficientsError, DatasheetError) as error:
        said(str(error))
    except ValueError as error:
        if suffix != ".table" or type(error) is not ValueError:
            raise
        said(str(error))


def said(sentence: str) -> None:
    """A refusal is a sentence of bearable length."""
    if not sentence.endswith((".", "!", "?")) or len(sentence) > 2000:
        raise AssertionError(sentence)


def seeds() -> list[bytes]:
    """A good file for each reader, to start from."""
    noise = np.random.default_rng(0).standard_normal((300, 2)).round(4)
    rows = "".join(f"{k / 100:.2f},{x},{y}\n" for k, (x, y) in enumerate(noise))
    array, archive = io.BytesIO(), io.BytesIO()
    np.save(array, noise)
    np.savez(archive, gyro_x=noise[:, 0], rate_hz=100.0, units='{"gyro_x": "deg/s"}')
    blanks = rows.replace(",", " ")
    files = (
        f"time_s,gyro_x [deg/s],temperature [degC]\n{rows}".encode(),
        array.getvalue(),
        archive.getvalue(),
        f"# t a b\n{blanks}".encode(),
        rows.replace(",", ";").replace(".", ",").encode(),
        b"unit: deg/s\nN: 5.0e-3\neffects:\n- {name: sinusoid, amplitude: 1, frequency: 2}\n",
        b"rate,roll_cw,roll_ccw\n10,10.1,-9.9\n20,20.1,-19.9\n",
        b"mdeg/sqrt(h)",
    )
    return [bytes([k]) + content for k, content in enumerate((*files, *packed(noise)))]


def packed(noise: np.ndarray) -> list[bytes]:
    """The same in the formats of the extra `io`, by the writers that the tests have."""
    sys.path.append("tests/recording")
    import scipy.io
    from recording_files import ROS1, ROS2, SECOND, imu, write_bag, write_ulog

    folder = FOLDER / "written"
    folder.mkdir()
    pl.DataFrame({"time_s": np.arange(300) / 100, "gyro_x [deg/s]": noise[:, 0]}).write_parquet(
        folder / "a.parquet"
    )
    structure = {"gyro": noise, "note": "text", "cells": np.array([1, "a"], object)}
    scipy.io.savemat(folder / "a.mat", {"imu": structure, "fs": 100.0}, do_compression=False)
    fields = "uint64_t timestamp;float x;float y;float z;float temperature;"
    rows = [(1000 + 4000 * k, x, y, x, 20.0) for k, (x, y) in enumerate(noise)]
    write_ulog(folder / "a.ulg", {"sensor_gyro": (fields, rows)})
    files = [folder / "a.parquet", folder / "a.mat", folder / "a.ulg"]
    for kind in ("bag", "mcap", "sqlite3"):
        store = ROS1 if kind == "bag" else ROS2
        messages = [
            ("/imu", k * SECOND // 100, imu(store, k * SECOND // 100 + 1, np.resize(row, 6), "imu"))
            for k, row in enumerate(noise[:20])
        ]
        path = write_bag(folder / f"a{'.bag' if kind == 'bag' else f'_{kind}'}", kind, messages)
        files += (
            [path]
            if path.is_file()
            else [each for each in path.iterdir() if each.suffix != ".yaml"]
        )
    return [file.read_bytes() for file in files]


def main() -> None:
    """Fuzz until told otherwise."""
    warnings.simplefilter("ignore")
    start = FOLDER / "seeds"
    start.mkdir()
    for k, seed in enumerate(seeds()):
        (start / str(k)).write_bytes(seed)
    options = ["-timeout=10", "-rss_limit_mb=2048", "-max_len=65536", *sys.argv[1:], str(start)]
    atheris.Setup([sys.argv[0], *options], one)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
