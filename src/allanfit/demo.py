"""The main job on a recording that is made here, so that its truth is known."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from .identify import RecordingFit, fit_recording
from .recording import load, save
from .report import figure, write_json, write_page
from .simulate import simulate
from .whole_file import replacing

#: A consumer gyro, in deg/s and seconds; Q and R are absent, and must not be found.
TRUTH = {"Q": 0.0, "N": 5e-3, "B": 2e-3, "K": 2e-4, "R": 0.0}
_RATE_HZ = 100.0
_DURATION_S = 3600.0


def demonstrate(
    folder: Path, seed: int, announce: Callable[[str], None]
) -> tuple[RecordingFit, Path]:
    """Simulate, save, load, fit; write recording, JSON, figure and page into `folder`.

    **Returns:** the fit, and the page's path. `announce` is told of each stage.

    **Raises:** `ValueError` or `OSError` if the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    samples = simulate(TRUTH, duration_s=_DURATION_S, rate_hz=_RATE_HZ, seed=seed, bias=0.3)
    file = folder / "gyro.npz"
    save(file, {"gyro_x": np.asarray(samples)}, {"gyro_x": "deg/s"}, _RATE_HZ)
    announce("identifying its noise")
    result = fit_recording(load(file), seed=seed)
    announce("drawing the page")
    document = result.to_dict()
    write_json(document, str(folder / "fit.json"))
    with replacing(folder / "figure.png") as part:
        figure(document["channels"][0]).savefig(part, dpi=150)
    page = folder / "report.html"
    write_page(document, page)
    return result, page
