# ruff: noqa: E501 - one case a line reads as the table that it is
"""Files of the formats of the extra `io` that must be refused, and what has to be said."""

import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import h5py
import lz4.frame
import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import scipy.io
from backports import zstd
from bad_recordings import GARBAGE, TABLE, WORDS, Bad, npz
from recording_files import ROS1, ROS2, SECOND, imu, temperature, write_bag, write_ulog

ROWS = np.resize(0.01 * WORDS, (300, 6))
ZEROS = 1 << 30


def parquet_file(columns: dict[str, object], **options: object) -> bytes:
    """Columns as a Parquet file."""
    stream = io.BytesIO()
    parquet.write_table(arrow.table(columns), stream, **options)
    return stream.getvalue()


def mat(compress: bool = False, **variables: object) -> bytes:
    """Variables as a MAT-file of version 5."""
    stream = io.BytesIO()
    scipy.io.savemat(stream, variables, do_compression=compress)
    return stream.getvalue()


def hdf5(**arrays: object) -> bytes:
    """Arrays as an HDF5 file."""
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        for name, array in arrays.items():
            file[name] = array
    return stream.getvalue()


def bag(kind: str, messages: list[tuple[str, int, object]]) -> bytes:
    """The one file of a bag: `bag`, `sqlite3` or `mcap`."""
    with TemporaryDirectory() as folder:
        path = write_bag(Path(folder) / "a", kind, messages)
        files = (
            [path] if kind == "bag" else [each for each in path.iterdir() if each.suffix != ".yaml"]
        )
        return files[0].read_bytes()


def messages(kind: str, rows: np.ndarray = ROWS) -> list[tuple[str, int, object]]:
    """An IMU at 100 Hz."""
    store = ROS1 if kind == "bag" else ROS2
    step = SECOND // 100
    return [("/imu", k * step, imu(store, k * step + 1, row)) for k, row in enumerate(rows)]


def ulog(rows: list[tuple]) -> bytes:
    """A log with a gyro."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.ulg"
        write_ulog(path, {"sensor_gyro": ("uint64_t timestamp;float x;float y;float z;", rows)})
        return path.read_bytes()


GOOD = {
    ".parquet": parquet_file({"gyro_x": WORDS}),
    ".mat": mat(gyro=WORDS),
    ".h5": hdf5(gyro=WORDS),
    ".ulg": ulog([(1000 + 4000 * k, *row[:3]) for k, row in enumerate(ROWS)]),
    ".bag": bag("bag", messages("bag")),
    ".mcap": bag("mcap", messages("mcap")),
    ".db3": bag("sqlite3", messages("sqlite3")),
}
_NAMES = {
    ".parquet": "a Parquet file", ".mat": "a MAT-file", ".h5": "an HDF5 file", ".ulg": "an ULog file",
    ".bag": "a recording of ROS", ".mcap": "a recording of ROS", ".db3": "a recording of ROS",
}  # fmt: skip


def bomb_parquet(path: Path) -> None:
    """A GB of zeros in a few kB."""
    zeros = arrow.array(np.zeros(1 << 24))
    with parquet.ParquetWriter(
        path, arrow.schema({"gyro_x": zeros.type}), compression="zstd"
    ) as writer:
        for _ in range(8):
            writer.write_table(arrow.table({"gyro_x": zeros}))


def bomb_texts(path: Path) -> None:
    """One text of a MB, said ten thousand times by its number, beside a channel that is constant."""
    texts = arrow.array(["x" * (1 << 20)])
    said = arrow.DictionaryArray.from_arrays(np.zeros(10_000, np.int32), texts)
    parquet.write_table(arrow.table({"x": np.zeros(10_000), "note": said}), path)


def bomb_hdf5(path: Path) -> None:
    """Zeros that were never written."""
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (ZEROS // 8,), "f8", chunks=(1 << 20,), compression="gzip")


def bomb_references(path: Path) -> None:
    """An array of texts that are all one text, beside an array that is no text at all."""
    with h5py.File(path, "w") as file:
        file["x"] = np.zeros(400)
        file.create_dataset("notes", (10_000,), h5py.string_dtype(), fillvalue="x" * 50_000)


def nested_hdf5(path: Path) -> None:
    """Groups in groups."""
    with h5py.File(path, "w") as file:
        file["/".join(500 * "a")] = WORDS


def links(path: Path) -> None:
    """Nothing but links: to another file, to a place that leads back, to nothing."""
    other = path.with_name("other.h5")
    with h5py.File(other, "w") as file:
        file["gyro_x"] = WORDS
    with h5py.File(path, "w") as file:
        file["gyro_x"] = h5py.ExternalLink(str(other), "gyro_x")
        file["a"] = h5py.SoftLink("/b")
        file["b"] = h5py.SoftLink("/a")
        file["group/itself"] = file["/"]


def element(kind: int, content: bytes) -> bytes:
    """A part of a MAT-file of version 5."""
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def matrix(kind: int, shape: tuple[int, ...], *parts: bytes) -> bytes:
    """A variable called x, by the published format."""
    header = element(6, struct.pack("<II", kind, 0)) + element(
        5, struct.pack(f"<{len(shape)}i", *shape)
    )
    return element(14, b"".join((header, element(1, b"x"), *parts)))


def mat5(*variables: bytes) -> bytes:
    """A MAT-file of them."""
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"".join(variables)


def nested_mat(levels: int) -> bytes:
    """A cell in a cell in a cell, as the only variable."""
    header = matrix(1, (1, 1))[8:]
    parts = (
        struct.pack("<II", 14, (levels - k) * (8 + len(header)) - 8) + header for k in range(levels)
    )
    return mat5(b"".join(parts))


def bomb_mat(path: Path) -> None:
    """A GB of zeros, deflated, in a variable that says it has one number."""
    squeeze = zlib.compressobj(9)
    header = matrix(6, (1, 1))[8:] + struct.pack("<II", 9, ZEROS)
    packed = squeeze.compress(struct.pack("<II", 14, len(header) + ZEROS) + header)
    packed += squeeze.flush(zlib.Z_FULL_FLUSH)
    # After a full flush a piece stands for itself, and may be said again.
    piece = squeeze.compress(bytes(1 << 24)) + squeeze.flush(zlib.Z_FULL_FLUSH)
    content = packed + piece * (ZEROS >> 24)
    path.write_bytes(mat5(struct.pack("<II", 15, len(content)) + content))


FUNCTION = element(14, element(6, struct.pack("<II", 16, 0)) + element(5, struct.pack("<2i", 1, 1))
                   + element(1, b"f") + matrix(6, (1, 1), element(9, bytes(8))))  # fmt: skip


def record(fields: dict[str, bytes], data: bytes) -> bytes:
    """A record of a ROS 1 bag."""
    header = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value
        for name, value in fields.items()
    )
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def bomb_bag(path: Path) -> None:
    """A good bag with its chunk in the place of one that swells to a GB."""
    frame = lz4.frame.LZ4FrameCompressor()
    parts = [frame.begin()] + [frame.compress(bytes(1 << 26)) for _ in range(ZEROS >> 26)]
    packed = b"".join((*parts, frame.flush()))
    good = GOOD[".bag"]
    start = 13 + 4096
    at = start + 4 + struct.unpack_from("<I", good, start)[0]
    stop = at + 4 + struct.unpack_from("<I", good, at)[0]
    chunk = record({"op": b"\5", "compression": b"lz4", "size": struct.pack("<I", ZEROS)}, packed)
    moved = start + len(chunk) - stop
    content = bytearray(good[:start] + chunk + good[stop:])
    index = content.index(b"index_pos=") + 10
    content[index : index + 8] = struct.pack(
        "<Q", struct.unpack_from("<Q", content, index)[0] + moved
    )
    path.write_bytes(content)


def bomb_mcap(path: Path) -> None:
    """A chunk that says it is a GB, and is."""
    squeeze = zstd.ZstdCompressor()
    packed = b"".join(
        [squeeze.compress(bytes(1 << 24)) for _ in range(ZEROS >> 24)] + [squeeze.flush()]
    )

    def told(op: int, content: bytes) -> bytes:
        return struct.pack("<BQ", op, len(content)) + content

    def text(content: str) -> bytes:
        return struct.pack("<I", len(content)) + content.encode()

    magic = b"\x89MCAP0\r\n"
    chunk = (
        struct.pack("<QQQI", 0, 1, ZEROS, 0)
        + text("zstd")
        + struct.pack("<Q", len(packed))
        + packed
    )
    path.write_bytes(
        magic + told(1, text("ros2") + text("")) + told(6, chunk) + told(2, bytes(20)) + magic
    )


def unfinished(path: Path) -> None:
    """A good database, and beside it messages that are not in it yet."""
    path.write_bytes(GOOD[".db3"])
    Path(f"{path}-wal").write_bytes(GARBAGE)


def under(name: str) -> Callable[[Path], None]:
    """A good database whose path SQLite would take for another's: put under the other's name too."""

    def write(path: Path) -> None:
        path.write_bytes(GOOD[".db3"])
        path.with_name(name).write_bytes(GOOD[".db3"])

    return write


def warm(kind: str) -> bytes:
    """A temperature alone."""
    store = ROS1 if kind == "bag" else ROS2
    return bag(kind, [("/t", k, temperature(store, k, 20.0)) for k in range(300)])


_KINDS = {".bag": "bag", ".mcap": "mcap", ".db3": "sqlite3"}
_NAN = np.full((300, 6), np.nan)
BAD = {
    **{f"empty {s}": Bad(f"a{s}", b"", "is empty", ()) for s in GOOD},
    **{f"junk as {s}": Bad(f"a{s}", GARBAGE, f"is not {_NAMES[s]} that can be read", ()) for s in GOOD},
    **{f"text as {s}": Bad(f"a{s}", TABLE, f"is not {_NAMES[s]} that can be read", ()) for s in GOOD},
    **{f"an archive as {s}": Bad(f"a{s}", npz(x=WORDS), f"is not {_NAMES[s]} that can be read", ()) for s in GOOD},
    **{f"{s} cut in its header": Bad(f"a{s}", GOOD[s][:9], f"is not {_NAMES[s]}|no messages", ()) for s in GOOD},
    **{f"{s} cut in half": Bad(f"a{s}", GOOD[s][: len(GOOD[s]) // 2], f"is not {_NAMES[s]}|usable samples|--rate", ()) for s in GOOD if s != ".ulg"},
    **{f"{s} of another kind": Bad(f"a{s}", GOOD[".h5" if s != ".h5" else ".bag"], "is not|tells no sampling rate", ()) for s in GOOD},
    **{f"no messages in {s}": Bad(f"a{s}", bag(kind, []), "holds no messages", ()) for s, kind in _KINDS.items()},
    **{f"a temperature alone in {s}": Bad(f"a{s}", warm(kind), "holds no messages of sensor_msgs/Imu", ()) for s, kind in _KINDS.items()},
    **{f"nan alone in {s}": Bad(f"a{s}", bag(kind, messages(kind, _NAN)), "0 usable samples", ()) for s, kind in _KINDS.items()},
    "nan alone in parquet": Bad("a.parquet", parquet_file({"x": np.full(400, np.nan)}), "0 usable samples"),
    "nan alone in hdf5": Bad("a.h5", hdf5(x=np.full(400, np.nan)), "0 usable samples"),
    "nan alone in mat": Bad("a.mat", mat(x=np.full(400, np.nan)), "0 usable samples"),
    "nan alone in a log": Bad("a.ulg", ulog([(4000 * k, *3 * [np.nan]) for k in range(400)]), "0 usable samples", ()),
    "a definition that goes on beyond the log": Bad("a.ulg", GOOD[".ulg"][:16] + b"\x50\x00Z" + bytes(70), "before its data begin", ()),
    "no messages in a log": Bad("a.ulg", ulog([]), "holds no messages", ()),
    "a log of one time": Bad("a.ulg", ulog([(5, *row[:3]) for row in ROWS]), "do not increase", ()),
    "no rows": Bad("a.parquet", parquet_file({"x": np.zeros(0)}), "0 usable samples"),
    "no columns": Bad("a.parquet", parquet_file({}), "no column of numbers"),
    "texts in parquet": Bad("a.parquet", parquet_file({"x": ["a"] * 400}), "no column of numbers"),
    "lists in parquet": Bad("a.parquet", parquet_file({"x": [[1.0, 2.0]] * 400}), "no column of numbers"),
    "columns alike in parquet": Bad("a.parquet", parquet_file({"x [g]": WORDS, "x [mg]": WORDS}), "two columns named x"),
    "texts in hdf5": Bad("a.h5", hdf5(x=np.array([b"a"] * 400)), "no channel"),
    "nothing in hdf5": Bad("a.h5", hdf5(), "no channel"),
    "links in hdf5": Bad("a.h5", links, "no channel"),
    "groups without end": Bad("a.h5", nested_hdf5, "nests its groups too deep"),
    "text in mat": Bad("a.mat", mat(x="lorem"), "no channel"),
    "cells in mat": Bad("a.mat", mat(x=np.array([1, "a"], object)), "no channel"),
    "a function in mat": Bad("a.mat", mat5(FUNCTION), "no channel"),
    "cells without end": Bad("a.mat", nested_mat(20_000), "nests or divides"),
    "cells without number": Bad("a.mat", mat5(matrix(1, (1 << 30, 1))), "not a MAT-file that can"),
    "a structure of many": Bad("a.mat", mat5(matrix(2, (1 << 15, 1 << 15), element(5, struct.pack("<i", 8)), element(1, b"a".ljust(8, b"\0")))), "not a MAT-file that can"),
    "a header of version 4 that lies": Bad("a.mat", struct.pack("<5i", 0, 1 << 30, 1 << 30, 0, 2) + b"x\0" + bytes(99), "swells|not a MAT-file"),
    "a variable without numbers": Bad("a.mat", mat5(matrix(1, (1, 2), matrix(6, (1, 1)), matrix(6, (1, 1), element(9, bytes(8))))), "a part of it is missing"),
    "numbers of no type": Bad("a.mat", mat5(matrix(6, (1, 1), element(8, bytes(8)))), "of no known type"),
    # Bombs
    "a parquet that swells": Bad("a.parquet", bomb_parquet, "swells"),
    "a text said often": Bad("a.parquet", bomb_texts, "is constant"),
    "an hdf5 that swells": Bad("a.h5", bomb_hdf5, "swells"),
    "texts that are one": Bad("a.h5", bomb_references, "is constant"),
    "a mat that swells": Bad("a.mat", bomb_mat, "swells"),
    "a bag that swells": Bad("a.bag", bomb_bag, "larger than it may be|swells", ()),
    "an mcap that swells": Bad("a.mcap", bomb_mcap, "swells", ()),
    # What SQLite does by itself
    "messages in a journal": Bad("a.db3", unfinished, "a.db3 was not closed, and a.db3-wal", ()),
    "a question mark": Bad("a?mode=rw.db3", under("a"), "has a [?] in its path", ()),
    "a hash": Bad("a#b.db3", under("a"), "has a # in its path", ()),
    "a percent sign": Bad("a%62.db3", under("ab.db3"), "has a % in its path", ()),
}  # fmt: skip
