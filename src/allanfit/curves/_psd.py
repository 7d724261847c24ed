"""Power spectral density of one series, averaged over logarithmic bins."""

from collections.abc import Sequence
from functools import partial
from typing import Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ._allan import each_series
from ._bins import logarithmic_edges
from ._input import as_series
from ._spectrum import cosine_coefficients

Taper = Literal["mirror", "hann", "none"]


class Spectrum(NamedTuple):
    """A one-sided density; shapes (bins,), and (sensors, bins) for the density of a batch."""

    #: Mean frequency of each bin [Hz].
    frequency: Float[Array, " bins"]
    #: Density [u^2/Hz].
    density: Float[Array, "*sensors bins"]
    #: How many ordinates each bin averages.
    ordinates: Float[Array, " bins"]


def psd(
    data: Float[Array, "*sensors samples"] | np.ndarray | Sequence,
    rate_hz: float,
    *,
    taper: Taper = "mirror",
    bins_per_decade: int | None = 16,
) -> Spectrum:
    """One-sided power spectral density of samples [u], in u^2/Hz, of the record as a whole.

    The ordinates are |X(f)|^2 scaled so that their sum times their spacing is the variance (IEEE
    Std 1293, one-sided), with the mean removed, then averaged in bins equally spaced in log f.

    **Arguments:**

    - `data`: one sensor, shape (samples,), or several, shape (sensors, samples).
    - `rate_hz`: samples per second.
    - `taper`: "mirror" reflects the record at its ends, which neither leaks nor loses
      information, and is what the fit uses; "hann" multiplies by a Hann window, as
      `scipy.signal.periodogram` does; "none" is the plain periodogram, which doubles a random
      walk's density.
    - `bins_per_decade`: `None` gives every ordinate.

    **Raises:** `ValueError` for a wrong shape, rate, taper or number of bins.
    """
    series = as_series(data, rate_hz, single=True)
    if taper not in ("mirror", "hann", "none"):
        raise ValueError(f'taper must be "mirror", "hann" or "none"; got {taper!r}')
    if bins_per_decade is not None and bins_per_decade < 1:
        raise ValueError(f"bins_per_decade must be at least 1; got {bins_per_decade}")
    samples = series.shape[-1]
    mirror = taper == "mirror"
    spacing = 1 / (2 * samples) if mirror else 1 / samples
    frequency = spacing * np.arange(1, samples if mirror else samples // 2 + 1)
    index, count = None, np.ones_like(frequency)
    if bins_per_decade is not None:
        edges = logarithmic_edges(spacing, spacing, bins_per_decade)
        place = np.searchsorted(edges, frequency, side="right") - 1
        count = np.bincount(place)
        frequency = np.bincount(place, frequency) / count
        index = jnp.asarray(place, jnp.int32)
    ordinates = jnp.asarray(count, series.dtype)

    def single(x: Float[Array, " samples"]) -> Float[Array, " bins"]:
        return _total(x, index, len(count), taper) / ordinates / rate_hz

    density = single(series) if series.ndim == 1 else each_series(single, series)
    return Spectrum(jnp.asarray(frequency * rate_hz, series.dtype), density, ordinates)


@partial(jax.jit, static_argnames=("bins", "taper"))
def _total(
    x: Float[Array, " samples"], index: Int[Array, " ordinates"] | None, bins: int, taper: Taper
) -> Float[Array, " bins"]:
    """The sum of ordinates in each bin; all of them as they are without an index."""
    ordinates = _mirror(x) if taper == "mirror" else _periodogram(x, taper)
    if index is None:
        return ordinates
    return jax.ops.segment_sum(ordinates, index, bins, indices_are_sorted=True)


def _mirror(x: Float[Array, " samples"]) -> Float[Array, " ordinates"]:
    return 2 * cosine_coefficients(x) ** 2


def _periodogram(x: Float[Array, " samples"], taper: Taper) -> Float[Array, " ordinates"]:
    samples = x.shape[0]
    window = np.ones(samples)
    if taper == "hann":
        window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(samples) / samples)
    transform = jnp.fft.rfft((x - jnp.mean(x)) * jnp.asarray(window, x.dtype))[1:]
    sides = np.full(transform.shape, 2.0)
    if samples % 2 == 0:
        sides[-1] = 1.0  # the Nyquist ordinate has no twin at negative frequency
    return jnp.asarray(sides / np.sum(window**2), x.dtype) * jnp.abs(transform) ** 2
