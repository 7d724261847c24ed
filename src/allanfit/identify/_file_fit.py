"""The fit of a file larger than memory: `fit_file`."""

import hashlib
import os
from dataclasses import replace
from typing import Any

import jax
import numpy as np

from ..curves import LongStatistics
from ..datasheet import Datasheet
from ..file_curves import findings_of, read_statistics
from ..physics import STANDARD_TERMS, Sampling
from ..recording import Channel, Recording, read_in_blocks
from ._estimate import estimate_from
from ._fit import Fit
from ._recording_fit import ChannelFit, RecordingFit
from ._sample import sample


def fit_file(
    path: str | os.PathLike[str],
    *,
    posterior: bool = True,
    sampling: Sampling = "point",
    datasheet: Datasheet | None = None,
    seed: int = 0,
    **options: Any,
) -> RecordingFit:
    """Fit every channel of a file in one pass, in bounded memory.

    The model, the likelihood and the intervals are those of `allanfit.fit`. The spectrum is
    averaged over segments of 262144 samples above 1/8192 of the sampling rate, and that of the
    whole record below. Influence of pieces and effects of temperature need the samples in memory,
    and are not told. In the result, the `samples` of a channel are their mean alone, and the
    checksum is that of the curves.

    **Arguments:** `posterior`, `sampling`, `datasheet` and `seed` as in `fit_recording`; the others
    are those of `allanfit.recording.read_in_blocks`.

    **Raises** `RecordingError` when the file cannot be used, `DatasheetError` if the data sheet
    does not go with it.
    """
    blocks = read_in_blocks(path, **options)
    if datasheet is not None:
        datasheet.check(blocks.name, blocks.channels)
    statistics = read_statistics(blocks)
    digest = hashlib.sha256()
    channels = tuple(
        _with_mean(channel, statistics[channel.name])
        for channel in blocks.channels
        if channel.name in statistics
    )
    fits = []
    for channel in channels:
        found, layout = statistics[channel.name].value(sampling)
        digest.update(np.asarray(found.allan, np.float64).data)
        digest.update(np.asarray(found.density, np.float64).data)
        estimate = estimate_from(found, layout, 1 / blocks.rate_hz, jax.random.key(seed))
        fits.append(Fit(estimate, layout, blocks.rate_hz))
    recording = Recording(
        name=blocks.name,
        rate_hz=blocks.rate_hz,
        channels=channels,
        auxiliary=(),
        findings=findings_of(blocks, statistics),
        checksum=digest.hexdigest(),
        lost=blocks.lost,
    )
    entries = []
    for channel, result in zip(channels, fits, strict=True):
        drawn = None
        if posterior and bool(result.converged):
            drawn = sample(result, seed=seed)
            result = result.with_draws(drawn.draws.reshape(-1, len(STANDARD_TERMS)))
        entries.append(ChannelFit(channel, result, drawn, datasheet=datasheet))
    return RecordingFit(recording, tuple(entries))


def _with_mean(channel: Channel, taken: LongStatistics) -> Channel:
    return replace(channel, samples=np.array([taken.mean]), stretches=((0, 1),))
