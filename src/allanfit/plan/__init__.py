"""How long to record: the length at which a fit will know each coefficient well enough.

Start with `plan`; `plan_file` does it for each channel of a coefficients file, and `advice` says
what a longer record would do for a fit.
"""

from ._advice import advice as advice
from ._file import FilePlan as FilePlan
from ._file import plan_file as plan_file
from ._plan import Plan as Plan
from ._plan import plan as plan
from ._text import plan_text as plan_text
from ._want import parse_want as parse_want
