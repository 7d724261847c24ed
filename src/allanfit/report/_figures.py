"""The figure of one channel, and its pieces as SVG text for the page."""

import io
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ._errors import report_extra

if TYPE_CHECKING:
    import matplotlib.figure

# Dates and library versions would make two equal figures differ.
UNDATED: dict[str, dict[str, Any]] = {
    ".svg": dict.fromkeys(("Creator", "Date", "Format", "Type")),
    ".pdf": dict.fromkeys(("Creator", "Producer", "CreationDate")),
    ".png": {"Software": None},
}
_ID_PATTERN = re.compile(r'(\bid="|href="#|url\(#)')


# The return type is a dotted string, so that a run-time type checker finds it without an import.
def figure(channel: Mapping[str, Any]) -> "matplotlib.figure.Figure":
    """The figure of a channel: Allan deviation and PSD, each above its residuals.

    Points are the data with their 95 % band, the line is the fit, and each term has its own
    dashed line with its letter. Residuals are in standard deviations of the band. The size,
    178 mm by 117 mm, is that of a figure across both columns of a journal.

    **Arguments**: `channel` is one entry of `channels` in a fit document.

    **Returns** a figure on no canvas of pyplot: save it with `savefig`.

    **Raises** `ReportError` when matplotlib is not installed.

    ```python
    figure(document["channels"][0]).savefig("gyro_x.pdf")
    ```
    """
    with report_extra():
        from ._panels import draw
    return draw(channel, ("allan", "psd"), title=True)


def svg(channel: Mapping[str, Any], subject: str, prefix: str) -> str:
    """A curve of a channel ("allan" or "psd"), its "shares" or "temperature", as SVG for a page.

    `prefix` goes before every identifier: those of several figures share one page.

    **Raises** `ReportError` when matplotlib is not installed.
    """
    with report_extra():
        from ._panels import draw
        from ._shares_panel import draw_shares
        from ._temperature_panel import draw_temperature
    whole = {"shares": draw_shares, "temperature": draw_temperature}
    if subject in whole:
        return as_svg(whole[subject](channel), prefix)
    return as_svg(draw(channel, (subject,), title=False), prefix)


def as_svg(sheet: "matplotlib.figure.Figure", prefix: str) -> str:
    """A figure as one SVG element, `prefix` before every identifier in it."""
    from ._panels import style

    stream = io.StringIO()
    with style():
        sheet.savefig(stream, format="svg", metadata=UNDATED[".svg"])
    element = stream.getvalue()
    element = element[element.index("<svg") :]
    return _ID_PATTERN.sub(lambda match: match[0] + prefix, element)
