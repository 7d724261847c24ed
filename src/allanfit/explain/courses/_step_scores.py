"""How steps at all places of a stretch stand out of the noise: a matched filter."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.fft import dst

from ..spectrum._ordinates import Ordinates
from ._blocks import FINEST_BLOCKS, Stretch, blocks_of
from ._passing import Passing


class StepScores(NamedTuple):
    """How a step at places of one stretch stands out."""

    start: int
    stop: int
    #: Samples of the record, how tall what is there stands in standard deviations, and as how tall
    #: a step of one unit would [1/u].
    at: Float[np.ndarray, " places"]
    scores: Float[np.ndarray, " places"]
    known: Float[np.ndarray, " places"]


def step_scores(
    values: Float[np.ndarray, " samples"],
    pieces: list[tuple[int, int]],
    spectrum: Ordinates,
    variance: Float[np.ndarray, " ordinates"],
    through: Passing | None = None,
) -> list[StepScores]:
    """Steps in each stretch, as fine as it is, in noise that gives the ordinates this variance.

    Behind a filter they have its gain, and its delay, but not its other phase.
    """
    blocks = blocks_of(values, pieces, FINEST_BLOCKS)
    found = []
    for stretch, start in zip(
        blocks.scan(spectrum, variance).stretches, blocks.starts, strict=True
    ):
        gain = 1.0
        if through is not None:
            gain = through.gain_at(stretch.orders / (2 * stretch.count * blocks.size))
        top, bottom, _ = step_sums(stretch, gain)
        length = stretch.count * blocks.size
        at = start + np.arange(1, top.size + 1) / (top.size + 1) * length
        known = np.sqrt(bottom)
        found.append(StepScores(start, start + length, at, top / known, known))
    return found


def step_sums(
    stretch: Stretch, gain: float | Float[np.ndarray, " orders"] = 1.0
) -> tuple[
    Float[np.ndarray, " places"], Float[np.ndarray, " places"], Float[np.ndarray, " between"]
]:
    """Products of the record with steps at evenly spaced places, their squares, and of neighbours.

    In white noise, at right angles to the ramp; with a `gain` that a filter gives to steps.
    """
    # The cosine coefficients of a step at g blocks are a sine of g: a sine transform has all
    # positions at once. Where a random walk is strong, a step is known to a few samples, and a
    # scan must be as fine.
    orders, places = stretch.orders, 2 ** int(np.ceil(np.log2(stretch.count)))
    half = 2 * np.sin(np.pi * orders / (2 * stretch.count))
    unit = -np.sqrt(2 / stretch.count) * stretch.scale * gain / half
    ramp = stretch.ramp / stretch.variance
    top = _sines(stretch.amplitude * unit / stretch.variance, places)
    bottom = _products(unit**2 / stretch.variance, places, 0)
    across = _sines(ramp * unit, places)
    norm = ramp @ stretch.ramp
    top = top - across * (ramp @ stretch.amplitude) / norm
    bottom = np.maximum(bottom - across**2 / norm, 1e-12 * bottom)
    beside = _products(unit**2 / stretch.variance, places, 1)[:-1]
    beside -= across[1:] * across[:-1] / norm
    return top, bottom, beside


def _sines(of_order: Float[np.ndarray, " orders"], places: int) -> Float[np.ndarray, " inner"]:
    """Sums over orders k from 1 on of what is given times sin(pi k i/places), 0 < i < places."""
    return np.asarray(dst(np.pad(of_order, (0, places - 1 - of_order.size)), type=1)) / 2


def _products(
    of_order: Float[np.ndarray, " orders"], places: int, apart: int
) -> Float[np.ndarray, " inner"]:
    """The same of products of sines at i and at i + `apart`, none or one."""
    # sin a sin b = (cos(a - b) - cos(a + b))/2, and a + b goes round twice.
    orders = np.arange(1, of_order.size + 1)
    turned = of_order * np.exp(1j * np.pi * orders * apart / places)
    sums = np.fft.fft(np.pad(turned, (1, places - 1 - orders.size)).conj()).real[1:]
    return (np.sum(of_order * np.cos(np.pi * orders * apart / places)) - sums) / 2
