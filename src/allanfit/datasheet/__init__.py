"""Data sheets: what their lines mean, and whether a sensor keeps to them.

Start with `read_datasheet`; `allanfit.fit(recording, datasheet=...)` compares.
"""

from ._judge import Judged as Judged
from ._judge import Measured as Measured
from ._judge import SheetVerdict as SheetVerdict
from ._judge import Shown as Shown
from ._judge import datasheet_document as datasheet_document
from ._judge import judge as judge
from ._phrase import DatasheetError as DatasheetError
from ._read import Datasheet as Datasheet
from ._read import datasheet_from as datasheet_from
from ._read import is_datasheet as is_datasheet
from ._read import left_out_of as left_out_of
from ._read import read_datasheet as read_datasheet
from ._words import Line as Line
