"""Effects in another unit, and their parameters' units by name."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._catalogue import field_of
from ._effect import AbstractEffect, Parameter

# Powers of the channel's unit in a parameter's.
_POWERS = {"u": 1, "u^2/Hz": 2, "u/K": 1, "u/K^2": 1, "1/u": -1}


def unit_power(parameter: Parameter) -> int:
    """How often the unit of the channel is a factor of a parameter's.

    >>> unit_power(Parameter("density", "u^2/Hz"))
    2
    """
    return _POWERS.get(parameter.unit, 0)


def parameter_unit(parameter: Parameter, unit: str) -> str:
    """The unit of a parameter on a channel that carries `unit`.

    >>> parameter_unit(Parameter("density", "u^2/Hz"), "rad/s")
    '(rad/s)^2/Hz'
    """
    if parameter.unit not in _POWERS:
        return parameter.unit
    unit = unit or "1"
    alone = parameter.unit in ("u", "u/K", "u/K^2")
    return parameter.unit.replace("u", unit if alone or unit.isalnum() else f"({unit})")


def parameter_values(effect: AbstractEffect) -> dict[str, Float[Array, "..."]]:
    """The parameters that an effect has, by their names in explain's JSON; flags only if set."""
    values = {each.name: vars(effect)[field_of(each)] for each in effect.parameters}
    return {
        name: jnp.asarray(value, float)
        for name, value in values.items()
        if value is not None and value is not False
    }


def scaled(effect: AbstractEffect, factor: float) -> AbstractEffect:
    """The effect on a channel whose numbers are `factor` times as large, as in another unit."""
    fields = {field_of(each): unit_power(each) for each in effect.parameters}
    moved = {
        field: jnp.asarray(vars(effect)[field] * factor**power)
        for field, power in fields.items()
        if power and vars(effect)[field] is not None
    }
    if not moved:
        return effect
    return eqx.tree_at(
        lambda tree: [vars(tree)[field] for field in moved], effect, list(moved.values())
    )
