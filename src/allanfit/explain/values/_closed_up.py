"""A channel without values that are missing a few at a time, as if they were lost on the way.

Left where they are they divide the record at each, and what is slow, or as narrow as a line, would
have to be seen in one stretch.
"""

from collections import Counter
from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from ...recording import Channel, Recording

# More at a time are a pause, in which the sensor may have become another one.
_FEW = 32


def closed_up(channel: Channel, recording: Recording) -> tuple[Channel, Recording]:
    """The channel, and the recording with what is beside it, closed up alike.

    Where each missing value was is told by the `losses` of the recording; its channels stay.
    """
    kept, stretches = _kept(channel)
    if kept.all():
        return channel, recording
    moved = np.concatenate([[0], np.cumsum(kept)])
    losses = Counter({int(moved[after]): 0 for after, _ in recording.losses})
    for after, count in recording.losses:
        losses[int(moved[after])] += count
    gone = np.flatnonzero(~kept)
    # All that are missing between two that are kept come before the second.
    for after, count in zip(*np.unique(moved[gone], return_counts=True), strict=True):
        losses[int(after)] += int(count)
    closed = replace(
        channel,
        samples=channel.samples[kept],
        stretches=tuple((int(moved[start]), int(moved[stop])) for start, stop in stretches),
    )
    beside = tuple(
        replace(
            each,
            samples=each.samples[kept],
            stretches=tuple((int(moved[a]), int(moved[b])) for a, b in each.stretches),
        )
        if each.samples.size == kept.size
        else each
        for each in recording.auxiliary
    )
    return closed, replace(recording, auxiliary=beside, losses=tuple(sorted(losses.items())))


def _kept(channel: Channel) -> tuple[Bool[np.ndarray, " samples"], list[tuple[int, int]]]:
    """Which samples stay, and the stretches with those joined between which few are missing."""
    kept = np.ones(channel.samples.size, bool)
    joined = [channel.stretches[0]]
    for start, stop in channel.stretches[1:]:
        before = joined[-1][1]
        missing = ~np.isfinite(channel.samples[before:start])
        # What the clock divides has nothing between.
        if 0 < start - before <= _FEW and missing.any():
            kept[before:start] = False
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((start, stop))
    return kept, joined
