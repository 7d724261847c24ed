"""Deterministic errors: bias, scale factor and misalignment, with intervals.

`up_down` and `multi_position` serve accelerometers, `rate_table` gyroscopes. Each returns a
`Calibration`, which `calibration_text` and `write_calibration_page` print.
"""

from ._multi_position import multi_position as multi_position
from ._page import write_calibration_page as write_calibration_page
from ._rate_table import rate_table as rate_table
from ._result import AxisCalibration as AxisCalibration
from ._result import Calibration as Calibration
from ._result import Correction as Correction
from ._result import Quantity as Quantity
from ._text import calibration_text as calibration_text
from ._up_down import up_down as up_down
