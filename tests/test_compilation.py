"""Settings of XLA: one that a release does not know would end the process."""

import pytest

from allanfit.compilation import _flags


@pytest.mark.parametrize(
    ("release", "known"), [("0.7.0", True), ("0.10.2", True), ("0.12.1", False)]
)
def test_flags_are_given_to_releases_that_know_them(release, known):
    flags = _flags(release).split()
    assert ("--xla_cpu_use_fusion_emitters=false" in flags) is known
    assert "--xla_backend_optimization_level=1" in flags
