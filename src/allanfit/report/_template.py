"""Filling in a page: the one place where text becomes HTML, every user's string escaped."""

from importlib.resources import files
from typing import Any

from ._errors import report_extra
from ._units import typeset


def render(name: str, *, package: str = "allanfit.report", **context: Any) -> str:
    """The template of that name in a `package`, with this one's style sheet in its `style`.

    **Raises** `ReportError` when jinja2 is not installed.
    """
    with report_extra():
        from jinja2 import Environment, FunctionLoader, StrictUndefined
        from markupsafe import Markup
    folder, ours = files(package), files("allanfit.report")

    def read(part: str) -> str:
        return folder.joinpath(part).read_text("utf-8")

    environment = Environment(
        loader=FunctionLoader(read),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = typeset
    style = Markup(ours.joinpath("style.css").read_text("utf-8"))
    return environment.get_template(name).render(style=style, **context)


def drawn(element: str) -> Any:
    """An SVG of ours as part of a page: matplotlib has escaped every user's string in it."""
    with report_extra():
        from markupsafe import Markup
    return Markup(element)
