"""The sealed set on disk: recordings that the tool sees, and a key that it does not.

FOLDER/recordings/00000.npz ...   data, rate_hz, units, perhaps temperature and time_s
FOLDER/key.json                   what is concealed in each
FOLDER/seal.txt                   SHA-256 of the key, written before anything is analysed
"""

import hashlib
import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from allanfit.whole_file import replacing

from ._catalogue import draw, plans
from ._device import simulate
from ._effect import Effect


class SealBroken(Exception):
    """The key is not the one that was sealed."""


def seal(folder: Path, answers: Sequence[dict]) -> str:
    """Write the key and its digest; returns the digest."""
    text = json.dumps({"schema": "concealed/1", "recordings": list(answers)}, indent=1) + "\n"
    for name, content in (("key.json", text), ("seal.txt", digest(text.encode()) + "\n")):
        with replacing(folder / name) as part:
            part.write_text(content)
    return digest(text.encode())


def open_key(folder: Path) -> list[dict]:
    """The answers, if they are those that were sealed."""
    content = (folder / "key.json").read_bytes()
    sealed = (folder / "seal.txt").read_text().strip()
    if digest(content) != sealed:
        raise SealBroken(f"{folder / 'key.json'} has changed since it was sealed as {sealed}")
    return json.loads(content)["recordings"]


def digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def conceal(
    folder: Path, recordings: int, seed: int, workers: int, advance: Callable[[], object]
) -> str:
    """Simulate the set, or what of it is missing; returns the digest of its key."""
    (folder / "recordings").mkdir(parents=True, exist_ok=True)
    if (folder / "seal.txt").exists():
        if len(open_key(folder)) != recordings:
            raise ValueError(f"{folder} holds a set of another size; name another --folder.")
        for _ in range(recordings):
            advance()
        return (folder / "seal.txt").read_text().strip()
    answers = []
    make = partial(_make, folder, seed)
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for answer in pool.map(make, *zip(*enumerate(plans(seed, recordings)), strict=True)):
            answers.append(answer)
            advance()
    return seal(folder, answers)


def _make(folder: Path, seed: int, index: int, kinds: tuple[type[Effect], ...]) -> dict:
    concealed = draw(kinds, (seed, 1, index))
    name = f"{index:05d}"
    file = folder / "recordings" / f"{name}.npz"
    if not file.exists():
        log = simulate(
            concealed.device, concealed.effects, concealed.surroundings, (seed, 2, index)
        )
        write_recording(file, log, concealed.device.rate_hz, concealed.device.unit)
    return {"recording": name, **concealed.answer()}


def write_recording(file: Path, log: dict[str, np.ndarray], rate_hz: float, unit: str) -> None:
    units = {"data": unit} | ({"temperature": "degC"} if "temperature" in log else {})
    with replacing(file) as part, part.open("wb") as stream:
        np.savez(stream, **log, rate_hz=rate_hz, units=json.dumps(units))
