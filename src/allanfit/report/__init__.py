"""Turn a fit document into text, JSON, figures and a page.

Every function takes the plain dictionary of schema `allanfit.fit/1`, so a page can be made again
from a stored JSON file. Start with `format_text`; `write_page` and `figure` need the extra
`report` (`pip install allanfit[report]`), the other two need nothing.
"""

from ._errors import ReportError as ReportError
from ._figures import figure as figure
from ._json import write_json as write_json
from ._page import write_page as write_page
from ._text import format_text as format_text
