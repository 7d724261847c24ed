"""What a simulation takes of a fit: no term that may not be there."""

import numpy as np
import pytest

import allanfit
from allanfit.cli import main
from allanfit.coefficients import read_coefficients
from allanfit.explain.simulation._references import references
from allanfit.plan import plan_file

LENGTH = ["--duration", "20000", "--rate", "10", "--seed", "3"]
# A walk that nobody saw, and that in 1000 s would go 40 times as far as the mean of the noise.
UNSEEN = {"K": 4e-4, "Q": 1e-5}


@pytest.fixture(params=["fit", "explain", "yaml"])
def written(request, write_fit, write_explained, make_channel, tmp_path):
    channels = [
        make_channel("gx", unresolved="QBKR", **UNSEEN),
        make_channel("gy", unresolved="", **UNSEEN),
    ]
    if request.param == "explain":
        # Of no matter: what counts are the coefficients beside it.
        return write_explained(*channels, effects={"saturation": {"limit": (50.0, "deg/s")}})
    path = write_fit(*channels)
    if request.param == "fit":
        return path
    target = tmp_path / "fit.yaml"
    assert main(["export", str(path), "--format", "yaml", "--output", str(target)]) == 0
    return target


def test_what_is_not_resolved_is_not_drawn_and_that_is_said(written, tmp_path, capsys):
    output = tmp_path / "sim.npz"
    capsys.readouterr()
    assert main(["simulate", str(written), *LENGTH, "--output", str(output)]) == 0
    told, *rest = capsys.readouterr().err.splitlines()
    assert told == (
        "allanfit: Not resolved, and so not in the simulation (95 % upper limits): "
        "gx Q < 2.0e-5 deg, B < 0.0040 deg/s, K < 8.0e-4 deg/s/sqrt(s), R < 2.0e-7 deg/s^2."
    )
    assert [line.split(":")[0] for line in rest] == ["Recording"]
    drawn = np.load(output)
    means = {name: drawn[name].reshape(-1, 1000).mean(axis=1) for name in ("gx", "gy")}
    # Means over 100 s of white noise alone; the standard deviation of 200 is known to 5 %.
    assert means["gx"].std() == pytest.approx(5e-3 / 10, rel=0.2)
    # What is resolved is drawn as ever.
    assert means["gy"].std() > 10 * means["gx"].std()


def test_a_plan_is_without_it_whatever_the_file(written):
    plan = plan_file(written, 10.0, {"N": 0.01}).channels["gx"]
    assert plan.coefficients == {"N": 5e-3}


def test_what_a_recording_is_compared_with_is_the_fit_as_its_figure_draws_it(
    write_fit, make_channel, tmp_path
):
    path, still = write_fit(make_channel("gx", unresolved="QKR", **UNSEEN)), tmp_path / "still.npz"
    noise = allanfit.simulate({"N": 5e-3}, duration_s=60.0, rate_hz=100.0, seed=1)
    np.savez(still, gx=np.asarray(noise), rate_hz=100.0, units='{"gx": "deg/s"}')
    found = references(path, allanfit.load(still), "point")["gx"].coefficients
    degree = np.pi / 180
    assert found / degree == pytest.approx([1e-5, 5e-3, 2e-3, 4e-4, 0.0])


def test_limits_follow_the_unit(write_fit, make_channel):
    (entry,) = read_coefficients(write_fit(make_channel("gx", unresolved="K", **UNSEEN)))
    found = entry.times(2.0, "deg/s").unresolved["K"]
    assert found == pytest.approx((8e-4, 1.6e-3))
