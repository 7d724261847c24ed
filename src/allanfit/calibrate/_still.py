"""Cutting a recording of a triad that is moved from position to position into its rests."""

import numpy as np
from jaxtyping import Float64

from ..recording import Recording

_WINDOW_S = 1.0
_FEWEST_IN_WINDOW = 20
# Of the quietest tenth of the windows: hands do at least ten times as much.
_LOUD = 2.0
_QUIET_QUANTILE = 0.1
# A jump of the mean this large, of gravity, is another position even if no window saw it move.
_JUMP = 0.02
_FEWEST_WINDOWS = 2


def still_means(
    recording: Recording, gravity: float
) -> tuple[Float64[np.ndarray, "positions 3"], float]:
    """Means of the rests [SI], and their shortest length [s].

    Windows of a second whose standard deviation is at most twice that of the quietest ones are at
    rest. Of each run of them the first and the last are dropped, where the sensor may still have
    swung, and two more must be left.

    **Raises:** `ValueError` when a window holds too few samples to tell.
    """
    size = round(_WINDOW_S * recording.rate_hz)
    if size < _FEWEST_IN_WINDOW:
        raise ValueError(
            f"{recording.name} has {recording.rate_hz:.3g} samples a second, and finding where the "
            f"sensor was at rest takes {_FEWEST_IN_WINDOW}; give a table of means, ax, ay, az."
        )
    samples = np.stack([channel.samples for channel in recording.channels], axis=1)
    count = len(samples) // size
    windows = samples[: count * size].reshape(count, size, 3)
    means = windows.mean(axis=1)
    scatter = np.sqrt(windows.var(axis=1).sum(axis=1))
    # A missing sample makes its window NaN, which is not at rest.
    finite = np.isfinite(scatter)
    if not finite.any():
        return np.empty((0, 3)), 0.0
    quiet = finite & (scatter <= _LOUD * np.quantile(scatter[finite], _QUIET_QUANTILE))
    rests = [run[1:-1] for run in _runs(quiet, means, _JUMP * gravity)]
    rests = [run for run in rests if len(run) >= _FEWEST_WINDOWS]
    shortest = min((len(run) for run in rests), default=0) * size / recording.rate_hz
    return np.array([means[run].mean(axis=0) for run in rests]).reshape(-1, 3), shortest


def _runs(
    quiet: np.ndarray, means: Float64[np.ndarray, "windows 3"], jump: float
) -> list[np.ndarray]:
    """Indices of consecutive quiet windows whose mean stays where it is."""
    index = np.flatnonzero(quiet)
    if not len(index):
        return []
    moved = np.linalg.norm(np.diff(means[index], axis=0), axis=1) > jump
    return np.split(index, np.flatnonzero((np.diff(index) > 1) | moved) + 1)
