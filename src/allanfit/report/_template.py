"""Filling in a page: the one place where text becomes HTML, every user's string escaped."""

from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any

from ._errors import report_extra
from ._plotly import as_script
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


def live_figures(
    channel: Mapping[str, Any],
    figure: Callable[[Mapping[str, Any], str], dict[str, Any] | None],
    interactive: bool,
) -> dict[str, Any]:
    """Both curves of a channel as scripts for plotly, "" for one that has nothing to show."""
    found = {kind: interactive and figure(channel, kind) for kind in ("allan", "psd")}
    return {kind: drawn(as_script(each)) if each else "" for kind, each in found.items()}


def drawn(element: str) -> Any:
    """An SVG or script of ours as part of a page: every user's string in it is escaped."""
    with report_extra():
        from markupsafe import Markup
    return Markup(element)
