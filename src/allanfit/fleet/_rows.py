"""The columns of the results, and the rows of one recording."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..identify import ChannelFit, RecordingFit
from ..identify._fit_document import channel_header, coefficients_document
from ..identify._nyquist import nyquist_score
from ..physics import SYMBOLS
from ._devices import places

if TYPE_CHECKING:
    import pyarrow

SCHEMA = "allanfit.fleet/1"
#: What `status` says.
CONVERGED, NOT_CONVERGED, FAILED = "converged", "not converged", "failed"

Row = dict[str, Any]

_TEXT = ("recording", "path", "channel", "quantity", "device", "kind", "unit", "si_unit")
_NUMBERS = ("si_factor", "rate_hz", "duration_s", "p_value", "nyquist_score")
_ABOUT = ("status", "error", "checksum", "file_sha256", "options", "allanfit_version")


def columns(symbol: str) -> dict[str, str]:
    """The columns of a coefficient, by what they hold."""
    return {
        "value": symbol,
        "resolved": f"{symbol}_resolved",
        "upper_limit": f"{symbol}_upper_limit_95",
        "low": f"{symbol}_low_95",
        "high": f"{symbol}_high_95",
        "unit": f"{symbol}_unit",
    }


def arrow_schema() -> "pyarrow.Schema":
    """The same columns in every part, so that all parts are read as one."""
    import pyarrow

    text, number = pyarrow.string(), pyarrow.float64()
    fields = [*((name, text) for name in _TEXT), ("samples", pyarrow.int64())]
    fields += [(name, number) for name in _NUMBERS]
    kinds = {"resolved": pyarrow.bool_(), "unit": text}
    for symbol in SYMBOLS:
        fields += [(name, kinds.get(what, number)) for what, name in columns(symbol).items()]
    fields += [(name, text) for name in _ABOUT]
    fields.append(("findings", pyarrow.list_(text)))
    return pyarrow.schema(fields, metadata={"schema": SCHEMA})


def rows_of_fit(path: Path, result: RecordingFit) -> list[Row]:
    """A row a channel, in the unit of the recording."""
    recording = result.recording
    where = places(recording.name, [each.channel.name for each in result.channels])
    common = {"recording": recording.name, "path": str(path), "checksum": recording.checksum}
    return [
        {
            **common,
            **where[each.channel.name]._asdict(),
            **_numbers(each),
            "findings": [*recording.findings, *each.findings],
        }
        for each in result.channels
    ]


def row_of_error(path: Path, error: str) -> Row:
    """The one row of a recording that could not be analysed."""
    return {
        "recording": path.name,
        "path": str(path),
        "status": FAILED,
        "error": error,
        "findings": [],
    }


def stamped(
    rows: Sequence[Row], *, file_sha256: str | None, options: str, version: str
) -> list[Row]:
    """The rows with what decides whether they are still good."""
    stamp = {"file_sha256": file_sha256, "options": options, "allanfit_version": version}
    return [{**row, **stamp} for row in rows]


def _numbers(each: ChannelFit) -> Row:
    channel, result = each.channel, each.fit
    header = channel_header(channel, result)
    kept = ("channel", "kind", "unit", "si_unit", "rate_hz", "samples", "duration_s")
    row = {name: header[name] for name in kept} | {"si_factor": channel.factor}
    if not bool(result.converged):
        return row | {"status": NOT_CONVERGED}
    row |= {
        "status": CONVERGED,
        "p_value": float(result.goodness_of_fit),
        "nyquist_score": nyquist_score(result),
    }
    for symbol, entry in coefficients_document(result, channel).items():
        low, high = entry["intervals"]["0.95"]
        values = {
            "value": entry["value"],
            "resolved": entry["resolved"],
            "upper_limit": entry["upper_limit_95"],
            "low": low,
            "high": high,
            "unit": entry["unit"],
        }
        row |= {name: values[what] for what, name in columns(symbol).items()}
    return row
