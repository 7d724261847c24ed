"""The checker of shapes still checks: a wrong shape fails, at the first calls of a function."""

from collections import Counter

import first_calls
import jax.numpy as jnp
import numpy as np
import pytest
from first_calls import CALLS, checked
from jaxtyping import Float, TypeCheckError, jaxtyped

from allanfit.curves import allan_variance_deviation, unit_scale


def test_shapes_of_the_package_are_checked(monkeypatch):
    # Tests before this one may have called it often enough.
    monkeypatch.setattr(first_calls, "_seen", Counter())
    monkeypatch.delattr(allan_variance_deviation, "__no_type_check__", raising=False)
    with pytest.raises(TypeCheckError):
        allan_variance_deviation(None, None)  # pyright: ignore[reportArgumentType]
    assert unit_scale(jnp.asarray(0.01)).shape == (5,)


@jaxtyped(typechecker=checked)
def doubled(x: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    return 2 * x


def test_the_first_calls_are_checked_and_no_others():
    flat = np.zeros((2, 2))
    for _ in range(CALLS - 1):
        doubled(np.zeros(2))
    # The call that is the last to be checked.
    with pytest.raises(TypeCheckError):
        doubled(flat)
    assert doubled(flat).shape == (2, 2)


def test_local_functions_and_properties_are_counted_by_name():
    def tripled():
        @jaxtyped(typechecker=checked)
        def triple(x: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
            return 3 * x

        return triple

    class Box:
        @jaxtyped(typechecker=checked)
        @property
        def content(self) -> Float[np.ndarray, " samples"]:
            return np.zeros((2, 2))

    flat = np.zeros((2, 2))
    for _ in range(CALLS - 1):
        tripled()(np.zeros(2))
    for _ in range(CALLS):
        with pytest.raises(TypeCheckError):
            _ = Box().content
    with pytest.raises(TypeCheckError):
        tripled()(flat)
    # Whose result is not checked, and is to be as often.
    tripled()(np.zeros(2))
    assert tripled()(flat).shape == (2, 2)
    assert Box().content.shape == (2, 2)
