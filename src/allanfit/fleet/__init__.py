"""Recordings of many devices: analysed side by side, compared, and told as one.

Start with `run_fleet`, which leaves a Parquet dataset behind. `compare` compares the devices in its
rows; `format_summary` and `write_summary` tell what it finds. The extra `fleet` brings what is
needed (`pip install allanfit[fleet]`).
"""

from ._cluster import silence as silence
from ._compare import Comparison as Comparison
from ._compare import compare as compare
from ._errors import FleetError as FleetError
from ._options import Options as Options
from ._page import write_summary as write_summary
from ._run import FleetRun as FleetRun
from ._run import run_fleet as run_fleet
from ._text import format_summary as format_summary
