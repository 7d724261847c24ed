"""The error of this stage, and the message for a missing extra."""

from collections.abc import Iterator
from contextlib import contextmanager


class FleetError(ValueError):
    """A fleet cannot be analysed, or not to the end; one sentence says why and what to do."""


@contextmanager
def fleet_extra() -> Iterator[None]:
    """Guard the imports that the extra `fleet` brings.

    **Raises** `FleetError` naming the install command, in place of `ModuleNotFoundError`.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "a package").partition(".")[0]
        raise FleetError(
            f"Fleets need {package}, which is not installed: run `pip install 'allanfit[fleet]'`."
        ) from error
