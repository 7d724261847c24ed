"""What a comparison says, in sentences that the terminal and the page share."""

import math
from collections.abc import Sequence
from pathlib import Path

from ..formatting import Reading, p_value, reading, significant
from ._compare import Coefficient, Outlier, Quantity
from ._copies import Copy
from ._run import FleetRun

# Above this p-value devices are not said to differ.
_SIGNIFICANT = 0.05
_COPIES = 10  # that are named; all are in the dataset


def counts_sentence(run: FleetRun, devices: int) -> str:
    """What was done; each recording is counted once."""
    unchanged = run.unchanged - (len(run.errors) - run.failed)
    channels = sum(row["channel"] is not None for row in run.rows)
    parts = [
        f"{_count(len(run.recordings), 'recording')}, {_count(channels, 'channel')} of "
        f"{_count(devices, 'device')}: {run.analysed - run.failed} analysed now, {unchanged} "
        "unchanged since an earlier run."
    ]
    if run.errors:
        parts.append(f"{_count(len(run.errors), 'recording')} could not be analysed.")
    if run.kept:
        parts.append(
            f"{_count(len(run.kept), 'recording')} could not be read again; the earlier results "
            "stay."
        )
    return " ".join(parts)


def copies_sentence(copies: Sequence[Copy]) -> str:
    """Which recordings are there twice, and that they count once; "" where none is."""
    if not copies:
        return ""
    told = [_copy(each) for each in copies[:_COPIES]]
    if len(copies) > _COPIES:
        told.append(f"and {len(copies) - _COPIES} more, see the column `file_sha256`")
    one = len(copies) == 1
    return (
        f"{_count(len(copies), 'recording')} {'is a copy' if one else 'are copies'}, byte for "
        f"byte, and {'is' if one else 'are'} left out of the comparison: {', '.join(told)}."
    )


def _copy(copy: Copy) -> str:
    path, original = Path(copy.path), Path(copy.original)
    if path.name == original.name:
        return f"{path} of {original}"
    return f"{path.name} of {original.name}"


def middle_reading(coefficient: Coefficient) -> Reading:
    """The fleet's middle with its interval."""
    found = coefficient.spread
    if found is None:
        return Reading("", "", coefficient.unit)
    low, high = found.middle_interval
    ends = (math.exp(low), math.exp(high))
    return reading(math.exp(found.middle), ends, coefficient.unit)


def spread_sentence(coefficient: Coefficient) -> str:
    """Whether the devices are one in this coefficient."""
    found = coefficient.spread
    if found is None:
        return _limits_sentence(coefficient)
    low, high = (_per_cent(end) for end in found.tau_interval)
    without = "without the outliers, " if any(p.outlier for p in coefficient.points) else ""
    if found.p_value < _SIGNIFICANT:
        return (
            f"{without}devices differ by {_per_cent(found.tau)} % beyond their own uncertainty "
            f"(95 % interval {low} to {high} %, {p_value(found.p_value)}, I² = "
            f"{significant(100 * found.share, 2)} %)"
        )
    return (
        f"{without}devices agree within their own uncertainty ({p_value(found.p_value)}; they "
        f"differ by less than {high} %)"
    )


def _limits_sentence(coefficient: Coefficient) -> str:
    size = len(coefficient.points)
    if coefficient.resolved:
        return f"resolved on {coefficient.resolved} of {_count(size, 'device')}"
    limits = [point.value for point in coefficient.points if math.isfinite(point.value)]
    if not limits:
        return "not resolved"
    low, high = significant(min(limits), 2), significant(max(limits), 2)
    between = low if low == high else f"{low} to {high}"
    return f"not resolved on any device: below {between} {coefficient.unit}".rstrip()


def fits_sentence(quantity: Quantity) -> str:
    """On how many devices the five terms are not all there is."""
    size = len(quantity.devices)
    if not quantity.misfits:
        return f"The five terms describe {'the device' if size == 1 else 'all devices'}."
    return (
        f"Something is left out of the five terms on {quantity.misfits} of "
        f"{_count(size, 'device')}; `allanfit explain` tells what."
    )


def outlier_sentence(outlier: Outlier) -> str:
    """Which device stands out, and how."""
    where = f"{outlier.device}, {outlier.quantity}"
    if outlier.subject == "fit":
        return (
            f"{where}: the five terms do not describe the noise ({p_value(outlier.number)}), as "
            "they do that of most others."
        )
    if outlier.subject == "spectrum":
        return (
            f"{where}: the spectrum falls toward the Nyquist frequency by "
            f"{significant(-outlier.number, 2)} standard deviations (the others': "
            f"{significant(-(outlier.usual or 0.0), 2)}), as behind a low-pass filter."
        )
    below = "below " if outlier.bound == "its limit" else ""
    middle = "the usual upper limit" if outlier.bound == "limits" else "the fleet's middle"
    times = significant(outlier.number, 3)
    return f"{where}: {outlier.subject} is {below}{times} times {middle}."


def finding_sentence(finding: str, shared: int, others: int) -> str:
    """A finding of an outlier, and whether it tells it from the others."""
    if not shared:
        return finding
    return f"{finding} (So on {shared} of the {others} others.)"


def grouped(outliers: tuple[Outlier, ...]) -> list[list[Outlier]]:
    """What stands out on one channel of one device belongs together."""
    groups: dict[tuple[str, str], list[Outlier]] = {}
    for each in outliers:
        groups.setdefault((each.path, each.channel), []).append(each)
    return list(groups.values())


def _per_cent(tau: float) -> str:
    return significant(100 * math.expm1(tau), 2)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")
