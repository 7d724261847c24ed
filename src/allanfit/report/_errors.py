"""The one error of this stage, and the message for a missing extra."""

from contextlib import AbstractContextManager

from ..extras import needs


class ReportError(ValueError):
    """A report could not be made; the message says why and what to do, in one sentence."""


def report_extra() -> AbstractContextManager[None]:
    """Guard the imports that the extra `report` brings.

    **Raises** `ReportError` naming the install command, in place of `ModuleNotFoundError`.
    """
    return needs("allanfit[report]", "Figures and pages", ReportError)
