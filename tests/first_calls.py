"""What checks shapes and types in tests: beartype, at the first calls of each function.

A function that is called a hundred thousand times has the same shapes in most of them, and checking
them all took two fifths of the time of the suite.
"""

import sys
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from functools import reduce, wraps
from typing import Any

import beartype

#: So many calls of each function.
CALLS = 16

# Of each stub by which jaxtyping has arguments checked, and of each by which results are; a local
# function is another one each time, and has the same name and annotations.
_seen: Counter[tuple[str, str, tuple[str, ...]]] = Counter()


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The typechecker that jaxtyping is given; `function` stands for the one that is checked."""
    stub = (function.__module__, function.__qualname__, tuple(function.__annotations__))
    if _seen[stub] >= CALLS:
        return function
    check = None

    @wraps(function)
    def counted(*args, **kwargs):
        # Made when it is asked for: no process calls most of the package.
        nonlocal check
        _seen[stub] += 1
        if _seen[stub] == CALLS:
            _leave_unchecked(function.__module__, function.__qualname__)
        if _seen[stub] > CALLS:
            return function(*args, **kwargs)
        check = check or beartype.beartype(function)
        return check(*args, **kwargs)

    return counted


def _leave_unchecked(module: str, qualname: str) -> None:
    # Local functions have no place of their own, and go on being counted.
    with suppress(AttributeError, TypeError):
        found = reduce(getattr, qualname.split("."), sys.modules[module])
        if isinstance(found, property):
            found = found.fget
        found.__no_type_check__ = True
