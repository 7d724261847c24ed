"""What checks shapes and types in tests: beartype, at the first calls of each function.

A function that is called a hundred thousand times has the same shapes in most of them, and checking
them all took two fifths of the time of the suite.
"""

import sys
from collections.abc import Callable
from contextlib import suppress
from functools import reduce, wraps
from typing import Any

import beartype

#: So many calls of each function.
CALLS = 64


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The typechecker that jaxtyping is given; `function` stands for the one that is checked."""
    check, calls = beartype.beartype(function), 0

    @wraps(function)
    def counted(*args, **kwargs):
        nonlocal calls
        calls += 1
        if calls == CALLS:
            _leave_unchecked(function.__module__, function.__qualname__)
        return check(*args, **kwargs)

    return counted


def _leave_unchecked(module: str, qualname: str) -> None:
    # Local functions, which have no place of their own, go on being checked.
    with suppress(AttributeError, TypeError):
        found = reduce(getattr, qualname.split("."), sys.modules[module])
        found.__no_type_check__ = True
