"""The filter's covariance against closed forms, and its consistency with the right numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from allanfit.physics import STANDARD_TERMS, coefficient_unit


@pytest.fixture
def consistency(example):
    return example("filter_consistency")


@pytest.fixture
def document(consistency):
    """A fit's JSON with nothing in it, to be filled with numbers."""
    coefficients = {
        term.symbol: {
            "name": term.names.gyro,
            "unit": coefficient_unit(term, "deg/s"),
            "value": 0.0,
            "resolved": False,
            "upper_limit_95": 0.0,
            "intervals": {"0.95": [0.0, 0.0]},
        }
        for term in STANDARD_TERMS
    }
    channel = {
        "channel": "gyro",
        "unit": "deg/s",
        "rate_hz": consistency.RATE_HZ,
        "samples": round(consistency.STILL_S * consistency.RATE_HZ),
        "coefficients": coefficients,
    }
    return {"schema": "allanfit.fit/1", "recording": "still", "channels": [channel]}


def test_without_fixes_the_angle_wanders_as_the_integral_of_its_noise(consistency, document):
    """Variance fix^2 + (bias t)^2 + N^2 t + K^2 t^3/3."""
    numbers = {"N": 0.01, "K": 1e-3}
    matrices = consistency.kalman_matrices(document, numbers)
    design = consistency.design(matrices, 60, np.zeros(60, bool))
    t = consistency.BLOCK_S * np.arange(1, 61)
    fix, bias = consistency.FIX_SIGMA, consistency.TURN_ON_SIGMA
    wanted = fix**2 + (bias * t) ** 2 + 0.01**2 * t
    np.testing.assert_allclose(design.sigma**2 - wanted, 1e-6 * t**3 / 3, rtol=0.05)


def test_fixes_of_a_sensor_without_drift_give_the_line_through_them(consistency, document):
    """A constant bias and exact integration: the variance is that of a straight-line fit."""
    matrices = consistency.kalman_matrices(document, {"N": 1e-9})
    fixes = np.ones(40, bool)
    design = consistency.design(matrices, 40, fixes)
    # Before fix k the filter extrapolates from k fixes, that at the start included, with the
    # prior of the bias far too wide to matter.
    for k in (5, 40):
        times = np.arange(k)
        lever = 1 / k + (k - times.mean()) ** 2 / np.sum((times - times.mean()) ** 2)
        assert design.sigma[k - 1] == pytest.approx(consistency.FIX_SIGMA * lever**0.5, rel=1e-3)


def test_only_the_right_numbers_are_consistent(consistency, document):
    count = 150
    end, fixes = consistency.fix_schedule()
    rate_error, fix_error = consistency.drives(count, seed=11)
    last = np.searchsorted(end, [stop for _, stop in consistency.OUTAGES_S])

    def mean_nees(numbers):
        matrices = consistency.kalman_matrices(document, numbers)
        design = consistency.design(matrices, len(end), fixes)
        errors = consistency.angle_errors(design, rate_error, fix_error, fixes)
        return consistency.nees(design.sigma, errors)[last].mean()

    # Four outages of 150 drives: a standard error of 0.06, and 0.1 for the realised flicker.
    assert mean_nees(consistency.TRUTH) == pytest.approx(1, abs=0.25)
    assert mean_nees(consistency.sheet()) > 2
    assert mean_nees({**consistency.TRUTH, "K": 6.5e-4}) < 0.25


def test_fixes_come_once_a_minute_but_for_outages_of_five(consistency):
    end, fixes = consistency.fix_schedule()
    gaps = np.diff(end[fixes])
    assert set(gaps) == {60.0, 300.0}
    assert np.sum(gaps == 300) == 4


def test_limit_stands_for_a_random_walk_that_is_not_resolved(consistency):
    fit = SimpleNamespace(
        coefficients={"N": 5e-3, "B": 2e-3, "K": 1e-5},
        resolved={"N": True, "B": True, "K": False},
        upper_limits={"K": 9e-5},
    )
    assert consistency.fitted(fit) == {"N": 5e-3, "B": 2e-3, "K": 9e-5}
    fit.resolved["K"] = True
    assert consistency.fitted(fit)["K"] == 1e-5


def test_band_holds_nineteen_means_of_twenty(consistency):
    draws = np.random.default_rng(2).normal(size=(4000, 50))
    low, high = consistency.band(50)
    mean = np.mean(draws**2, axis=1)
    assert np.mean((low <= mean) & (mean <= high)) == pytest.approx(0.95, abs=0.015)


def test_script_prints_its_table_and_draws_its_figure(consistency, tmp_path, monkeypatch, capsys):
    """On a short still record and few drives, since it is the whole path that is tested."""
    monkeypatch.setattr(consistency, "STILL_S", 600.0)
    consistency.main(["--output", str(tmp_path), "--stills", "1", "--drives", "8"])
    rows = capsys.readouterr().out.splitlines()
    assert [row[:18].strip() for row in rows[2:-1]] == list(consistency.COLOURS)
    assert (tmp_path / "filter-consistency.png").read_bytes().startswith(b"\x89PNG")
