"""An array in, coefficients with intervals out."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Bool, Float

from ..curves import Design, as_series, design, ends_matter, even_ends, unit_scale
from ..physics import SYMBOLS, Sampling
from ..recording._checks import FEWEST_SAMPLES, codes_of, usable
from ..recording._lateness import SHORTEST_STRETCH
from ..recording._wraps import why_wraps
from ._estimate import Estimate, estimate

# N is wrong at first where errors at the ends rule, and hardly changes from the second time on.
PASSES = 2
# The part of the posterior that stands for the absence of a noise that is not resolved.
_SMALLEST = 1 / 3


class Fit(eqx.Module):
    """The noise coefficients of one sensor, or of many along a leading axis.

    `coefficients` and the like are dictionaries by symbol, Q, N, B, K, R, of arrays of shape ()
    or (sensors,), in the unit of the data u and seconds: Q in u s, N in u/sqrt(Hz), B in u,
    K in u/sqrt(s), R in u/s.
    """

    estimate: Estimate
    design: Design
    rate_hz: float | Float[Array, ""]

    @property
    def coefficients(self) -> dict[str, Float[Array, "*sensors"]]:
        """Posterior medians; their derivatives are those of `least_squares`.

        Where Q is not resolved, the others' are medians over that half of the posterior in which
        Q is smaller: a value then stands for a sensor without quantization noise, while its
        interval allows for what noise there may be.
        """
        least_squares = jnp.abs(self.estimate.least_squares)
        medians = _medians(self.estimate.draws, self.estimate.resolved)
        shift = jax.lax.stop_gradient(medians - least_squares)
        return _by_symbol(least_squares + shift)

    @property
    def least_squares(self) -> dict[str, Float[Array, "*sensors"]]:
        """The least-squares solution itself: zero where a term fits best when absent."""
        return _by_symbol(jnp.abs(self.estimate.least_squares))

    @property
    def intervals(self) -> dict[str, Float[Array, "*sensors 2"]]:
        """95 % intervals, as `interval(0.95)`."""
        return self.interval(0.95)

    @property
    def resolved(self) -> dict[str, Bool[Array, "*sensors"]]:
        """Whether the record shows each term; `upper_limits` bound those that it does not."""
        return _by_symbol(self.estimate.resolved)

    @property
    def upper_limits(self) -> dict[str, Float[Array, "*sensors"]]:
        """One-sided 95 % limits, widened as intervals are."""
        _, (_, limits) = _bounds(self.estimate.draws, self.estimate.resolved, _both(0.05))
        return _by_symbol(limits)

    @property
    def converged(self) -> Bool[Array, "*sensors"]:
        """False where the data was not finite or the solver failed; its numbers mean nothing."""
        return self.estimate.converged

    @property
    def goodness_of_fit(self) -> Float[Array, "*sensors"]:
        """p-value of the five-term model; below 0.01 something is left out of it."""
        return self.estimate.goodness_of_fit

    def interval(self, probability: float) -> dict[str, Float[Array, "*sensors 2"]]:
        """Equal-tailed intervals; those of unresolved terms are extended down to zero.

        A noise that is not resolved may be absent, or as large as it can be unseen, and its
        neighbours are larger or smaller by what it takes. An interval covers both: it is
        joined with that of the third of the posterior in which each such noise is smallest.

        **Raises:** `ValueError` for a probability that is not between 0 and 1.
        """
        if not 0 < probability < 1:
            raise ValueError(
                f"the probability of an interval is between 0 and 1, as 0.95; got {probability}"
            )
        tail = (1 - probability) / 2
        resolved = self.estimate.resolved
        (low, _), (_, high) = _bounds(self.estimate.draws, resolved, _both(tail))
        low = jnp.where(resolved, low, 0.0)
        return _by_symbol(jnp.stack([low, high], axis=-1), axis=-2)

    def to_dict(self, channel: str = "data", unit: str = "") -> dict[str, Any]:
        """The fit JSON of one sensor, with the name and unit that its array does not carry.

        **Raises:** `ValueError` for the fit of a batch.
        """
        if self.converged.shape:
            raise ValueError(
                f"this is the fit of {self.converged.size} sensors, and a document is of one: fit "
                "that sensor alone with allanfit.fit."
            )
        # A document is made of a recording's channel, which knows this class.
        from ._recording_fit import series_fit

        return series_fit(self, channel, unit).to_dict()

    def _repr_html_(self) -> str:
        """Coefficients with intervals, for a notebook."""
        # Formatting comes after fitting, and is not loaded with it.
        from ..report import fits_html
        from ._recording_fit import series_fit

        if not self.converged.shape:
            return series_fit(self)._repr_html_()
        parts = (self.coefficients, self.intervals, self.upper_limits, self.resolved)
        return fits_html(*({s: np.asarray(v).tolist() for s, v in part.items()} for part in parts))

    def with_draws(self, draws: Float[np.ndarray, "draws terms"]) -> "Fit":
        """The same fit with another sampler's draws behind its intervals."""
        dtype = self.estimate.draws.dtype
        return eqx.tree_at(lambda fit: fit.estimate.draws, self, jnp.asarray(draws, dtype))


def fit_series(
    data: Float[Array, " samples"] | np.ndarray | Sequence,
    rate_hz: float,
    *,
    sampling: Sampling = "point",
    seed: int = 0,
    stretches: tuple[tuple[int, int], ...] | None = None,
) -> Fit:
    """Identify the five noise coefficients of one still sensor, with intervals.

    The model's expectation of the mirror spectrum is fitted by least squares, which is the fit of
    spectrum and Allan variance together with their full covariance, since the latter is a linear
    map of the former; then the posterior is sampled in JAX. `allanfit.sample` does that by emcee.
    Where quantization rules, errors of the angle at the ends of stretches are evened first, as
    `curves/_ends.py` says, but not of data that JAX traces. Nor is it known of these whether they
    are differences of an angle in wide codes, whose errors `physics/_angle_codes.py` describes.

    **Arguments:**

    - `data`: samples, in any unit u, shape (samples,), at least 256.
    - `rate_hz`: samples per second.
    - `sampling`: "point" if a sample is the signal at an instant, "averaged" if its mean over
      the interval. It matters only for flicker and random walk near the sampling rate.
    - `seed`: of the posterior's draws; the same seed gives the same numbers.
    - `stretches`: (start, stop) pairs of usable, gap-free runs; by default the whole record.

    **Raises:** `ValueError` for a wrong shape, too few samples, a rate that is not positive, and
    within `stretches` for values that are not finite, are all alike, or wrap around. Those of data
    that JAX traces are not known, and make `Fit.converged` false instead.
    """
    series = as_series(data, rate_hz)
    if series.ndim != 1:
        raise ValueError(
            f"data must be one sensor, shape (samples,); got {series.shape}. Batches go to fit_many"
        )
    stretches = ((0, series.shape[0]),) if stretches is None else stretches
    lengths = tuple(stop - start for start, stop in stretches)
    check_lengths(lengths)
    pieces, codes = tuple(series[start:stop] for start, stop in stretches), None
    if not isinstance(series, Tracer):
        _refuse_values_without_noise(pieces, stretches)
        # Less their mean they are no codes.
        used = usable(np.asarray(data, float), stretches)
        if why := why_wraps(used):
            raise ValueError(f"data cannot be analysed: {why}")
        codes = codes_of(used)
    layout = design(lengths, sampling, codes)
    found = estimate(pieces, layout, 1 / rate_hz, jax.random.key(seed))
    if not isinstance(found.least_squares, Tracer):
        found = _between_even_ends(found, pieces, layout, rate_hz, seed)
    return Fit(found, layout, rate_hz)


def _refuse_values_without_noise(
    pieces: tuple[Float[Array, " _"], ...], stretches: tuple[tuple[int, int], ...]
) -> None:
    """Raise `ValueError` where nothing is known of the values, or nothing moves."""
    known = [np.asarray(piece) for piece in pieces]
    for values, (start, _) in zip(known, stretches, strict=True):
        broken = np.flatnonzero(~np.isfinite(values))
        if broken.size:
            raise ValueError(
                f"data must be finite; {broken.size} of {values.size} values in a stretch are NaN "
                f"or infinite, the first at index {start + broken[0]}: name the runs without them "
                "by stretches=((start, stop), ...)"
            )
    if all(np.ptp(values) == 0 for values in known):
        raise ValueError(
            "data is constant, and a sensor that never moves shows no noise: look for a wrong "
            "column, or a sensor that hangs"
        )


def _between_even_ends(
    found: Estimate,
    pieces: tuple[Float[Array, " _"], ...],
    layout: Design,
    rate_hz: float,
    seed: int,
) -> Estimate:
    """The estimate where errors of an angle at the ends of stretches are as large as expected."""
    for _ in range(PASSES):
        error, white = errors_and_white_noise(found, rate_hz).tolist()
        if not any(ends_matter(piece.size, error, white) for piece in pieces):
            break
        even = tuple(jnp.asarray(even_ends(np.asarray(each), error, white)) for each in pieces)
        # The curve that people see stays that of the record.
        measured = found.statistics.allan
        found = with_allan(estimate(even, layout, 1 / rate_hz, jax.random.key(seed)), measured)
    return found


def errors_and_white_noise(found: Estimate, rate_hz: float) -> Float[np.ndarray, "2 *sensors"]:
    """Q and N for a sampling interval of one [u]."""
    scale = np.asarray(unit_scale(1 / rate_hz))[:2]
    return np.moveaxis(np.asarray(found.least_squares)[..., :2] / scale, -1, 0)


def with_allan(found: Estimate, allan: Float[Array, "*sensors sizes"]) -> Estimate:
    """The same estimate with another Allan variance to show."""
    return eqx.tree_at(lambda tree: tree.statistics.allan, found, allan)


def check_lengths(lengths: tuple[int, ...]) -> None:
    """Raise `ValueError` if stretches of these lengths are too short for a fit."""
    if sum(lengths) < FEWEST_SAMPLES or min(lengths, default=0) < SHORTEST_STRETCH:
        raise ValueError(
            f"a fit needs at least {FEWEST_SAMPLES} samples in stretches of at least "
            f"{SHORTEST_STRETCH}; got stretches of {list(lengths)}"
        )


@jax.jit
def _medians(
    draws: Float[Array, "*sensors draws terms"], resolved: Bool[Array, "*sensors terms"]
) -> Float[Array, "*sensors terms"]:
    (middle,), draws, q = _quantiles(draws, 0.5), jnp.abs(draws), SYMBOLS.index("Q")
    smaller = draws[..., q] <= middle[..., q, None]
    used = (resolved[..., q, None] | smaller)[..., None]
    (found,) = _quantiles(draws, 0.5, used=used)
    return found.at[..., q].set(middle[..., q])


def _both(tail: float) -> Float[np.ndarray, "2"]:
    """The probabilities below two quantiles with such tails; numbers, for one compilation."""
    return np.array([tail, 1 - tail])


@jax.jit
def _bounds(
    draws: Float[Array, "*sensors draws terms"],
    resolved: Bool[Array, "*sensors terms"],
    probabilities: Float[Array, "2"] | Float[np.ndarray, "2"],
) -> tuple[list[Float[Array, "*sensors terms"]], list[Float[Array, "*sensors terms"]]]:
    """The least and the largest quantiles, with noises that are not resolved and without them."""
    (small, *whole), draws = _quantiles(draws, _SMALLEST, *probabilities), jnp.abs(draws)
    larger = ~resolved[..., None, :] & (draws > small[..., None, :])
    # A ramp takes nothing from the noise.
    larger = larger.at[..., SYMBOLS.index("R")].set(False)
    # A term is not asked to be small itself.
    used = jnp.sum(larger, axis=-1, keepdims=True) - larger == 0
    some = jnp.any(used, axis=-2)
    part = _quantiles(draws, *probabilities, used=used)
    low = [jnp.where(some, jnp.minimum(*pair), pair[0]) for pair in zip(whole, part, strict=True)]
    high = [jnp.where(some, jnp.maximum(*pair), pair[0]) for pair in zip(whole, part, strict=True)]
    return low, high


def _quantiles(
    draws: Float[Array, "*sensors draws terms"],
    *probabilities: float | Float[Array, ""],
    used: bool | Bool[Array, "*sensors draws #terms"] = True,
) -> list[Float[Array, "*sensors terms"]]:
    """Quantiles of the draws that are used."""
    # The ramp's sign says which way the mean drifts, its size how much.
    draws = jnp.abs(draws)
    used = jnp.broadcast_to(used, draws.shape)
    ordered = _ordered(jnp.where(used, draws, jnp.inf))
    last = jnp.sum(used, axis=-2, keepdims=True) - 1
    found = []
    for probability in probabilities:
        place = probability * last
        below = place.astype(int)
        low = jnp.take_along_axis(ordered, below, axis=-2)
        high = jnp.take_along_axis(ordered, jnp.minimum(below + 1, last), axis=-2)
        between = (place - below).astype(draws.dtype)
        found.append((low + between * (high - low))[..., 0, :])
    return found


@jax.jit
def _ordered(draws: Float[Array, "*sensors draws terms"]) -> Float[Array, "*sensors draws terms"]:
    """Non-negative draws in rising order, NaN last.

    As integers, which have the same order and which XLA sorts five times as fast.
    """
    bits = {4: jnp.int32, 8: jnp.int64}[draws.dtype.itemsize]
    whole = jax.lax.bitcast_convert_type(jnp.moveaxis(draws, -2, -1), bits)
    ordered = jax.lax.sort(whole, dimension=-1, is_stable=False)
    return jnp.moveaxis(jax.lax.bitcast_convert_type(ordered, draws.dtype), -1, -2)


def _by_symbol(values: Array, axis: int = -1) -> dict[str, Array]:
    return {symbol: jnp.take(values, i, axis=axis) for i, symbol in enumerate(SYMBOLS)}
