"""NumPy's own files: one array (`.npy`), or named arrays together (`.npz`)."""

import math
import tokenize
import zipfile
import zlib
from collections.abc import Generator, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ._damage import each_guarded, quiet
from ._files import refuse_bomb
from ._names import UNITS_EXAMPLE, is_rate, is_unit, units_by_channel
from ._recording import Block, RecordingError, Table, table_blocks

# What NumPy and zipfile raise on bytes that are not what they should be.
_DAMAGE = (
    ValueError,
    TypeError,
    KeyError,
    EOFError,
    OSError,
    MemoryError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)
# Not channels, but what holds for all of them.
_ABOUT = ("units", "rate_hz")


def read_npy(path: Path) -> Table:
    """A channel, or one column a channel, or one field of a structured array a channel.

    **Raises** `RecordingError` when the file is damaged or holds anything else.
    """
    return _columns(path, _read(path))


def npy_blocks(path: Path, samples: int) -> Iterator[Block]:
    """The same in blocks of so many samples, from a memory map."""
    with _careful(path):
        mapped = np.lib.format.open_memmap(path, "r")
    yield from table_blocks(_columns(path, mapped), samples)


def _columns(path: Path, array: np.ndarray | dict[str, np.ndarray]) -> Table:
    if not isinstance(array, np.ndarray):
        raise RecordingError(f"{path.name} is an .npz file in truth: rename it.")
    if array.dtype.names is not None:
        columns = {name: array[name] for name in array.dtype.names}
        for name, column in columns.items():
            _check(path, name, column)
        return Table(columns, {})
    _check(path, "the array", array, axes=(1, 2))
    if array.ndim == 1:
        return Table({"data": array}, {})
    # A recording has more samples than channels, whichever way round it was saved.
    rows = array if array.shape[1] > array.shape[0] else array.T
    if len(rows) == 1:
        return Table({"data": rows[0]}, {})
    return Table({f"channel_{k}": row for k, row in enumerate(rows, start=1)}, {})


def read_npz(path: Path) -> Table:
    """Each 1-D array a channel, `rate_hz` a single number, `units` a JSON string.

    **Raises** `RecordingError` when the file is damaged or an array cannot be used.
    """
    arrays = _read(path)
    if isinstance(arrays, np.ndarray):
        raise RecordingError(f"{path.name} is an .npy file in truth: rename it.")
    return _arrays(path, arrays)


def _arrays(path: Path, arrays: dict[str, np.ndarray]) -> Table:
    units = units_by_channel(path.name, arrays.pop("units", None))
    rate_hz = _rate(path, arrays.pop("rate_hz", None))
    columns, findings = {}, ()
    for name, array in arrays.items():
        if array.ndim == 1 and array.dtype.kind in "iuf":
            columns[name] = array
        elif array.ndim > 0:
            findings += (
                f"The array {name} is left out: a channel is a 1-D array of real numbers, and it "
                f"is {array.ndim}-D of {array.dtype}.",
            )
        elif is_rate(name):
            findings += (f"The number {name} is not read: the sampling rate is `rate_hz`, in Hz.",)
        elif is_unit(name):
            findings += (
                f"The value {name} is not read: units are `units`, a JSON string that gives each "
                f"channel a unit, such as '{UNITS_EXAMPLE}'.",
            )
    if not columns:
        raise RecordingError(f"{path.name} holds no channel: store each as a 1-D array of numbers.")
    return Table(columns, units, rate_hz, findings)


def npz_blocks(path: Path, samples: int) -> Iterator[Block]:
    """The same in blocks of so many samples, compressed or not.

    An array that is shorter than the longest ends before it, so that whoever uses both sees it.
    """
    yield from each_guarded(lambda: _careful(path), _npz_blocks(path, samples))


def _npz_blocks(path: Path, samples: int) -> Generator[Block, None, None]:
    with ExitStack() as stack:
        archive = stack.enter_context(zipfile.ZipFile(path))
        whole, series = {}, {}
        for member in archive.namelist():
            stream = stack.enter_context(archive.open(member))
            name, (shape, dtype) = member.removesuffix(".npy"), _header(stream)
            if name in _ABOUT and math.prod(shape) == 1:
                whole[name] = np.frombuffer(stream.read(dtype.itemsize), dtype).reshape(shape)
            elif len(shape) == 1 and dtype.kind in "iuf" and name not in _ABOUT:
                series[name] = (stream, shape[0], dtype)
            else:
                # Not read: its shape and type alone are told.
                whole[name] = np.broadcast_to(np.zeros((), dtype), shape)
        rows = max((size for _, size, _ in series.values()), default=0)
        for start in range(0, max(rows, 1), samples):
            stop = min(start + samples, rows)
            arrays = whole | {
                name: _next(stream, dtype, max(min(stop, size) - start, 0))
                for name, (stream, size, dtype) in series.items()
            }
            yield Block(_arrays(path, arrays), stop, rows)


def _next(stream: Any, dtype: np.dtype, count: int) -> np.ndarray:
    if count == 0:
        return np.empty(0, dtype)
    return np.frombuffer(stream.read(count * dtype.itemsize), dtype, count)


def _header(stream: Any) -> tuple[tuple[int, ...], np.dtype]:
    """The shape and the type of the array that follows."""
    version = np.lib.format.read_magic(stream)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }[version]
    shape, _, dtype = read(stream)
    if dtype.hasobject:
        # In the words of NumPy, which refuses them where it reads a whole file.
        raise ValueError("Object arrays cannot be loaded when allow_pickle=False")
    return shape, dtype


def _read(path: Path) -> np.ndarray | dict[str, np.ndarray]:
    with path.open("rb") as file, _careful(path):
        # Pickles run code when they are read, so no file may hold one.
        content = np.load(file, allow_pickle=False)
        if isinstance(content, np.ndarray):
            return content
        refuse_bomb(path, sum(member.file_size for member in content.zip.infolist()))
        return {name: np.asarray(content[name]) for name in content.files}


@contextmanager
def _careful(path: Path) -> Iterator[None]:
    # NumPy warns of files that are slow to read because Python 2 wrote them.
    with quiet():
        try:
            yield
        except RecordingError:
            raise
        except _DAMAGE as error:
            raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception) -> RecordingError:
    if "allow_pickle" in str(error) and "Object arrays" in str(error):
        return RecordingError(
            f"{path.name} holds Python objects, which are not read because they can run code: "
            "save plain arrays of numbers."
        )
    return RecordingError(
        f"{path.name} is not a complete {path.suffix} file: it may be cut off or of another kind."
    )


def _check(path: Path, name: str, array: np.ndarray, axes: tuple[int, ...] = (1,)) -> None:
    if array.dtype.kind not in "iuf":
        raise RecordingError(
            f"{path.name}: {name} has values of type {array.dtype}, and real numbers are needed."
        )
    if array.ndim not in axes:
        raise RecordingError(
            f"{path.name}: {name} has shape {array.shape}, and (samples,) or (samples, channels) "
            "is needed."
        )


def _rate(path: Path, array: np.ndarray | None) -> float | None:
    if array is None:
        return None
    if array.size != 1 or array.dtype.kind not in "iuf":
        raise RecordingError(f"{path.name}: rate_hz must be a single number; pass --rate instead.")
    return float(array.item())
