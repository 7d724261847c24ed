"""Bad coefficients on the command line, in every command that reads them."""

import os
import re

import pytest
from bad_coefficients import BAD

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
