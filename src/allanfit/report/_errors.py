"""The one error of this stage, and the message for a missing extra."""

from collections.abc import Iterator
from contextlib import contextmanager


class ReportError(ValueError):
    """A report could not be made; the message says why and what to do, in one sentence."""


@contextmanager
def report_extra() -> Iterator[None]:
    """Guard the imports that the extra `report` brings.

    **Raises** `ReportError` naming the install command, in place of `ModuleNotFoundError`.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "a package").partition(".")[0]
        raise ReportError(
            f"Figures and pages need {package}, which is not installed: "
            "run `pip install allanfit[report]`."
        ) from error
