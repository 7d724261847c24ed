"""What unit coefficients put into the bins of a long record."""

import jax
import numpy as np

from allanfit.curves import design

SAMPLES = 300_000


def test_means_over_wide_bins_are_those_of_their_ordinates():
    """Against sums over every ordinate of densities written out here, above order 70,000."""
    made = design((SAMPLES, 100_000))
    with jax.enable_x64(True):
        density = np.asarray(made.density)
    total, count = np.zeros((len(made.ordinates), 3)), np.zeros(len(made.ordinates))
    for length, index in zip(made.lengths, made.bin_index, strict=True):
        frequency = np.arange(2, length) / (2 * length)
        sine = np.sin(np.pi * frequency) ** 2
        # Differenced white noise, white noise, summed white noise.
        written = np.stack([8 * sine, np.full_like(sine, 2.0), 1 / (2 * sine)], axis=1)
        for column in range(3):
            total[:, column] += np.bincount(index, written[:, column], minlength=len(count))
        count += np.bincount(index, minlength=len(count))
    np.testing.assert_array_equal(made.ordinates, count)
    high = made.frequency > 0.4
    np.testing.assert_allclose(
        density[high][:, [0, 1, 3]], (total / count[:, None])[high], rtol=1e-8
    )
    # Below, in bins of which nearly all ordinates are written by themselves, up to the ends.
    middle = (made.frequency > 0.02) & ~high
    np.testing.assert_allclose(
        density[middle][:, [0, 1, 3]], (total / count[:, None])[middle], rtol=2e-4
    )
