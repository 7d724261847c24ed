"""Which cluster sizes to compute."""

import numpy as np


def cluster_sizes(samples: int, per_octave: int = 4) -> np.ndarray:
    """Sizes n = 1, 2, 4, ... up to a third of the record, and `per_octave` - 1 between octaves.

    Beyond a third fewer than one independent difference is left. Neighbours closer than a quarter
    octave are correlated by more than 0.9 and add ink, not information.

    **Arguments:** the samples of a record, and sizes an octave.

    **Returns:** increasing integers, shape (sizes,).

    **Raises:** `ValueError` for fewer than 3 samples.
    """
    if samples < 3:
        raise ValueError(f"an Allan variance needs at least 3 samples; got {samples}")
    octaves = 2 ** np.arange(int(np.log2(samples // 3)) + 1)
    steps = 1 + np.arange(per_octave) / per_octave
    sizes = np.unique(np.floor(np.outer(octaves, steps)).astype(np.int64))
    return sizes[sizes <= samples // 3]
