"""Bad coefficients on the command line, in every command that reads them."""

import json
import os
import re

import equinox as eqx
import jax
import numpy as np
import pytest
from bad_coefficients import BAD

import allanfit
from allanfit.coefficients import read_coefficients
from allanfit.export import read_fit

SIMULATE = ("--duration", "1", "--rate", "100", "--output", "out.npz")
PLAN = ("--rate", "100", "--want", "N=1%")


@pytest.mark.parametrize("case", BAD)
def test_simulate_and_plan_refuse(case, tmp_path, refused):
    content, message = BAD[case]
    path = tmp_path / "c.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refused("simulate", str(path), *SIMULATE)
    assert re.search(message, line), line
    assert refused("plan", str(path), *PLAN)


@pytest.mark.parametrize("case", BAD)
def test_export_refuses(case, tmp_path, refused):
    content, _ = BAD[case]
    path = tmp_path / "fit.json"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refused("export", str(path), "--format", "kalman", "--output", "out.json")
    assert re.search("is empty|is not a fit|not a complete fit JSON", line), line


@pytest.fixture
def half_failed(tmp_path):
    """A fit's JSON of two channels, of which one is good and one had no finite sample."""
    good = allanfit.fit(np.random.default_rng(1).standard_normal(512), 100.0)
    # As of data that JAX traces: that which is known is refused.
    unknown = jax.tree.map(
        lambda leaf: leaf & False if leaf.dtype == bool else leaf * np.nan, good.estimate
    )
    bad = eqx.tree_at(lambda fit: fit.estimate, good, unknown)
    fits = {"good": good, "bad": bad}
    channels = [fit.to_dict(name, "deg/s")["channels"][0] for name, fit in fits.items()]
    assert [channel["status"] == "converged" for channel in channels] == [True, False]
    path = tmp_path / "fit.json"
    path.write_text(
        json.dumps({"schema": "allanfit.fit/1", "recording": "a", "channels": channels})
    )
    return path


def test_a_fit_that_did_not_converge(half_failed, refused):
    for command in (
        ("simulate", str(half_failed), *SIMULATE),
        ("plan", str(half_failed), *PLAN),
        ("export", str(half_failed), "--format", "ros", "--output", "out.yaml"),
    ):
        assert "The fit of bad in fit.json did not converge" in refused(*command)
        assert "The fit of bad" in refused(*command, "--channel", "bad")


def test_a_fit_that_converged_beside_one_that_did_not(half_failed):
    (kept,) = read_coefficients(half_failed, ["good"])
    assert kept.channel == "good"
    (kept,) = read_fit(half_failed, ["good"]).channels
    assert kept.name == "good"


@pytest.mark.parametrize("kind", ["folder", "missing", "ring", "pipe", "device"])
def test_what_is_no_file(kind, tmp_path, refused):
    path = tmp_path / "c.yaml"
    if kind == "folder":
        path.mkdir()
    elif kind == "ring":
        path.symlink_to(path)
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    said = {
        refused("simulate", str(path), *SIMULATE),
        refused("plan", str(path), *PLAN),
        refused("export", str(path), "--format", "ros", "--output", "out.yaml"),
    }
    assert all("c.yaml" in line for line in said)
