"""Both curves of a file in one pass, in bounded memory: `curves_of_file`."""

import os
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from .curves import LongStatistics
from .recording import Blocks, RecordingError, read_in_blocks
from .recording._blocks import Run
from .recording._checks import FEWEST_SAMPLES
from .recording._wording import left_out


@dataclass(frozen=True)
class ChannelCurves:
    """Both curves of one channel, in its SI unit."""

    name: str
    si_unit: str
    samples: int
    """In stretches of at least 16 samples."""
    mean: float
    """[u], with u = si_unit."""
    tau_s: Float[np.ndarray, " sizes"]
    """Averaging times [s]."""
    allan_variance: Float[np.ndarray, " sizes"]
    """[u^2]."""
    frequency_hz: Float[np.ndarray, " bins"]
    """Mean frequency of each bin [Hz]."""
    density: Float[np.ndarray, " bins"]
    """One-sided power spectral density [u^2/Hz], the rate ramp taken out."""
    ordinates: Float[np.ndarray, " bins"]
    """How many ordinates each bin averages, each of one degree of freedom."""
    findings: tuple[str, ...]


@dataclass(frozen=True)
class FileCurves:
    """The curves of all channels of a file."""

    name: str
    rate_hz: float
    channels: tuple[ChannelCurves, ...]
    findings: tuple[str, ...]
    """About the file and its time stamps."""

    def __getitem__(self, name: str) -> ChannelCurves:
        """The channel of that name; `KeyError` if there is none."""
        return {channel.name: channel for channel in self.channels}[name]


def curves_of_file(path: str | os.PathLike[str], **options: Any) -> FileCurves:
    """Allan variance and PSD of each channel of a file larger than memory.

    Both are those that a fit uses: overlapping variances pooled over the stretches between gaps,
    and the mirror spectrum with the rate ramp taken out, in 16 bins a decade.

    **Arguments:** those of `allanfit.recording.read_in_blocks`: `rate_hz`, `channels`, `unit`,
    `topic`, `block_samples` and `progress`.

    **Raises** `RecordingError` when the file cannot be used.

    ```python
    curves = allanfit.curves_of_file("week.h5", rate_hz=400.0, unit="deg/s")
    curves["gyro_x"].tau_s, curves["gyro_x"].allan_variance
    ```
    """
    blocks = read_in_blocks(path, **options)
    statistics = read_statistics(blocks)
    rate_hz, found = blocks.rate_hz, []
    for channel in blocks.channels:
        if channel.name in statistics:
            taken = statistics[channel.name]
            values, design = taken.value()
            found.append(
                ChannelCurves(
                    name=channel.name,
                    si_unit=channel.si_unit,
                    samples=sum(taken.lengths),
                    mean=taken.mean,
                    tau_s=np.asarray(design.cluster_sizes) / rate_hz,
                    allan_variance=np.asarray(values.allan),
                    frequency_hz=np.asarray(design.frequency) * rate_hz,
                    density=np.asarray(values.density) / rate_hz,
                    ordinates=np.asarray(design.ordinates),
                    findings=channel.findings,
                )
            )
    return FileCurves(blocks.name, rate_hz, tuple(found), findings_of(blocks, statistics))


def read_statistics(blocks: Blocks) -> dict[str, LongStatistics]:
    """Take all samples in; the statistics of the channels that can be analysed.

    **Raises** `RecordingError` when none can.
    """
    taken = {channel.name: LongStatistics() for channel in blocks.channels}
    # Channels are taken in side by side, while the file is read on. Each waits for its last run,
    # which keeps the order, and memory bounded.
    working: dict[str, Future] = {}
    with ThreadPoolExecutor() as pool:
        for run in blocks:
            if run.channel in working:
                working[run.channel].result()
            working[run.channel] = pool.submit(_take, taken[run.channel], run)
        for each in working.values():
            each.result()
    for each in taken.values():
        each.end_stretch()
    usable = {name: each for name, each in taken.items() if not _why_useless(each)}
    if not usable:
        name, first = next(iter(taken.items()))
        raise RecordingError(
            f"{blocks.name}: channel {name} cannot be analysed: {_why_useless(first)}."
        )
    return usable


def _take(taken: LongStatistics, run: Run) -> None:
    taken.add(run.samples)
    if run.ends:
        taken.end_stretch()


def findings_of(blocks: Blocks, statistics: dict[str, LongStatistics]) -> tuple[str, ...]:
    """Those of the file, and one for each channel that is not among the statistics."""
    useless = [channel.name for channel in blocks.channels if channel.name not in statistics]
    return (
        *blocks.findings,
        *left_out({"it is constant or has too few samples": useless} if useless else {}),
        "Read in blocks: saturation, repeats and code width are told of the first block alone, "
        "effects of temperature and the influence of pieces not at all.",
    )


def _why_useless(taken: LongStatistics) -> str:
    samples = sum(taken.lengths)
    if samples < FEWEST_SAMPLES:
        return f"it has {samples} usable samples, and at least {FEWEST_SAMPLES} are needed"
    return "it is constant" if taken.constant else ""
