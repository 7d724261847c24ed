"""Bad recordings on the command line: one sentence, in time, and no code of theirs runs."""

import re

import pytest
from bad_formats import BAD as BAD_FORMATS
from bad_recordings import BAD, make


class Accepted(BaseException):
    """Not an Exception, so that no handler of the program hides it."""


@pytest.mark.parametrize("case", BAD | BAD_FORMATS)
def test_it_is_refused_before_the_fit(case, tmp_path, refused, monkeypatch):
    def fitted(*_, **__):
        raise Accepted

    monkeypatch.setattr("allanfit.cli.fit_recording", fitted)
    bad = (BAD | BAD_FORMATS)[case]
    path = make(tmp_path, bad)
    line = refused("fit", str(path), *bad.options, "--json", "fit.json", "--report", "fit.html")
    assert re.search(bad.message, line), line
