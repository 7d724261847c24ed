"""A plan for every channel of a coefficients file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..coefficients import read_coefficients
from ..physics import Sampling
from ._plan import Plan, plan
from ._want import checked_want

SCHEMA = "allanfit.plan/1"


@dataclass(frozen=True)
class FilePlan:
    """The plans of the channels of one file, by name."""

    file: str
    channels: dict[str, Plan]
    units: dict[str, str]
    left_out: tuple[str, ...] = ()
    """Which channels have no plan, and why, a sentence each."""

    @property
    def duration_s(self) -> float | None:
        """Length that serves every channel [s]; None if something is out of reach."""
        lengths = [entry.duration_s for entry in self.channels.values()]
        known = [length for length in lengths if length is not None]
        return max(known) if len(known) == len(lengths) else None

    def to_dict(self) -> dict[str, Any]:
        """The plan JSON, schema allanfit.plan/1."""
        return {
            "schema": SCHEMA,
            "coefficients": self.file,
            "duration_s": self.duration_s,
            "channels": [
                {"channel": name, "unit": self.units[name], **entry.to_dict()}
                for name, entry in self.channels.items()
            ],
            "left_out": list(self.left_out),
        }


def plan_file(
    path: str | Path,
    rate_hz: float,
    want: Mapping[str, float],
    *,
    channels: list[str] | None = None,
    sampling: Sampling | None = None,
) -> FilePlan:
    """Plan for the channels of a fit JSON, or for a YAML or JSON mapping of symbols to values.

    What a fit has not resolved counts as absent: its size is not known. A channel that lacks what
    is wanted is left out. `sampling` is the file's unless given.

    **Raises:** `ValueError` as `allanfit.plan` does, or where no channel has what is wanted, naming
    the first, and `CoefficientsError` as `read_coefficients` does.
    """
    path = Path(path)
    want = checked_want(want)
    entries = read_coefficients(path, channels)
    plans, lacking = {}, {}
    for entry in entries:
        absent = [symbol for symbol in want if not entry.values.get(symbol)]
        if absent:
            lacking[entry.channel] = absent
            continue
        plans[entry.channel] = plan(entry.values, rate_hz, want, sampling or entry.sampling)
    if not plans:
        channel, (symbol, *_) = next(iter(lacking.items()))
        raise ValueError(
            f"{symbol} is wanted, but {channel} of {path.name} has none that is resolved and "
            f"above zero; leave {symbol} out, or choose channels that have it."
        )
    left_out = tuple(
        f"{channel} is left out: it has no {' and no '.join(absent)} that is resolved and above "
        "zero."
        for channel, absent in lacking.items()
    )
    units = {entry.channel: entry.unit for entry in entries if entry.channel in plans}
    return FilePlan(path.name, plans, units, left_out)
