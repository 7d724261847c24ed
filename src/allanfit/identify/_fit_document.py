"""The parts of the JSON of a recording: its head, a channel's head, and its coefficients."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ..formatting import finite
from ..physics import STANDARD_TERMS, Names, coefficient_unit
from ..recording import Channel, Recording
from ..recording._checks import usable
from ._fit import Fit


@runtime_checkable
class Document(Protocol):
    """Anything that is told in JSON."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        ...


def recording_document(
    schema: str, recording: Recording, channels: Sequence[Document]
) -> dict[str, Any]:
    """The JSON of any analysis of a recording, an entry a channel."""
    return {
        "schema": schema,
        "recording": recording.name,
        "checksum": recording.checksum,
        "allanfit_version": version("allanfit"),
        "findings": list(recording.findings),
        "channels": [channel.to_dict() for channel in channels],
    }


def channel_header(channel: Channel, result: Fit) -> dict[str, Any]:
    """What begins a channel's entry: what it is, in the unit that the user gave."""
    used = sum(result.design.lengths)
    return {
        "channel": channel.name,
        "unit": channel.unit,
        "si_unit": channel.si_unit,
        "kind": channel.kind,
        "rate_hz": float(result.rate_hz),
        "samples": used,
        "duration_s": used / float(result.rate_hz),
        "sampling": result.design.sampling,
        "mean": float(np.mean(usable(channel.samples, channel.stretches))) / channel.factor,
    }


def coefficients_document(result: Fit, channel: Channel) -> dict[str, Any]:
    """The `coefficients` of the fit JSON, in the unit that the user gave."""
    factor = channel.factor
    values, limits, resolved = result.coefficients, result.upper_limits, result.resolved
    intervals = {"0.68": result.interval(0.68), "0.95": result.interval(0.95)}
    document = {}
    for term in STANDARD_TERMS:
        symbol = term.symbol
        seen = bool(resolved[symbol])
        document[symbol] = {
            "name": _name(term.names, channel.kind),
            "unit": coefficient_unit(term, channel.unit),
            "value": finite(values[symbol] / factor),
            "least_squares": finite(result.least_squares[symbol] / factor),
            "resolved": seen,
            "upper_limit_95": None if seen else finite(limits[symbol] / factor),
            "intervals": {
                level: [finite(end / factor) for end in interval[symbol]]
                for level, interval in intervals.items()
            },
        }
    return document


def exact_document(values: Mapping[str, float], channel: Channel) -> dict[str, Any]:
    """As `coefficients_document`, of coefficients [SI] that somebody has set: without intervals."""
    return {
        term.symbol: {
            "name": _name(term.names, channel.kind),
            "unit": coefficient_unit(term, channel.unit),
            "value": values[term.symbol] / channel.factor,
            "least_squares": values[term.symbol] / channel.factor,
            "resolved": True,
            "upper_limit_95": None,
            "intervals": {},
        }
        for term in STANDARD_TERMS
    }


def _name(names: Names, kind: str) -> str:
    return {"gyro": names.gyro, "accelerometer": names.accelerometer}.get(kind, names.other)
