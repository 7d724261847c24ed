"""The summary of a fleet for the terminal."""

import textwrap

from ..formatting import printable
from ._compare import FALSE_ALARM, FEWEST, Comparison, Quantity
from ._run import FleetRun
from ._words import (
    copies_sentence,
    counts_sentence,
    finding_sentence,
    fits_sentence,
    grouped,
    middle_reading,
    outlier_sentence,
    spread_sentence,
)

_WIDTH = 100
_ERRORS = 10  # that are told one by one; all are in the dataset


def format_summary(run: FleetRun, comparison: Comparison) -> str:
    """Plain text: each quantity over the fleet, outliers, and what could not be analysed."""
    devices = {device for each in comparison.quantities for device in each.devices}
    blocks = [_wrapped(counts_sentence(run, len(devices)))]
    if said := copies_sentence(comparison.copies):
        blocks.append(_wrapped(said))
    blocks += [_quantity(each) for each in comparison.quantities]
    blocks.append(_outliers(comparison))
    if run.errors or run.kept:
        told = [error for _, error in (*run.errors, *run.kept)]
        lines = [line for error in told[:_ERRORS] for line in _wrapped(error, "  - ")]
        if len(told) > _ERRORS:
            lines.append(f"  and {len(told) - _ERRORS} more: see the column `error`.")
        blocks.append(["Not analysed:", *lines])
    return "\n\n".join("\n".join(block) for block in blocks)


def _quantity(quantity: Quantity) -> list[str]:
    unit = f" [{printable(quantity.unit)}]" if quantity.unit else ""
    lines = [f"{printable(quantity.name)}{unit}, {len(quantity.devices)} devices"]
    for coefficient in quantity.coefficients:
        middle = middle_reading(coefficient)
        told = f"{middle}: " if middle.value else ""
        lines += _wrapped(told + spread_sentence(coefficient), f"  {coefficient.symbol}  ")
    return [*lines, *_wrapped(fits_sentence(quantity), "  ")]


def _outliers(comparison: Comparison) -> list[str]:
    chance = f"{100 * FALSE_ALARM:.0f} % of fleets without one would show any"
    if all(len(each.devices) < FEWEST for each in comparison.quantities):
        return [f"Outliers are told among {FEWEST} devices or more."]
    if not comparison.outliers:
        return [f"No device stands out ({chance})."]
    lines = [f"Devices that stand out ({chance}):"]
    for group in grouped(comparison.outliers):
        for each in group:
            lines += _wrapped(outlier_sentence(each), "  - ")
        for finding, shared in group[0].findings:
            lines += _wrapped(finding_sentence(finding, shared, group[0].others), "      ")
    return lines


def _wrapped(text: str, indent: str = "") -> list[str]:
    hanging = " " * len(indent)
    return textwrap.wrap(
        printable(text), _WIDTH, initial_indent=indent, subsequent_indent=hanging
    ) or [""]
