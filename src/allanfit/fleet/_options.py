"""How every recording of a fleet is analysed."""

import json
from dataclasses import asdict, dataclass

from ..physics import Sampling
from ..temperature import Treatment


@dataclass(frozen=True)
class Options:
    """The options of `allanfit fit` that a fleet shares."""

    rate_hz: float | None = None
    """Samples per second, for recordings that do not say; it overrides those that do."""
    unit: str | None = None
    topic: str | None = None
    """Which part to analyse of recordings that hold several."""
    channels: tuple[str, ...] | None = None
    """Names of the channels to analyse, all by default."""
    sampling: Sampling = "point"
    temperature: Treatment = "show"
    seed: int = 0

    def to_json(self) -> str:
        """One text for one set of options: results of equal texts can stand side by side."""
        return json.dumps(asdict(self), sort_keys=True)
