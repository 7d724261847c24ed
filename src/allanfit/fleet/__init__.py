"""Recordings of many devices: analysed side by side, compared, and told as one.

Start with `run_fleet`, which leaves a Parquet dataset behind; `summarise` compares the devices in
its rows. The extra `fleet` brings what is needed (`pip install allanfit[fleet]`).
"""

from ._errors import FleetError as FleetError
from ._options import Options as Options
from ._run import FleetRun as FleetRun
from ._run import run_fleet as run_fleet
