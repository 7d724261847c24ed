"""The error of this stage, and the message for a missing extra."""

from contextlib import AbstractContextManager

from ..extras import needs


class FleetError(ValueError):
    """A fleet cannot be analysed, or not to the end; one sentence says why and what to do."""


def fleet_extra() -> AbstractContextManager[None]:
    """Guard the imports that the extra `fleet` brings.

    **Raises** `FleetError` naming the install command, in place of `ModuleNotFoundError`.
    """
    return needs("'allanfit[fleet]'", "Fleets", FleetError)
