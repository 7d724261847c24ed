"""The paper's curves are what its equations say, and err as the page says."""

import math
from itertools import pairwise

import numpy as np
import pytest


@pytest.fixture
def curves(example):
    return example("paper_curves")


def test_cluster_allan_deviation_is_the_paper_s_equation(curves):
    """Written out cluster by cluster, with a last one that is not full."""
    samples = np.random.default_rng(0).normal(size=30_007).cumsum()
    wanted = []
    for n in (10, 50, 100, 500, 1000, 5000, 10_000):
        means = [samples[start : start + n].mean() for start in range(0, len(samples), n)]
        assert len(means) == math.ceil(len(samples) / n)
        total = sum((later - earlier) ** 2 for earlier, later in pairwise(means))
        wanted.append(math.sqrt(total / (2 * (len(means) - 1))))
    np.testing.assert_allclose(curves.paper_deviation(samples), wanted, rtol=1e-9)


def test_spectrum_is_the_squared_transform_over_the_length(curves):
    samples = np.random.default_rng(1).normal(size=3000)
    transform = 0.02 * np.fft.rfft(samples - samples.mean())[1:]
    wanted = 2 * np.abs(transform) ** 2 / (3000 * 0.02)
    wanted[-1] /= 2  # the Nyquist frequency is its own twin
    np.testing.assert_allclose(curves.paper_spectrum(samples, None).density, wanted, rtol=1e-9)
    averaged = curves.paper_spectrum(samples)
    assert np.sum(averaged.density * averaged.ordinates) / 60 == pytest.approx(samples.var())


def test_plain_periodogram_doubles_a_random_walk_and_the_mirror_does_not(curves):
    (clusters, overlapping), (plain, mirror) = curves.errors({"K": 1e-4}, records=40, seed=3)
    # 40 records of some ten ordinates in the lowest band: a standard error of 0.07 at most.
    assert plain[0] == pytest.approx(2, abs=0.3)
    assert mirror[0] == pytest.approx(1, abs=0.2)
    # Two differences, of which one is independent: an error of half the deviation or so.
    assert 0.3 < clusters[-1] < 0.8
    assert 0.3 < overlapping[-1] < 0.8


def test_script_prints_its_table_and_draws_its_figures(curves, tmp_path, monkeypatch, capsys):
    axes = curves.printed_coefficients()
    assert len(axes) == 6
    roll = {"roll gyro": axes["roll gyro"]}
    monkeypatch.setattr(curves, "printed_coefficients", lambda: roll)
    curves.main(["--output", str(tmp_path / "new"), "--records", "4"])
    printed = capsys.readouterr().out
    # Clusters of 1000 samples, 20 s, make 29 differences of 30000.
    assert [line.split()[:2] for line in printed.splitlines() if " 20 " in line] == [["20", "29"]]
    for name in ("paper-allan-deviation.png", "paper-psd.png"):
        assert (tmp_path / "new" / name).read_bytes().startswith(b"\x89PNG")
