# ruff: noqa: E501 - one case a line reads as the table that it is
"""Recordings that must be refused, and what has to be said: a new format is one more line."""

import gzip
import io
import os
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

RATE = ("--rate", "100")
WORDS = np.random.default_rng(5).standard_normal(400).round(6)
ROWS = "".join(f"{value}\n" for value in WORDS)
TABLE = f"gyro_x [deg/s]\n{ROWS}"
GARBAGE = np.random.default_rng(6).bytes(20_000)


class Bad(NamedTuple):
    """One file, and what is said of it."""

    file: str
    content: bytes | str | Callable[[Path], object]
    """What is in the file, or what makes it."""
    message: str
    """A pattern of the sentence."""
    options: tuple[str, ...] = RATE


class Runs:
    """A pickle that would leave a file named `ran` behind if it were read."""

    def __reduce__(self):
        return os.mkdir, ("ran",)


def npy(array: object, **options: bool) -> bytes:
    """An array as an `.npy` file."""
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def npz(**arrays: object) -> bytes:
    """Arrays as an `.npz` file."""
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def claiming(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    """An `.npy` file whose header claims more than there is."""
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape!r}, }}"
    padded = header.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded.encode() + bytes(64)


def bomb_npz(path: Path) -> None:
    """Hundreds of MB of zeros in a thousandth of that, written without ever holding them."""
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("gyro_x.npy", "w", force_zip64=True) as member,
    ):
        member.write(claiming((40 << 20,))[:-64])
        for _ in range(20):
            member.write(bytes(1 << 24))


def bomb_gz(path: Path) -> None:
    """Two GB of zeros in text, in 2 MB: parts of a gzip file may follow one another."""
    path.write_bytes(gzip.compress(b"0.0\n" * (1 << 22)) * 128)


def sparse(path: Path) -> None:
    """A terabyte that takes no room on the disk."""
    with path.open("wb") as stream:
        stream.truncate(1 << 40)


def ring(path: Path) -> None:
    """A link that leads back to itself."""
    other = path.with_name("other.csv")
    path.symlink_to(other)
    other.symlink_to(path)


def stamped(stamps: np.ndarray, **arrays: object) -> bytes:
    """A channel with time stamps and no other word on its rate."""
    return npz(gyro_x=WORDS[: stamps.size], time_s=stamps, **arrays)


CLOCK = np.arange(400) / 100
BAD = {
    # Nothing, or nothing but words
    "empty": Bad("a.csv", b"", "is empty"),
    "blank lines": Bad("a.csv", b"\n \n\n", "is empty"),
    "byte order mark alone": Bad("a.csv", b"\xef\xbb\xbf", "is empty"),
    "comments alone": Bad("a.csv", "# a\n# b\n", "no table of numbers"),
    "header alone": Bad("a.csv", "gyro_x,gyro_y\n", "no table of numbers"),
    "one line": Bad("a.csv", "1.5\n", "usable samples, and at least 256"),
    "words": Bad("a.csv", "lorem ipsum\n" * 500, "no table of numbers"),
    "a page": Bad("a.csv", "<html><body>404</body></html>\n" * 9, "no table of numbers"),
    # Of another kind than the name says
    "junk as text": Bad("a.csv", GARBAGE, "not plain text|no table"),
    "junk as npy": Bad("a.npy", GARBAGE, "not a complete .npy file"),
    "junk as npz": Bad("a.npz", GARBAGE, "not a complete .npz file"),
    "junk as gzip": Bad("a.csv.gz", GARBAGE, "not a complete gzip file"),
    "an archive as text": Bad("a.csv", npz(gyro_x=WORDS), "not plain text|no table"),
    "text as an archive": Bad("a.npz", TABLE, "not a complete .npz file"),
    "npy named npz": Bad("a.npz", npy(WORDS), "is an .npy file in truth: rename it"),
    "npz named npy": Bad("a.npy", npz(gyro_x=WORDS), "is an .npz file in truth: rename it"),
    "gzip without its ending": Bad("a.csv", gzip.compress(TABLE.encode()), "not plain text|gzip"),
    "gzip in gzip": Bad(
        "a.csv.gz", gzip.compress(gzip.compress(TABLE.encode())), "not plain text|gzip"
    ),
    "no ending": Bad("gyro", TABLE, "file type '' is not known"),
    "a picture": Bad("a.png", GARBAGE, "file type '.png' is not known"),
    # Cut off
    "npy cut off": Bad("a.npy", npy(WORDS)[:-100], "not a complete .npy file"),
    "npy cut in its header": Bad("a.npy", npy(WORDS)[:40], "not a complete .npy file"),
    "npz cut off": Bad("a.npz", npz(gyro_x=WORDS)[:-100], "not a complete .npz file"),
    "gzip cut off": Bad("a.csv.gz", gzip.compress(TABLE.encode())[:-9], "not a complete gzip file"),
    # Encodings
    "utf-16 and then junk": Bad(
        "a.csv", TABLE.encode("utf-16") + b"\x00\xdc" * 300, "saved as CSV in UTF-8"
    ),
    "utf-16 that is junk": Bad("a.csv", b"\xff\xfe" + GARBAGE, "not plain text|no table"),
    "utf-16 without a mark": Bad("a.csv", TABLE.encode("utf-16-le"), "saved as CSV in UTF-8"),
    "nul bytes far below": Bad(
        "a.csv", TABLE.encode() * 30 + b"\0" * 50, "(?i)nul|not plain text|not a number"
    ),
    # How numbers are written
    "decimal commas between commas": Bad(
        "a.csv", "".join(f"{v:.4f}".replace(".", ",") + "\n" for v in WORDS), "decimal commas"
    ),
    "decimal commas below a header": Bad(
        "a.csv", "gyro_x\n" + ROWS.replace(".", ","), "decimal commas"
    ),
    "thousands, quoted": Bad(
        "a.csv", "".join(f'"{1e4 * v:,.2f}"\n' for v in WORDS), "separators of thousands"
    ),
    "thousands below a header": Bad(
        "a.csv", "gyro_x\n" + "".join(f"{1e4 * abs(v) + 2e3:,.2f}\n" for v in WORDS), "field"
    ),
    "thousands with blanks": Bad(
        "a.csv",
        "x;y\n" + "".join(f"{1e4 * abs(v) + 2e3:,.2f};1\n".replace(",", " ") for v in WORDS),
        "separators of thousands",
    ),
    "commas and blanks": Bad("a.csv", "".join(f"0,5 {v}\n" for v in WORDS), "mixes|decimal"),
    "semicolons, then commas": Bad("a.csv", "1;2\n" * 300 + "1,2\n" * 300, "line 301 has 1 field,"),
    "a word among numbers": Bad("a.csv", ROWS + "overrun\n" + ROWS, "line 401.*'overrun'"),
    "text beside numbers": Bad("a.csv", "1.0,ok\n" * 400, "mixes numbers and text"),
    "too many fields": Bad("a.csv", "a,b\n" + "1,2\n" * 300 + "1,2,3\n", "line 302 has 3 fields"),
    "too few fields": Bad("a.csv", "a,b\n" + "1,2\n3,4\n" * 200 + "5\n6,7\n", "line 402 has 1 field,"),
    "hexadecimal": Bad("a.csv", "0x1F\n0x2A\n" * 300, "no table|not a number"),
    "an open quotation mark": Bad("a.csv", TABLE + '"1.0\n' + ROWS, "quotation mark|not a number"),
    "a quotation mark at the end": Bad("a.csv", ROWS + '"', "quotation mark"),
    "columns that are alike": Bad("a.csv", "x,x\n" + "1,2\n3,4\n" * 200, "two columns named x"),
    "titles without a header": Bad("a.csv", f"Logger\nRun 3\n{ROWS}", "correct it or begin it with #"),
    "two tables": Bad("a.csv", f"x\n{ROWS[:300]}x,y\n" + "1,2\n3,4\n" * 200, "no titles alone"),
    "two rows of units": Bad("a.csv", "x,y\ndeg/s,deg/s\ng,g\n" + "1,2\n3,4\n" * 200, "two columns named g"),
    "thousands with points": Bad("a.csv", "t;x\n" + "1.000.000;3.384\n" * 300, "separators of thousands"),
    "thousands with points in the clock": Bad(
        "a.csv", "t;x\n" + "".join(f"{k:,};3\n".replace(",", ".") for k in range(0, 9000, 10)), "'1.000' has separators of thousands"
    ),
    "thousands far below": Bad(
        "a.csv", "t;x\n" + "".join(f"{k}.5;3\n" for k in range(20_000)) + "1.000.000;3\n", "line 20002: '1.000.000' has separators"
    ),
    # Size and shape of the text
    "a very long line": Bad("a.csv", "1," * 3_000_000 + "1\n", "lines of more than 64 kB"),
    "a very long header": Bad("a.csv", "x" * 300_000 + "\n" + ROWS, "lines of more than 64 kB"),
    "blanks without end": Bad("a.csv", "x,y\n" + "1,2\n3,4\n" * 200 + "1," + "5" + " " * 2_000_000 + "z\n", "line 402, column y: '5 .*is not a number"),
    "brackets without end": Bad("a.txt", "a(" * 30_000 + "\n" + ROWS, "long|field|table"),
    "a header of blanks": Bad("a.csv", "a" + " " * 60_000 + "b[\n" + ROWS, "2 fields and the numbers below it 1"),
    "a thousand columns of nothing": Bad("a.csv", "," * 1000 + "\n", "no table of numbers"),
    # What the samples say
    "nan alone": Bad("a.csv", "gyro_x\n" + "nan\n" * 400, "0 usable samples"),
    "inf alone": Bad("a.csv", "gyro_x\n" + "inf\n-inf\n" * 400, "0 usable samples"),
    "runs of nan": Bad("a.csv", ("1.0\n2.5\n" * 5 + "nan\n") * 40, "0 usable samples"),
    "constant": Bad("a.csv", "0.25\n" * 400, "is constant"),
    "zeros of both signs": Bad("a.npy", npy(np.resize([0.0, -0.0], 400)), "is constant"),
    "a counter": Bad("a.npy", npy(np.arange(400)), "changes the same way at every sample"),
    "huge": Bad("a.npy", npy(1e300 * WORDS), r"as large as .*e\+300"),
    "one huge value": Bad("a.npy", npy(np.append(WORDS, 1e200)), r"as large as 1e\+200"),
    "denormal": Bad("a.npy", npy(np.resize([0.0, 5e-324], 400)), "5e-324"),
    "tiny": Bad("a.npy", npy(1e-200 * WORDS), "e-200"),
    "as a float32 overflows": Bad(
        "a.npy", npy(np.full(400, np.float32(np.inf))), "0 usable samples"
    ),
    # Kinds of arrays
    "complex": Bad("a.npy", npy(WORDS + 1j), "type complex128, and real numbers"),
    "bool": Bad("a.npy", npy(WORDS > 0), "type bool"),
    "text in an array": Bad("a.npy", npy(WORDS.astype("U8")), "type <U8"),
    "dates": Bad("a.npy", npy(np.arange(400).astype("M8[s]")), "type datetime64"),
    "three axes": Bad("a.npy", npy(np.zeros((9, 9, 9))), r"shape \(9, 9, 9\)"),
    "no axis": Bad("a.npy", npy(np.float64(3.0)), r"shape \(\)"),
    "no samples": Bad("a.npy", npy(np.zeros(0)), "0 usable samples"),
    "no samples of no channels": Bad("a.npy", npy(np.zeros((0, 0))), "no inertial|0 usable|no ch"),
    "python objects": Bad("a.npy", npy(np.array([Runs()]), allow_pickle=True), "can run code"),
    "python objects in an archive": Bad("a.npz", npz(x=np.array([Runs()])), "can run code"),
    "a bare pickle as npy": Bad("a.npy", pickle.dumps(Runs()), "not a complete .npy|can run code"),
    "a bare pickle as npz": Bad("a.npz", pickle.dumps(Runs()), "not a complete .npz|can run code"),
    "a header that lies": Bad("a.npy", claiming((1 << 50,)), "not a complete .npy file"),
    "a header beyond counting": Bad("a.npy", claiming((1 << 70,)), "not a complete .npy file"),
    "a header of less than nothing": Bad("a.npy", claiming((-5,)), "not a complete .npy file"),
    "a header that computes": Bad("a.npy", claiming((9**9,), "9**9**9"), "not a complete .npy"),
    "an archive of nothing": Bad("a.npz", npz(), "holds no channel|not a complete"),
    "an archive of text": Bad("a.npz", npz(gyro_x="many"), "holds no channel"),
    "lengths that differ": Bad("a.npz", npz(a=WORDS, b=WORDS[1:]), "a has 400 and b has 399"),
    "units that are no JSON": Bad("a.npz", npz(a=WORDS, units="deg/s"), "must be a JSON string"),
    "units that are a list": Bad("a.npz", npz(a=WORDS, units="[1]"), "must be a JSON string"),
    "units without bottom": Bad("a.npz", npz(a=WORDS, units="[" * 100_000), "must be a JSON"),
    "an unknown unit in an archive": Bad(
        "a.npz", npz(a=WORDS, units='{"a": "furlong"}'), "unit 'furlong' is not known"
    ),
    # Bombs
    "an archive that swells": Bad("a.npz", bomb_npz, "unpack"),
    "a text that swells": Bad("a.csv.gz", bomb_gz, "unpack"),
    "a sparse terabyte": Bad(
        "a.csv", sparse, "memory"
    ),
    "a sparse terabyte of npz": Bad(
        "a.npz", sparse, "memory"
    ),
    # What is no plain file
    "a folder": Bad("a.csv", Path.mkdir, "is a folder: give the file"),
    "a link to nothing": Bad("a.csv", lambda p: p.symlink_to(p.with_name("none")), "no file"),
    "a link to a folder": Bad("a.csv", lambda p: p.symlink_to("/tmp"), "is a folder"),
    "links in a ring": Bad("a.csv", ring, "no file|cannot be read"),
    "a pipe": Bad("a.csv", os.mkfifo, "not a file|plain file"),
    "a device without end": Bad("a.csv", lambda p: p.symlink_to("/dev/zero"), "plain file"),
    "the memory of the process": Bad("a.npz", lambda p: p.symlink_to("/proc/self/mem"), "empty"),
    # Time stamps
    "stamps that stand still": Bad("a.npz", stamped(np.ones(400)), "do not increase", ()),
    "stamps backwards": Bad("a.npz", stamped(CLOCK[::-1]), "earlier than the one before", ()),
    "stamps of nothing": Bad("a.npz", stamped(np.full(400, np.nan)), "missing or not finite", ()),
    "stamps to infinity": Bad("a.npz", stamped(np.full(400, np.inf)), "missing or not fin", ()),
    "stamps of other length": Bad("a.npz", npz(x=WORDS, time_s=CLOCK[1:]), "equally many", ()),
    "stamps of 1e-300 s": Bad("a.npz", stamped(CLOCK * 1e-300), "rate", ()),
    "stamps of 1e300 s": Bad("a.npz", stamped(CLOCK * 1e300), "rate|stamps", ()),
    "stamps beyond integers": Bad(
        "a.csv", "time [ns],x\n" + "".join(f"{10**25 + k},{v}\n" for k, v in enumerate(WORDS)),
        "do not increase", (),
    ),
    "stamps in words": Bad(
        "a.csv", "time,x\n" + "".join(f"2024-01-01 12:00:{v},{v}\n" for v in WORDS), "--rate", ()
    ),
    "stamps in another unit": Bad(
        "a.csv", "time [weeks],x\n" + "".join(f"{k},{v}\n" for k, v in enumerate(WORDS)),
        "unit 'weeks'", (),
    ),
    # What was asked
    "no rate": Bad("a.csv", TABLE, "give it with --rate", ()),
    "a negative rate": Bad("a.csv", TABLE, "rate is a", ("--rate", "-5")),
    "a rate of 0": Bad("a.csv", TABLE, "rate is a", ("--rate", "0")),
    "a rate of nan": Bad("a.csv", TABLE, "rate is a", ("--rate", "nan")),
    "a rate of inf": Bad("a.csv", TABLE, "rate is a", ("--rate", "inf")),
    "a rate of 1e308": Bad("a.csv", TABLE, "rate is a", ("--rate", "1e308")),
    "a rate of 1e-308": Bad("a.csv", TABLE, "rate is a", ("--rate", "1e-308")),
    "a rate in the file of nan": Bad("a.npz", npz(x=WORDS, rate_hz=np.nan), "rate_hz in a.npz", ()),
    "rates in the file": Bad("a.npz", npz(x=WORDS, rate_hz=[1, 2]), "single number", ()),
    "a rate in words": Bad("a.npz", npz(x=WORDS, rate_hz="fast"), "single number", ()),
    "an unknown unit": Bad("a.csv", ROWS, "unit 'furlong' is not known", (*RATE, "--unit", "furlong")),
    "a unit that computes": Bad("a.csv", ROWS, "is not known", (*RATE, "--unit", "9**9**9")),
    "a unit of powers": Bad("a.csv", ROWS, "not known", (*RATE, "--unit", "deg**9**9**9/s")),
    "a unit that imports": Bad("a.csv", ROWS, "not known", (*RATE, "--unit", "__import__('os')")),
    "a unit without end": Bad("a.csv", ROWS, "not known", (*RATE, "--unit", "deg/s*" * 10_000)),
    "a unit of many ways to be none": Bad(
        "a.csv", ROWS, "not known", (*RATE, "--unit", "_" * 33 + "9")
    ),
    "a unit in two lines": Bad("a.csv", ROWS, "is not known", (*RATE, "--unit", "deg\n/\x1b[2Js!")),
    "a unit that does not fit": Bad("a.csv", TABLE, "fits none", (*RATE, "--unit", "m/s^2")),
    "a unit that computes in a header": Bad("a.csv", f"x [9**9**9]\n{ROWS}", "is not known"),
    "a channel that is not there": Bad("a.csv", TABLE, "no channel q", (*RATE, "--channel", "q")),
    "a channel of control characters": Bad(
        "a.csv", TABLE, "no channel", (*RATE, "--channel", "\x1b[31mq\nr\r\u202e")
    ),
}  # fmt: skip


def make(folder: Path, bad: Bad) -> Path:
    """The file of a case."""
    path = folder / bad.file
    if callable(bad.content):
        bad.content(path)
    else:
        path.write_bytes(bad.content.encode() if isinstance(bad.content, str) else bad.content)
    return path
