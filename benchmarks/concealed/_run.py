"""The tool on each recording, and nothing but the recording."""

import json
import subprocess
import time
import traceback
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import jax

import allanfit
from allanfit.whole_file import replacing


def run(folder: Path, workers: int, advance: Callable[[], object]) -> None:
    """Explain FOLDER/recordings/*.npz into FOLDER/results/*.json; those that exist stay."""
    files = sorted((folder / "recordings").glob("*.npz"))
    results = folder / "results"
    results.mkdir(exist_ok=True)
    waiting = [file for file in files if not (results / f"{file.stem}.json").exists()]
    for _ in range(len(files) - len(waiting)):
        advance()
    work = partial(_one, results, commit())
    if workers == 1:
        for file in waiting:
            work(file)
            advance()
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for _ in pool.map(work, waiting):
            advance()


def _one(results: Path, version: str, file: Path) -> None:
    jax.config.update("jax_enable_x64", True)
    start = time.perf_counter()
    document: dict = {"commit": version}
    try:
        document["explanation"] = allanfit.explain(allanfit.load(file), seed=0).to_dict()
    except Exception:  # A recording that fails counts as one; the others go on.
        document["error"] = traceback.format_exc()
    document["seconds"] = time.perf_counter() - start
    with replacing(results / f"{file.stem}.json") as part:
        part.write_text(json.dumps(document))


def commit() -> str:
    """The frozen code that is examined, `+` where files differ from it."""
    git = partial(subprocess.run, cwd=Path(__file__).parent, capture_output=True, text=True)
    changed = git(["git", "status", "--porcelain", "--", "../../src"]).stdout
    return git(["git", "rev-parse", "--short", "HEAD"]).stdout.strip() + "+" * bool(changed)
