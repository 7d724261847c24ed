"""Results as tables in a notebook, which needs neither figures nor templates."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ..formatting import Reading, duration, printable, reading, significant, upper_limit
from ._explain_rows import change_rows, effect_rows, unchanged_rows
from ._explain_verdict import verdict_sentence
from ._rows import Row, coefficient_rows, fit_sentence, warning_sentence
from ._units import typeset

_SENSORS = 10  # of many that are shown


def html_table(
    caption: str, head: Sequence[str], rows: Sequence[Sequence[str]], notes: Sequence[str] = ()
) -> str:
    """A table with a caption above and notes below; every string is escaped."""

    def cells(tag: str, row: Sequence[str]) -> str:
        lines = ("<br>".join(map(_escaped, cell.split("\n"))) for cell in row)
        return "".join(f'<{tag} style="text-align:left">{each}</{tag}>' for each in lines)

    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return (
        f"<p><b>{_escaped(caption)}</b></p>"
        f"<table><thead><tr>{cells('th', head)}</tr></thead><tbody>{body}</tbody></table>"
        + "".join(f"<p>{_escaped(note)}</p>" for note in notes if note)
    )


def _escaped(text: str) -> str:
    return escape(printable(text))


def shown(each: Reading) -> str:
    """A value with its interval and unit."""
    return " ".join(part for part in (each.value, each.interval, typeset(each.unit)) if part)


def _lines(row: Row) -> str:
    return "\n".join(map(shown, (row.reading, *row.field)))


def fit_html(document: Mapping[str, Any]) -> str:
    """A fit document: a table a channel, each term with its 95 % interval or upper limit."""
    return "".join(
        html_table(
            f"{heading(channel)}: 95 % intervals",
            ("", "noise term", "value", ""),
            [(row.symbol, row.name, _lines(row), row.state) for row in coefficient_rows(channel)],
            (
                warning_sentence(channel),
                f"Fit: {fit_sentence(channel)}.",
                *document["findings"],
                *channel["findings"],
            ),
        )
        for channel in document["channels"]
    )


def fits_html(
    values: Mapping[str, Sequence[float]],
    intervals: Mapping[str, Sequence[Sequence[float]]],
    limits: Mapping[str, Sequence[float]],
    resolved: Mapping[str, Sequence[bool]],
) -> str:
    """The fits of many sensors, by symbol: the first of them, a row each."""
    count = len(next(iter(values.values())))
    rows = [
        (
            str(sensor),
            *(
                shown(
                    reading(values[symbol][sensor], intervals[symbol][sensor], "")
                    if resolved[symbol][sensor]
                    else upper_limit(limits[symbol][sensor], "")
                )
                for symbol in values
            ),
        )
        for sensor in range(min(count, _SENSORS))
    ]
    more = f"{count - len(rows)} more sensors." if count > len(rows) else ""
    caption = f"{count} sensors: 95 % intervals, in the unit of the data and seconds"
    return html_table(caption, ("sensor", *values), rows, [more])


def explanation_html(document: Mapping[str, Any]) -> str:
    """An explanation: for each channel the verdict, the effects and the coefficients."""
    return "".join(map(_explained, document["channels"]))


def _explained(channel: Mapping[str, Any]) -> str:
    effects = [
        (
            effect.name,
            effect.probability,
            "\n".join(
                f"{quantity.name} {shown(quantity.readings[0])}" for quantity in effect.quantities
            ),
        )
        for effect in effect_rows(channel)
    ]
    changes = change_rows(channel)
    if not changes:
        rows = [(row.symbol, row.name, _lines(row)) for row in unchanged_rows(channel)]
        coefficients = html_table(
            f"{heading(channel)}: 95 % intervals", ("", "noise term", "value"), rows
        )
    else:
        rows = [
            (row.before.symbol, row.before.name, _lines(row.before), _lines(row.after), row.remark)
            for row in changes
        ]
        head = ("", "noise term", "five terms", "better model", "change")
        coefficients = html_table("What becomes of the coefficients", head, rows)
    verdict = f"{heading(channel)}: {verdict_sentence(channel)}"
    if not effects:
        return f"<p><b>{_escaped(verdict)}</b></p>{coefficients}"
    return html_table(verdict, ("what is left out", "probability", ""), effects) + coefficients


def heading(channel: Mapping[str, Any]) -> str:
    """The channel's name with its rate and length."""
    rate = f"{significant(channel['rate_hz'], 6)} Hz"
    return f"{channel['channel']}, {rate}, {duration(channel['duration_s'])}"
