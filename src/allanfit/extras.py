"""The message where a package is missing that an extra brings."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def needs(extra: str, what: str, error: type[ValueError]) -> Iterator[None]:
    """Guard imports: `what` they are for, and the `extra` to install as pip is given it.

    **Raises** `error` naming the install command, in place of `ModuleNotFoundError`.
    """
    try:
        yield
    except ModuleNotFoundError as missing:
        package = (missing.name or "a package").partition(".")[0]
        raise error(
            f"{what} need {package}, which is not installed: run `pip install {extra}`."
        ) from missing
