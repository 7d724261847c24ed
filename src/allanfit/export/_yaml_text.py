"""YAML by hand, with comments, which no writer of the standard kind can place."""

import json
import textwrap

from ..formatting import printable

_WIDTH = 96


def number(value: float) -> str:
    """A number that every YAML reader takes for one, exactly.

    YAML 1.1 reads 1e-05 as text: an exponent needs a point before it.
    """
    text = repr(float(value))
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}{mark}{exponent}"


def rounded(value: float) -> str:
    """A number to six significant digits."""
    return number(float(f"{value:.6g}"))


def text(value: str) -> str:
    """A string between double quotes."""
    return json.dumps(value)


def comment(sentence: str, indent: str = "") -> list[str]:
    """Comment lines."""
    lead = f"{indent}# "
    return textwrap.wrap(printable(sentence), _WIDTH, initial_indent=lead, subsequent_indent=lead)
