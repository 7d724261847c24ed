"""How far temperature moves a sensor: the function for arrays, and its result."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from ..curves import as_series, cosine_coefficients, mode_variances, slow_part, unit_scale
from ..curves._spectrum import ramp_coefficients
from ..identify._estimate import estimate_from
from ..identify._fit import Fit
from ._band import highest_mode
from ._regression import Effects, Modes, effects, explained, share_of_ramp
from ._removal import remove

_Pieces = tuple[Float[Array, " _"], ...]
_Columns = tuple[Float[Array, "_ two"], ...]

RESOLVED_P = 0.05
"""Below this p-value a sensitivity counts as resolved: its 95 % interval leaves zero out."""

# The noise is fitted with weights from the plain fit, then with weights from that.
_ROUNDS = 2
_NOISE_DRAWS = 1600
# Waves of the record, a half each, that count as slow when it is said how much is explained.
_SLOW_MODES = 64
# A ramp is left enough of the odd modes beyond this one; see `RAMP_MODES`.
_RAMP_ORDERS = 64


class TemperatureEffect(eqx.Module):
    """What temperature does to one sensor, in the unit u of its samples.

    The model is linear_0 (T - T0) + quadratic (T - T0)^2 beside the five terms, R among them, with
    T0 the mean temperature. Arrays of two hold linear [u/degC], then quadratic [u/degC^2].
    """

    #: Mean, lowest and highest temperature of the samples that were fitted [degC].
    mean_degC: float
    low_degC: float
    high_degC: float
    #: Draws from the posterior, shape (draws, 2).
    draws: Float[Array, "draws two"]
    #: The same if there is no rate ramp: what to use when R is known to be zero.
    draws_without_ramp: Float[Array, "draws two"]
    #: Two-sided p-value of each sensitivity being zero, and of both being so.
    p_values: Float[Array, " two"]
    p_value: Float[Array, ""]
    #: Part of the knowledge of the linear sensitivity that is lost because R is unknown, 0 to 1.
    share_of_ramp: Float[Array, ""]
    #: Fraction of the slow variance (periods beyond 1/32 of the record, the straight line in time
    #: taken out) that temperature explains, and what it explains by chance in one of twenty records
    #: that it does not move. They describe; the p-values decide.
    explained: Float[Array, ""]
    explained_by_chance: Float[Array, ""]
    #: The shortest period of the temperature that was used [s].
    shortest_period_s: float
    #: What temperature adds to each sample, shape (samples,) [u]; zero outside the stretches.
    drift: Float[Array, " samples"]
    #: The fit of the five terms with the effect of temperature taken out.
    removed: Fit

    @property
    def linear(self) -> Float[Array, ""]:
        """Sensitivity at the mean temperature [u/degC], the posterior median."""
        return jnp.median(self.draws[:, 0])

    @property
    def quadratic(self) -> Float[Array, ""]:
        """Half the change of the sensitivity with temperature [u/degC^2], the median."""
        return jnp.median(self.draws[:, 1])

    @property
    def resolved(self) -> Bool[Array, " two"]:
        """Whether the 95 % interval of each leaves zero out."""
        return self.p_values < RESOLVED_P

    def interval(self, probability: float = 0.95, *, ramp: bool = True) -> Float[Array, "two two"]:
        """Equal-tailed intervals, a row each; `ramp=False` takes the rate ramp R to be zero."""
        tail = (1 - probability) / 2
        draws = self.draws if ramp else self.draws_without_ramp
        return jnp.quantile(draws, jnp.asarray([tail, 1 - tail]), axis=0).T

    def curve(
        self,
        temperature_degC: Float[Array, " points"] | np.ndarray,
        probability: float = 0.95,
        *,
        ramp: bool = True,
    ) -> tuple[Float[Array, " points"], Float[Array, "points two"]]:
        """The effect at some temperatures against that at the mean one [u], and its band.

        `ramp=False` takes the rate ramp R to be zero.
        """
        step = jnp.asarray(temperature_degC, self.draws.dtype) - self.mean_degC
        draws = self.draws if ramp else self.draws_without_ramp
        drawn = draws @ jnp.stack([step, step**2])
        tail = (1 - probability) / 2
        low, middle, high = jnp.quantile(drawn, jnp.asarray([tail, 0.5, 1 - tail]), axis=0)
        return middle, jnp.stack([low, high], axis=-1)


def temperature_sensitivity(
    fit: Fit,
    data: Float[Array, " samples"] | np.ndarray,
    temperature_degC: Float[Array, " samples"] | np.ndarray,
    stretches: tuple[tuple[int, int], ...] | None = None,
    *,
    seed: int = 0,
) -> TemperatureEffect:
    """Linear and quadratic sensitivity to temperature, jointly with the noise.

    Generalised least squares in the domain of the cosine transform, where coloured noise has
    independent coefficients, on the modes in which the temperature stands clear of its own errors
    (see `_band`). The rate ramp R is free, since a sensor may drift for other reasons than
    temperature, and the noise is fitted to what no sensitivity could explain (see `_removal`).
    Uncertainty of the noise is averaged over, so that a temperature that wanders beside an
    unrelated random walk is not taken for its cause more often than p-values say.

    **Arguments:**

    - `fit`: one sensor's fit, from `allanfit.fit`.
    - `data`, `stretches`: the samples that were fitted, shape (samples,) [u], and the stretches
      if they had gaps.
    - `temperature_degC`: the temperature at each sample, shape (samples,), in degC or K. A lag
      of the thermometer behind the sensor is not modelled.
    - `seed`: of the draws; the same seed gives the same numbers.

    **Raises:** `ValueError` if the data are not those of the fit, if a temperature is missing,
    not finite or of another length, and if it does not change enough for an effect to be told.

    >>> effect = temperature_sensitivity(fit, data, temperature)  # doctest: +SKIP
    >>> effect.linear, effect.interval(0.95)[0]  # doctest: +SKIP
    """
    series = as_series(data, 1.0)
    stretches = ((0, series.shape[-1]),) if stretches is None else tuple(stretches)
    lengths = tuple(stop - start for start, stop in stretches)
    if series.ndim != 1 or lengths != fit.design.lengths or stretches[-1][1] > series.shape[0]:
        raise ValueError(
            f"temperature_sensitivity needs the one series that was fitted, in stretches of "
            f"{list(fit.design.lengths)} samples; got shape {series.shape} in {list(lengths)}"
        )
    centred, mean, low, high = _temperature(temperature_degC, series.shape[0], stretches)
    top = highest_mode(centred)
    if not top:
        raise ValueError(
            f"the temperature, {low:.4g} to {high:.4g} degC, changes by no more than its own "
            "noise and rounding or evenly with time alone, so that its effect cannot be told from "
            "a rate ramp; record while the temperature rises and falls"
        )
    dtype, longest = series.dtype, max(lengths)
    orders = tuple(min(length - 1, top * length // longest) for length in lengths)
    pieces, columns = _pieces(series, stretches, tuple(centred), orders)
    sampling = fit.design.sampling

    def variances(modes: Sequence[int]) -> tuple[Float[Array, "_ terms"], ...]:
        return tuple(
            jnp.asarray(mode_variances(length, count, sampling), dtype)
            for length, count in zip(lengths, modes, strict=True)
        )

    dt = 1 / float(fit.rate_hz)
    key = jax.random.key(seed)
    ramp_orders = [
        min(length - 1, max(order, _RAMP_ORDERS))
        for length, order in zip(lengths, orders, strict=True)
    ]
    all_variances = variances(ramp_orders)
    power, removed, slopes = _power(fit), fit, jnp.zeros(2)
    for _ in range(_ROUNDS):
        found = remove(pieces, columns, all_variances, fit.design, power)
        # On the host, as every design is.
        layout = jax.tree.map(np.asarray, found.design)
        estimate = estimate_from(found.statistics, layout, dt, key)
        removed = Fit(estimate, layout, fit.rate_hz)
        power, slopes = _power(removed), found.slopes

    scale = unit_scale(dt).astype(dtype)[:-1]
    step = max(1, len(removed.estimate.draws) // _NOISE_DRAWS)
    powers = (removed.estimate.draws[::step, :-1] / scale) ** 2
    modes = _modes(pieces, columns, orders, variances(orders))
    known, alone, share, part, chance = _evaluate(
        modes, powers, slopes, power, lengths, orders, key
    )
    return TemperatureEffect(
        mean_degC=mean,
        low_degC=low,
        high_degC=high,
        draws=known.draws,
        draws_without_ramp=alone.draws,
        p_values=known.p_values,
        p_value=known.p_value,
        share_of_ramp=share,
        explained=part,
        explained_by_chance=chance,
        shortest_period_s=2 * longest / top * dt,
        drift=_drift(series, stretches, columns, slopes),
        removed=removed,
    )


def _temperature(
    temperature_degC: Float[Array, " samples"] | np.ndarray,
    samples: int,
    stretches: tuple[tuple[int, int], ...],
) -> tuple[list[np.ndarray], float, float, float]:
    """The temperature in each stretch less its mean over all, that mean, lowest and highest."""
    values = np.asarray(temperature_degC)
    if values.shape != (samples,) or values.dtype.kind not in "iuf":
        raise ValueError(
            f"temperature_degC must be one real number a sample, shape ({samples},); got shape "
            f"{values.shape} of {values.dtype}"
        )
    used = np.concatenate([values[start:stop] for start, stop in stretches]).astype(np.float64)
    missing = int(np.count_nonzero(~np.isfinite(used)))
    if missing:
        raise ValueError(f"temperature_degC is not finite at {missing} of {used.size} samples")
    low, high = float(used.min()), float(used.max())
    if np.unique(used).size < 3:
        what = (
            f"constant at {low:.6g} degC" if low == high else f"either {low:.6g} or {high:.6g} degC"
        )
        raise ValueError(f"the temperature is {what}, and its effect cannot be told")
    mean = float(used.mean())
    return [values[start:stop] - mean for start, stop in stretches], mean, low, high


@eqx.filter_jit
def _pieces(
    series: Float[Array, " samples"],
    stretches: tuple[tuple[int, int], ...],
    centred: tuple[Float[Array, " _"] | np.ndarray, ...],
    orders: tuple[int, ...],
) -> tuple[_Pieces, _Columns]:
    """The samples of each stretch, and the slow part of its temperature and of the square."""
    columns = []
    for step, order in zip(centred, orders, strict=True):
        pair = jnp.stack([step, step**2], axis=1).astype(series.dtype)
        columns.append(jax.vmap(lambda x, m=order: slow_part(x, m), 1, 1)(pair))
    return tuple(series[start:stop] for start, stop in stretches), tuple(columns)


@eqx.filter_jit
def _modes(
    pieces: _Pieces,
    columns: _Columns,
    orders: tuple[int, ...],
    variances: tuple[Float[Array, "_ terms"], ...],
) -> Modes:
    response, regressors = [], []
    for x, column, order in zip(pieces, columns, orders, strict=True):
        response.append(cosine_coefficients(x)[:order])
        ramp = jnp.asarray(ramp_coefficients(x.shape[0])[:order], x.dtype)
        moved = jax.vmap(cosine_coefficients, 1, 1)(column)[:order]
        regressors.append(jnp.concatenate([ramp[:, None], moved], axis=1))
    return Modes(jnp.concatenate(response), jnp.concatenate(regressors), jnp.concatenate(variances))


@eqx.filter_jit
def _evaluate(
    modes: Modes,
    powers: Float[Array, "draws terms"],
    slopes: Float[Array, " two"],
    power: Float[Array, " terms"],
    lengths: tuple[int, ...],
    orders: tuple[int, ...],
    key: PRNGKeyArray,
) -> tuple[Effects, Effects, Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """Effects beside a ramp and alone, the ramp's share, what is explained and what by chance."""
    keys = jax.random.split(key, 3)
    known = effects(keys[0], modes, powers)
    alone = effects(keys[1], modes._replace(columns=modes.columns[:, 1:]), powers)
    order = np.concatenate(
        [np.arange(1, count + 1) / length for count, length in zip(orders, lengths, strict=True)]
    )
    slow = jnp.asarray(order <= _SLOW_MODES / max(lengths), modes.response.dtype)
    part, chance = explained(keys[2], modes, slow, slopes, power)
    return known, alone, share_of_ramp(modes, power), part, chance


@eqx.filter_jit
def _drift(
    series: Float[Array, " samples"],
    stretches: tuple[tuple[int, int], ...],
    columns: _Columns,
    slopes: Float[Array, " two"],
) -> Float[Array, " samples"]:
    drift = jnp.zeros(series.shape, series.dtype)
    for (start, stop), column in zip(stretches, columns, strict=True):
        drift = drift.at[start:stop].set(column @ slopes)
    return drift


def _power(fit: Fit) -> Float[Array, " terms"]:
    """Squared medians for a sampling interval of one."""
    values = jnp.stack(list(fit.coefficients.values()))
    return (values / unit_scale(1 / float(fit.rate_hz)).astype(values.dtype))[:-1] ** 2
