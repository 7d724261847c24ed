"""Whether devices are one, and which does not belong."""

import numpy as np
import pytest
from scipy.stats import binom, chi2

from allanfit.fleet import FleetRun, compare, format_summary, write_summary
from allanfit.fleet._outliers import outliers
from allanfit.fleet._spread import spread
from allanfit.physics import SYMBOLS

ERROR = 0.02


def row(device, n, **changes):
    """A channel as its fit tells it: N with a standard error of 2 %, the others' limits."""
    entry = {
        "recording": f"{device}.npz",
        "path": f"/fleet/{device}.npz",
        "channel": "gyro_x",
        "quantity": "gyro_x",
        "device": device,
        "unit": "deg/s",
        "si_unit": "rad/s",
        "si_factor": np.pi / 180,
        "status": "converged",
        "error": None,
        "p_value": 0.5,
        "nyquist_score": -0.5,
        "findings": ["It has 12 gaps."],
    }
    for symbol in SYMBOLS:
        entry |= {symbol: 0.5e-3, f"{symbol}_resolved": False, f"{symbol}_unit": "u"}
        limits = (f"{symbol}_upper_limit_95", f"{symbol}_low_95", f"{symbol}_high_95")
        entry |= dict(zip(limits, (1e-3, 0.0, 1.1e-3), strict=True))
    reach = np.exp(1.959964 * ERROR)
    entry |= {"N": n, "N_resolved": True, "N_upper_limit_95": None}
    entry |= {"N_low_95": n / reach, "N_high_95": n * reach, "N_unit": "deg/s/sqrt(Hz)"}
    return entry | changes


def fleet(size, tau, seed=0):
    """Devices whose N differs by tau, measured with an error of 2 %."""
    logs = np.hypot(tau, ERROR) * np.random.default_rng(seed).standard_normal(size)
    return [row(f"unit_{k + 1}", 5e-3 * np.exp(each)) for k, each in enumerate(logs)]


def run_of(rows):
    return FleetRun((), tuple(rows), len(rows), 0, (), 0)


def test_spread_with_equal_errors_is_that_of_the_textbook():
    values = np.array([1.0, 1.3, 0.8, 1.9, 1.1])
    errors = np.full(5, 0.1)
    found = spread(values, errors)
    variance = np.var(values, ddof=1)
    assert found.middle == pytest.approx(values.mean())
    assert found.tau**2 == pytest.approx(variance - 0.01, rel=1e-6)
    assert found.p_value == pytest.approx(chi2.sf(4 * variance / 0.01, 4))
    assert found.share == pytest.approx(1 - 0.01 / variance, rel=1e-6)
    ends = [4 * variance / chi2.ppf(q, 4) - 0.01 for q in (0.975, 0.025)]
    assert np.square(found.tau_interval) == pytest.approx(ends, rel=1e-6)
    reach = 2.776445 * np.sqrt(variance / 5)
    assert found.middle_interval == pytest.approx((values.mean() - reach, values.mean() + reach))


def test_devices_that_agree_have_no_spread():
    found = spread(np.array([1.0, 1.01, 0.99, 1.0]), np.full(4, 0.1))
    assert (found.tau, found.tau_interval[0], found.share) == (0.0, 0.0, 0.0)
    assert found.p_value > 0.9


def test_spread_recovers_unequal_errors():
    """Truth within the interval in 95 % of 100 fleets, give or take 4.4 standard deviations."""
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(100):
        errors = rng.uniform(0.02, 0.2, 12)
        found = spread(0.1 * rng.standard_normal(12) + errors * rng.standard_normal(12), errors)
        inside += found.tau_interval[0] <= 0.1 <= found.tau_interval[1]
    assert binom.cdf(inside, 100, 0.95) > 1e-5
    assert binom.sf(inside, 100, 0.95) > 1e-5


@pytest.mark.parametrize("tau", [0.0, 0.05])
def test_false_alarms_are_as_rare_as_said(tau):
    """At most 10 % of fleets; a rule at 10 % fails this in one of 10,000."""
    rng = np.random.default_rng(2)
    errors = np.full(10, 0.02)
    named = sum(
        bool(outliers(np.hypot(tau, 0.02) * rng.standard_normal(10), errors, alpha=0.1))
        for _ in range(100)
    )
    assert binom.sf(named, 100, 0.1) > 1e-4


def test_two_odd_devices_do_not_hide_one_another():
    values = 0.05 * np.random.default_rng(3).standard_normal(12)
    values[[4, 9]] = 1.0, 1.05
    found = outliers(values, np.full(12, 0.02), alpha=0.01)
    assert sorted(each.index for each in found) == [4, 9]
    others = np.delete(values, [4, 9]).mean()
    assert {each.index: each.distance for each in found}[4] == pytest.approx(1 - others, abs=0.03)
    assert outliers(-values, np.full(12, 0.02), alpha=0.01, above=True) == []


def test_a_healthy_fleet_has_no_outlier_and_its_spread_is_told():
    rows = fleet(20, tau=0.06)
    found = compare(rows)
    assert found.outliers == ()
    (quantity,) = found.quantities
    (n,) = (each for each in quantity.coefficients if each.symbol == "N")
    assert n.spread.tau_interval[0] < 0.06 < n.spread.tau_interval[1]
    text = format_summary(run_of(rows), found)
    assert "devices differ by" in text
    assert "No device stands out" in text


def test_the_odd_device_is_named_with_factor_and_findings():
    rows = fleet(20, tau=0.03)
    rows[7] = row("unit_8", 9e-3, findings=["It has 99 gaps.", "It is wet."])
    found = compare(rows)
    (outlier,) = found.outliers
    assert (outlier.device, outlier.quantity, outlier.subject) == ("unit_8", "gyro_x", "N")
    assert outlier.number == pytest.approx(1.8, rel=0.04)
    assert outlier.findings == (("It has 99 gaps.", 19), ("It is wet.", 0))
    text = format_summary(run_of(rows), found)
    assert "unit_8, gyro_x: N is 1." in text
    assert "(So on 19 of the 19 others.)" in text


def test_a_unit_of_its_own_is_no_oddity():
    rows = fleet(10, tau=0.03)
    radian = np.pi / 180
    scaled = {name: rows[3][name] * radian for name in ("N", "N_low_95", "N_high_95")}
    rows[3] |= {**scaled, "unit": "rad/s", "si_factor": 1.0, "N_unit": "rad/s/sqrt(Hz)"}
    limits = {f"{s}_upper_limit_95": 1e-3 * radian for s in "QBKR"}
    rows[3] |= limits
    found = compare(rows)
    assert found.outliers == ()
    assert [each.unit for each in found.quantities] == ["deg/s"]


def test_a_term_that_one_device_alone_shows_stands_out():
    rows = fleet(12, tau=0.03)
    for k, each in enumerate(rows):
        each["B_upper_limit_95"] = 1e-3 * 1.1 ** (k % 3)
    rows[2] |= {"B": 0.1, "B_resolved": True, "B_low_95": 0.09, "B_high_95": 0.11}
    (outlier,) = compare(rows).outliers
    assert (outlier.device, outlier.subject, outlier.bound) == ("unit_3", "B", "limits")


def test_misfit_and_falling_spectrum_stand_out():
    rows = fleet(12, tau=0.03)
    rows[4]["p_value"] = 1e-9
    rows[5]["nyquist_score"] = -30.0
    assert [(each.device, each.subject) for each in compare(rows).outliers] == [
        ("unit_5", "fit"),
        ("unit_6", "spectrum"),
    ]


def test_a_fleet_that_misfits_as_a_whole_has_no_odd_one():
    rows = fleet(12, tau=0.03)
    for each in rows:
        each["p_value"] = 1e-6
    assert compare(rows).outliers == ()


def test_few_devices_have_no_outlier():
    rows = [row("a", 5e-3), row("b", 5e-3), row("c", 5.0)]
    found = compare(rows)
    assert found.outliers == ()
    assert "among 5 devices or more" in format_summary(run_of(rows), found)


def test_the_page_stands_alone_and_escapes_what_users_wrote(tmp_path):
    rows = fleet(12, tau=0.03)
    evil = "<script>x</script>"
    rows[3] = row(evil, 0.1, findings=[evil, "$\\frac$"], quantity="gyro_x")
    failed = dict.fromkeys(rows[0]) | {"path": "/f/" + evil, "status": "failed", "error": evil}
    rows.append(failed)
    page = tmp_path / "summary.html"
    found = compare(rows)
    write_summary(run_of(rows), found, page)
    text = page.read_text()
    assert "<script" not in text
    assert "&lt;script&gt;" in text
    assert "src=" not in text
    assert text.count("<svg") == 1
    assert "Devices that stand out: 1 channel" in text
    assert [path.name for path in tmp_path.iterdir()] == ["summary.html"]


def test_a_copy_is_named_and_counts_once(tmp_path):
    """Two copies change no number, and are told in the terminal and on the page."""
    rows = [each | {"file_sha256": str(k)} for k, each in enumerate(fleet(12, 0.1, seed=4))]
    again = [
        rows[0] | {"device": "unit_1_copy", "path": "/fleet/unit_1_copy.npz"},
        rows[11] | {"path": "/backup/unit_12.npz"},
    ]
    alone, found = compare(rows), compare([*again, *rows])
    assert found.quantities == alone.quantities
    assert found.outliers == alone.outliers
    assert alone.copies == ()
    said = (
        "2 recordings are copies, byte for byte, and are left out of the comparison: "
        "unit_1_copy.npz of unit_1.npz, /fleet/unit_12.npz of /backup/unit_12.npz."
    )
    run = run_of([*again, *rows])
    assert said in " ".join(format_summary(run, found).split())
    write_summary(run, found, tmp_path / "summary.html")
    assert said in " ".join((tmp_path / "summary.html").read_text().split())
    assert "byte for byte" not in format_summary(run, alone)


def test_recordings_without_a_checksum_are_no_copies():
    rows = [each | {"file_sha256": None} for each in fleet(6, 0.1)]
    assert compare(rows).copies == ()
    assert len(compare(rows).quantities[0].devices) == 6
