"""Sentences of an explanation."""

import numpy as np
import pytest

from allanfit.explain._words import without_pointer
from allanfit.recording import recording_of


@pytest.mark.parametrize("kind", ["coarse", "alone"])
def test_an_explanation_does_not_point_to_itself(kind):
    """What the findings of such recordings say for a reader of a fit."""
    values = np.random.default_rng(1).standard_normal(20_000)
    if kind == "coarse":
        values = np.round(values / 2) * 2
    else:
        values[::500] += 50
    (channel,) = recording_of(values, rate_hz=100.0, unit="rad/s").channels
    pointing = [each for each in channel.findings if "`allanfit explain`" in each]
    assert pointing
    for finding in pointing:
        left = without_pointer(finding)
        assert "explain" not in left
        assert left.endswith(".")
        assert finding.startswith(left[:-1])
    for finding in set(channel.findings) - set(pointing):
        assert without_pointer(finding) == finding
