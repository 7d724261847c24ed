"""Turn a fit or an explanation into text, JSON, figures and a page.

Every function takes the plain dictionary of schema `allanfit.fit/1`, or of `allanfit.explain/1`
where its name says so, so that a page can be made again from a stored JSON file. Start with
`format_text`; `write_page`, `write_explanation`, `figure` and `write_figures` need the extra
`report` (`pip install allanfit[report]`), the others need nothing.
"""

from ._errors import ReportError as ReportError
from ._explain_page import write_explanation as write_explanation
from ._explain_text import format_explanation as format_explanation
from ._figures import figure as figure
from ._json import write_json as write_json
from ._notebook import explanation_html as explanation_html
from ._notebook import fit_html as fit_html
from ._notebook import fits_html as fits_html
from ._page import write_page as write_page
from ._paper import refuse_other_figures as refuse_other_figures
from ._paper import write_figures as write_figures
from ._text import format_text as format_text
