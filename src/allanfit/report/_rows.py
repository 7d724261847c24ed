"""The facts of one channel as a list of fields, which the terminal and the page both print."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..coefficient_units import Conversion, field_units, si_unit
from ..coefficients import converged
from ..formatting import (
    Number,
    Reading,
    duration,
    p_value,
    printable,
    reading,
    significant,
    upper_limit,
)

_SAMPLING = {"point": "point samples", "averaged": "samples averaged over their interval"}


_SLOPE_DIGITS = 3


class Row(NamedTuple):
    """One noise term of one channel."""

    symbol: str
    name: str
    resolved: bool
    reading: Reading  # in the user's unit
    field: tuple[Reading, ...]  # in the units of the field, none where the unit is not known
    si: Reading | None  # None where the user's unit is SI already, or not known
    slope: str  # what a ruler reads off the Allan deviation, "" where it is not told
    span: str  # where the term is the largest: "0.01 s to 27 s", "never the largest", or ""

    @property
    def state(self) -> str:
        """Resolved, with the span in which the term is the largest, or not resolved."""
        if not self.resolved:
            return "not resolved"
        return f"resolved, {self.span}" if self.span else "resolved"


def coefficient_rows(channel: Mapping[str, Any]) -> list[Row]:
    """One row a term, in the order of the document."""
    spans = _largest_spans(channel)
    return [
        _row(symbol, entry, channel, spans.get(symbol, ""))
        for symbol, entry in channel["coefficients"].items()
    ]


def _row(symbol: str, entry: Mapping[str, Any], channel: Mapping[str, Any], span: str) -> Row:
    # A coefficient of exactly zero is a limit whatever the flag says: zero is not a measurement.
    resolved = bool(entry["resolved"]) and bool(entry["value"])
    kind, unit = channel["kind"], channel["unit"]
    si = si_unit(kind, unit, symbol)
    own = Conversion(entry["unit"], 1.0)
    return Row(
        symbol=symbol,
        name=entry["name"],
        resolved=resolved,
        reading=_converted(entry, own, resolved),
        field=tuple(
            _converted(entry, conversion, resolved)
            for conversion in field_units(kind, unit, symbol)
        ),
        si=None if si is None or si.factor == 1.0 else _converted(entry, si, resolved),
        slope=_slope(channel, symbol),
        span=span if resolved else "",
    )


def _converted(entry: Mapping[str, Any], conversion: Conversion, resolved: bool) -> Reading:
    def scaled(number: Number | None) -> float | None:
        return None if number is None else number * conversion.factor

    bounds = entry["intervals"].get("0.95") or (None, None)
    if resolved:
        interval = [scaled(bound) for bound in bounds]
        return reading(scaled(entry["value"]), interval, conversion.unit)
    limit = entry["upper_limit_95"]
    return upper_limit(scaled(bounds[1] if limit is None else limit), conversion.unit)


def _slope(channel: Mapping[str, Any], symbol: str) -> str:
    # Documents of earlier versions have no slope reading.
    readings = channel.get("slope_reading") or {}
    if symbol not in readings:
        return ""
    value = readings[symbol]
    return "no such slope" if value is None else significant(value, _SLOPE_DIGITS)


def _largest_spans(channel: Mapping[str, Any]) -> dict[str, str]:
    """For each term drawn the averaging times, first to last, at which no other is larger."""
    curve = channel["curves"]["allan"]
    terms = curve.get("terms") or {}
    times: dict[str, list[float]] = {}
    for index, tau in enumerate(curve["tau_s"]):
        sizes = {symbol: values[index] or 0.0 for symbol, values in terms.items() if values}
        largest = max(sizes, key=lambda symbol: sizes[symbol], default=None)
        if largest is not None and sizes[largest] > 0:
            times.setdefault(largest, []).append(tau)
    drawn = [symbol for symbol, values in terms.items() if any(values or ())]
    return dict.fromkeys(drawn, "never the largest") | {
        symbol: f"{significant(taus[0], 2)} s to {significant(taus[-1], 2)} s"
        for symbol, taus in times.items()
    }


def description(channel: Mapping[str, Any]) -> str:
    """What the channel is: kind, rate, length, mean, sampling, and what was taken out of it."""
    parts = [
        *([channel["kind"]] if channel["kind"] != "other" else []),
        f"{significant(channel['rate_hz'], 6)} Hz",
        f"{channel['samples']} samples",
        duration(channel["duration_s"]),
        f"mean {significant(channel['mean'])} {printable(channel['unit'])}".rstrip(),
        _SAMPLING.get(channel["sampling"], channel["sampling"]),
        *(["effect of temperature taken out"] if _without_temperature(channel) else []),
    ]
    return ", ".join(parts)


def _without_temperature(channel: Mapping[str, Any]) -> bool:
    return bool((channel.get("temperature") or {}).get("removed"))


def fit_sentence(channel: Mapping[str, Any]) -> str:
    """Whether the five terms explain both curves, with the p-value, and what to do if not."""
    goodness = channel["goodness_of_fit"]
    if goodness["p_value"] is None:
        return "the goodness of fit could not be judged"
    shown = p_value(goodness["p_value"])
    if goodness["consistent"]:
        return f"the five terms agree with both curves ({shown})"
    return (
        f"the five terms do not explain the curves ({shown}): run `allanfit explain` on the "
        "recording to find what they leave out"
    )


def slope_sentence(channel: Mapping[str, Any]) -> str:
    """What a ruler reads off the Allan deviation, "" where the document does not tell."""
    readings = channel.get("slope_reading") or {}
    shown = [
        f"{symbol} {significant(value, _SLOPE_DIGITS)}"
        for symbol, value in readings.items()
        if value is not None
    ]
    if not readings:
        return ""
    return f"{', '.join(shown) or 'none'}: the classical reading of the curve, biased"


def has_shares(channel: Mapping[str, Any]) -> bool:
    """Whether the document tells where in the recording any coefficient comes from."""
    return bool((channel.get("influence") or {}).get("share"))


def shares_caption(channel: Mapping[str, Any]) -> str:
    """What the figure of the shares shows, in words, "" where there is none."""
    if not has_shares(channel):
        return ""
    entry = channel["influence"]
    edges = entry["time_s"]
    length = duration((edges[-1] - edges[0]) / (len(edges) - 1))
    marked = any(any(row) for row in entry["stands_out"].values())
    return (
        f"Where in the recording each term comes from. A bar is what {length} of the recording "
        "adds to the square of the coefficient (to the ramp itself), in per cent; a negative one "
        "pulls it down. The black line is what a sensor that stays the same would show. "
        + (
            "Dark bars under a triangle stand out: fewer than one good recording in a hundred has "
            "any."
            if marked
            else "No stretch stands out by more than chance."
        )
    )


def temperature_sentence(channel: Mapping[str, Any]) -> str:
    """What temperature does to the channel, "" where none was recorded."""
    return " ".join((channel.get("temperature") or {}).get("sentences", ()))


def temperature_caption(channel: Mapping[str, Any]) -> str:
    """What the figure of the temperature shows, in words, "" where there is none."""
    entry = channel.get("temperature")
    if not entry:
        return ""
    return (
        f"Slow changes beside {printable(entry['channel'])}. Points are means over "
        f"{duration(channel['duration_s'] / len(entry['slow']['time_s']))}, the line is the "
        "effect of temperature with its 95 % band, which allows for drift of the sensor's own"
        f"{_ramp_drawn(entry['curve'])}. "
        f"Changes of the temperature within {duration(entry['shortest_period_s'])} are not used: "
        "there its own noise is too near."
    )


def _ramp_drawn(curve: Mapping[str, Any]) -> str:
    """What became of the rate ramp; documents of earlier versions do not tell."""
    if "beside_ramp" not in curve:
        return ""
    if curve["beside_ramp"]:
        return " and a rate ramp, which is taken out of the points"
    return " other than a rate ramp, since none is resolved; the intervals in words allow for one"


def sampler_sentence(channel: Mapping[str, Any]) -> str:
    """Where the intervals come from and whether the sampler may be trusted."""
    posterior = channel["posterior"]
    if posterior is None:
        return "intervals from the fast posterior, not sampled"
    worst = [value for value in posterior["r_hat"].values() if value is not None]
    sizes = [value for value in posterior["effective_sample_size"].values() if value is not None]
    parts = [
        f"{posterior['sampler']}, {posterior['draws']} draws",
        f"R-hat at most {max(worst):.3f}" if worst else "R-hat undefined",
        f"effective sample size at least {min(sizes):.0f}"
        if sizes
        else "effective sample size undefined",
        f"acceptance {posterior['acceptance_fraction']:.2f}",
    ]
    verdict = "converged" if posterior["converged"] else "not converged, do not trust the intervals"
    return f"{', '.join(parts)}: {verdict}"


def advice_sentence(channel: Mapping[str, Any]) -> str:
    """How much longer to record for narrower intervals, "" where all are narrow."""
    return " ".join(channel.get("advice") or ())


def warning_sentence(channel: Mapping[str, Any]) -> str:
    """The sentence of a fit that did not converge, "" for one that did."""
    return "" if converged(channel) else channel["status"]
