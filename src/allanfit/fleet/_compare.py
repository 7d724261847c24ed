"""The fleet as one: each quantity over its devices, and the devices that do not belong."""

import math
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..identify._goodness import MISFIT
from ..physics import SYMBOLS
from ._copies import Copy, find_copies, natural
from ._devices import labels
from ._outliers import FEWEST, Deviate, outliers
from ._rows import CONVERGED, Row, columns
from ._spread import Spread, spread

#: Chance of naming any outlier in a fleet without one.
FALSE_ALARM = 0.01
#: The same shared out: to coefficients, to the fit as a whole, and to the end of the spectrum.
_SHARES = {"coefficient": 0.7, "fit": 0.15, "spectrum": 0.15}
# A fleet is compared by values where so many devices resolve them, else by limits.
_MOSTLY = 0.75
_QUANTILE_95 = 1.959964


Bound = Literal["its value", "its limit", "limits"]


@dataclass(frozen=True)
class Point:
    """One coefficient of one device, in the unit of its quantity."""

    device: str
    value: float
    """The upper limit where the term is not resolved."""
    low: float
    high: float
    resolved: bool
    outlier: bool


@dataclass(frozen=True)
class Coefficient:
    """One coefficient over the devices."""

    symbol: str
    unit: str
    points: tuple[Point, ...]
    spread: Spread | None
    """Of the logarithms, of all but the outliers; None where too few devices resolve it."""

    @property
    def resolved(self) -> int:
        """The number of devices that resolve it."""
        return sum(point.resolved for point in self.points)


@dataclass(frozen=True)
class Outlier:
    """A device that does not belong, in one respect."""

    device: str
    quantity: str
    path: str
    channel: str
    subject: str
    """A symbol, "fit" or "spectrum"."""
    number: float
    """How many times the middle of the others; the p-value; the score."""
    bound: Bound | None
    """For a coefficient, whether it or the middle is a limit."""
    usual: float | None
    """For the spectrum, the middle of the others' scores."""
    findings: tuple[tuple[str, int], ...]
    """What its fit says, and how many of the others' say the same."""
    others: int


@dataclass(frozen=True)
class Quantity:
    """One channel over all devices, such as `accel_z`."""

    name: str
    unit: str
    devices: tuple[str, ...]
    coefficients: tuple[Coefficient, ...]
    misfits: int
    """Devices whose noise the five terms do not describe."""


@dataclass(frozen=True)
class Comparison:
    """What `compare` finds."""

    quantities: tuple[Quantity, ...]
    outliers: tuple[Outlier, ...]
    copies: tuple[Copy, ...] = ()
    """Recordings that are left out, since they would count a device twice."""


def compare(rows: Sequence[Row]) -> Comparison:
    """Compare the devices in the rows of a fleet.

    Rows without a converged fit are left out, and so are those of a recording whose file is, byte
    for byte, that of another: one device would count as two that agree in all.
    """
    fitted = [row for row in rows if row["status"] == CONVERGED]
    copies = find_copies(fitted)
    again = {copy.path for copy in copies}
    fitted = [row for row in fitted if row["path"] not in again]
    named = labels([(row["path"], row["device"]) for row in fitted])
    groups: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for row in fitted:
        groups[row["quantity"], row["si_unit"]].append(row)
    for group in groups.values():
        group.sort(key=lambda row: natural(named[row["path"], row["device"]]))
    # The chance is shared out to all that is asked.
    asked = sum(len(group) >= FEWEST for group in groups.values()) or 1
    quantities, found = [], []
    for (name, _), group in groups.items():
        devices = tuple(named[row["path"], row["device"]] for row in group)
        unit, factor = Counter((row["unit"], row["si_factor"]) for row in group).most_common(1)[0][
            0
        ]
        coefficients = []
        for symbol in SYMBOLS:
            alpha = FALSE_ALARM * _SHARES["coefficient"] / asked / len(SYMBOLS)
            coefficient, odd = _coefficient(symbol, group, devices, factor, alpha)
            coefficients.append(coefficient)
            found += [
                _outlier(
                    group,
                    devices,
                    each.index,
                    symbol,
                    math.exp(each.distance),
                    bound=_bound(coefficient, each.index),
                )
                for each in odd
            ]
        found += _odd_fits(group, devices, FALSE_ALARM * _SHARES["fit"] / asked)
        found += _odd_spectra(group, devices, FALSE_ALARM * _SHARES["spectrum"] / asked)
        misfits = sum(row["p_value"] < MISFIT for row in group)
        quantities.append(Quantity(name, unit, devices, tuple(coefficients), misfits))
    found.sort(key=lambda each: natural(each.device))
    return Comparison(tuple(quantities), tuple(found), copies)


def _coefficient(
    symbol: str, group: Sequence[Row], devices: Sequence[str], factor: float, alpha: float
) -> tuple[Coefficient, list[Deviate]]:
    names = columns(symbol)
    scale = np.array([row["si_factor"] / factor for row in group])
    resolved = np.array([row[names["resolved"]] for row in group])
    limit = np.array([row[names["upper_limit"]] or math.nan for row in group]) * scale
    value = np.where(resolved, [row[names["value"]] for row in group] * scale, limit)
    low, high = (np.array([row[names[end]] for row in group]) * scale for end in ("low", "high"))
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = np.log(high / low) / 2 / _QUANTILE_95
        logs = np.log(value)
    mostly = resolved.mean() >= _MOSTLY
    # A limit has no error of its own: among values it counts as one of them, and limits scatter.
    errors = np.where(resolved, errors, np.median(errors[resolved]) if mostly else 0.0)
    # Among values, a limit tells something where it is below them.
    below = logs < np.median(logs[resolved]) if mostly else np.ones(len(logs), bool)
    used = np.flatnonzero(np.isfinite(logs) & np.isfinite(errors) & (resolved | below))
    odd = [
        Deviate(int(used[each.index]), each.distance, each.deviations)
        for each in outliers(logs[used], errors[used], alpha, above=not mostly)
    ]
    # Only what is seen stands out among limits.
    odd = [each for each in odd if mostly or resolved[each.index]]
    taken_out = {each.index for each in odd}
    rest = [index for index in used if resolved[index] and index not in taken_out]
    unit = next(row[names["unit"]] for row in group if row["si_factor"] == factor)
    points = tuple(
        Point(
            device,
            float(value[index]),
            float(low[index]),
            float(high[index]),
            bool(resolved[index]),
            index in taken_out,
        )
        for index, device in enumerate(devices)
    )
    whole = spread(logs[rest], errors[rest]) if mostly and len(rest) > 2 else None
    return Coefficient(symbol, unit, points, whole), odd


def _bound(coefficient: Coefficient, index: int) -> Bound:
    if coefficient.spread is None:
        return "limits"
    return "its value" if coefficient.points[index].resolved else "its limit"


def _odd_fits(group: Sequence[Row], devices: Sequence[str], alpha: float) -> list[Outlier]:
    """Devices that the five terms do not describe, in a fleet that they do."""
    p_values = np.array([row["p_value"] for row in group])
    if len(group) < FEWEST or np.median(p_values) < MISFIT:
        return []
    odd = np.flatnonzero(p_values < alpha / len(group))
    return [_outlier(group, devices, int(i), "fit", float(p_values[i])) for i in odd]


def _odd_spectra(group: Sequence[Row], devices: Sequence[str], alpha: float) -> list[Outlier]:
    """Devices whose spectrum falls toward the Nyquist frequency more than the others'."""
    scores = np.array([row["nyquist_score"] for row in group])
    odd = outliers(-scores, np.ones(len(scores)), alpha, above=True)
    return [
        _outlier(
            group,
            devices,
            each.index,
            "spectrum",
            float(scores[each.index]),
            usual=float(scores[each.index]) + each.distance,
        )
        for each in odd
    ]


def _outlier(
    group: Sequence[Row],
    devices: Sequence[str],
    index: int,
    subject: str,
    number: float,
    *,
    bound: Bound | None = None,
    usual: float | None = None,
) -> Outlier:
    row = group[index]
    others = [each for each in group if each is not row]
    said = Counter(gist for each in others for gist in set(map(_gist, each["findings"])))
    return Outlier(
        device=devices[index],
        quantity=row["quantity"],
        path=row["path"],
        channel=row["channel"],
        subject=subject,
        number=number,
        bound=bound,
        usual=usual,
        findings=tuple((text, said[_gist(text)]) for text in row["findings"]),
        others=len(others),
    )


def _gist(finding: str) -> str:
    """A finding without its numbers, which differ from device to device."""
    return re.sub(r"\d[\d.,e+-]*", "#", finding)
