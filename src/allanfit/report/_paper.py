"""Figures in files of their own, as a paper takes them."""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..whole_file import replacing
from ._errors import ReportError, report_extra
from ._figures import UNDATED

FIGURE_SUFFIXES = (".pdf", ".svg", ".png")
_DOTS_PER_INCH = 600


def refuse_other_figures(target: str | os.PathLike[str]) -> None:
    """**Raises** `ReportError` for a name that ends in no format of figures."""
    if Path(target).suffix.lower() not in FIGURE_SUFFIXES:
        raise ReportError(
            f"Cannot tell the format of the figure {os.fspath(target)!r}: "
            f"end its name with {', '.join(FIGURE_SUFFIXES[:-1])} or {FIGURE_SUFFIXES[-1]}."
        )


def write_figures(document: Mapping[str, Any], target: str | os.PathLike[str]) -> list[Path]:
    """Write the curves of a fit or of an explanation as PDF, SVG or PNG, and return their paths.

    Each is one column of a journal wide (89 mm), without a title; PDF and SVG are vectors with
    their letters in them, PNG has 600 dots an inch. The Allan deviation goes to `target`, the
    spectrum beside it with `-psd` in its name; of several channels, each has its name there too.

    **Arguments**: `document` has the schema `allanfit.fit/1` or `allanfit.explain/1`.

    **Raises** `ReportError` for a name that ends in no format of figures, when matplotlib is not
    installed, and when a file cannot be written.

    ```python
    write_figures(json.loads(Path("fit.json").read_text()), "gyro.pdf")
    ```
    """
    refuse_other_figures(target)
    with report_extra():
        from ._explain_panels import draw_curve
        from ._panels import draw, style
    explained = document["schema"].startswith("allanfit.explain/")
    written = []
    for channel, base in zip(document["channels"], _bases(document, Path(target)), strict=True):
        for kind, path in (("allan", base), ("psd", base.with_stem(f"{base.stem}-psd"))):
            sheet = draw_curve(channel, kind) if explained else draw(channel, (kind,), title=False)
            metadata = UNDATED[path.suffix.lower()]
            try:
                with style(), replacing(path) as part:
                    sheet.savefig(part, dpi=_DOTS_PER_INCH, metadata=metadata)
            except OSError as error:
                raise ReportError(
                    f"Cannot write {path} ({error.strerror or error}): "
                    "give a path in a folder that exists, is writable and has space."
                ) from error
            written.append(path)
    return written


def _bases(document: Mapping[str, Any], target: Path) -> list[Path]:
    """A path for each channel, no two the same."""
    names = [channel["channel"] for channel in document["channels"]]
    if len(names) == 1:
        return [target]
    # A channel may bear any name, but a file may not.
    safe = [re.sub(r"\W+", "_", name).strip("_") for name in names]
    if len(set(safe)) < len(safe) or not all(safe):
        safe = [f"{number}" for number in range(1, len(safe) + 1)]
    return [target.with_stem(f"{target.stem}-{name}") for name in safe]
