"""The multi-position test: other solvers, coverage, rests of a recording, and bad positions."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import t

from allanfit.calibrate import multi_position
from allanfit.calibrate._norm_fit import fit_norm

GRAVITY = 9.81
BIAS, SCALE = np.array([0.1, -0.2, 0.3]), np.array([0.01, -0.02, 0.005])
YZ, ZY, ZX = ANGLES = np.array([0.01, 0.02, 0.015])
TO_BODY = np.array([[1, -YZ, ZY], [0, 1, -ZX], [0, 0, 1]]) @ np.diag(1 / (1 + SCALE))
RESPONSE = np.linalg.inv(TO_BODY)


def directions(rng, count):
    drawn = rng.standard_normal((count, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def readings(direction, rng, sigma):
    return GRAVITY * direction @ RESPONSE.T + BIAS + sigma * rng.standard_normal(direction.shape)


def test_exact_readings_give_the_truth_and_the_correction():
    rng = np.random.default_rng(0)
    direction = directions(rng, 12)
    data = readings(direction, rng, 0.0)
    found = multi_position(data, gravity=GRAVITY)
    for i, axis in enumerate("xyz"):
        assert found[axis].bias.value == pytest.approx(BIAS[i], abs=1e-7)
        assert found[axis].scale_factor.value == pytest.approx(SCALE[i], abs=1e-8)
    angles = [found.misalignment[name].value for name in ("alpha_yz", "alpha_zy", "alpha_zx")]
    np.testing.assert_allclose(angles, ANGLES, atol=1e-8)
    np.testing.assert_allclose(found.correction(data), GRAVITY * direction, atol=1e-6)


def test_what_rounding_leaves_of_exact_readings_is_no_outlier():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        direction = directions(rng, 14)
        for digits in (4, 15):
            data = readings(direction, rng, 0.0).round(digits)
            for reference in (None, direction):
                found = multi_position(data, gravity=GRAVITY, reference=reference)
                assert not any("stands out" in each for each in found.findings)


@pytest.mark.parametrize("like", [np.ndarray.tolist, jnp.asarray])
def test_means_may_be_in_any_array_or_list(like):
    rng = np.random.default_rng(0)
    data = readings(directions(rng, 12), rng, 0.0)
    found = multi_position(like(data), gravity=GRAVITY)
    assert found["x"].bias.value == pytest.approx(BIAS[0], abs=1e-5)


@pytest.mark.parametrize("header", ["ax,ay,az", "ax [g],ay [g],az [g]"])
def test_raw_codes_have_a_scale_factor(tmp_path, header):
    """As those of recordings; and a unit that is not the file's is said, as for these."""
    rng = np.random.default_rng(0)
    data = readings(directions(rng, 12), rng, 1e-4)
    path = tmp_path / "codes.csv"
    np.savetxt(path, data / 9.80665 * 16384, fmt="%.4f", delimiter=",", header=header, comments="")
    found = multi_position(path, gravity=GRAVITY, unit="1/16384 g")
    said = [each for each in found.findings if "was used instead" in each]
    told = "The file says g for ax, ay, az; --unit 6.104e-5 g was used instead."
    assert said == ([told] if "[g]" in header else [])
    plain = multi_position(data / 9.80665, gravity=GRAVITY, unit="g")
    for axis, other in zip(found.axes.values(), plain.axes.values(), strict=True):
        assert axis.bias.unit == "g"
        assert axis.bias.value == pytest.approx(other.bias.value, abs=1e-7)
        assert axis.scale_factor.value == pytest.approx(other.scale_factor.value, abs=1e-7)
    with pytest.raises(ValueError, match="The axes are in one unit; got 'g, deg/s'"):
        multi_position(path, unit="g, deg/s")


def test_another_solver_finds_the_same():
    rng = np.random.default_rng(1)
    data = readings(directions(rng, 20), rng, 3e-3)

    def lengths(p):
        triangle = np.array([[1, -p[6], p[7]], [0, 1, -p[8]], [0, 0, 1]])
        return np.linalg.norm((data - p[:3]) / (1 + p[3:6]) @ triangle.T, axis=1) - GRAVITY

    other = least_squares(lengths, np.zeros(9), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    variance = 2 * other.cost / 11 * np.linalg.inv(other.jac.T @ other.jac)
    half = t.ppf(0.975, 11) * np.sqrt(np.diag(variance))
    found = multi_position(data, gravity=GRAVITY)
    quantities = [found[axis].bias for axis in "xyz"]
    quantities += [found[axis].scale_factor for axis in "xyz"] + list(found.misalignment.values())
    for quantity, value, error in zip(quantities, other.x, half, strict=True):
        low, high = quantity.intervals["0.95"]
        assert quantity.value == pytest.approx(value, abs=1e-3 * error)
        # SciPy's Jacobian is one of finite differences.
        assert (high - low) / 2 == pytest.approx(error, rel=1e-4)


def test_intervals_hold_the_truth():
    # 2000 sensors at once: 1900 of 2000 expected, standard deviation 9.7; beyond four of them
    # once in 16000, for each of nine parameters.
    rng = np.random.default_rng(2)
    trials, count = 2000, 14
    direction = directions(rng, count)
    data = np.stack([readings(direction, rng, 3e-3) for _ in range(trials)]) / GRAVITY
    fits = jax.jit(jax.vmap(lambda each: fit_norm(each, jnp.zeros(9))))(jnp.asarray(data))
    assert bool(fits.converged.all())
    scatter = np.sqrt(np.sum(np.asarray(fits.residual) ** 2, axis=1) / (count - 9))
    errors = np.sqrt(np.diagonal(np.asarray(fits.inverse), axis1=1, axis2=2)) * scatter[:, None]
    truth = np.concatenate([BIAS / GRAVITY, SCALE, ANGLES])
    held = np.sum(np.abs(fits.value - truth) < t.ppf(0.975, count - 9) * errors, axis=0)
    assert np.all(np.abs(held - 1900) < 39), held


def test_known_attitudes_are_linear_least_squares():
    rng = np.random.default_rng(3)
    direction = directions(rng, 10)
    data = readings(direction, rng, 3e-3)
    # Of any length, here 2.
    found = multi_position(data, gravity=GRAVITY, reference=2 * direction)
    columns = np.column_stack([np.ones(10), GRAVITY * direction])
    solution, squares, *_ = np.linalg.lstsq(columns, data, rcond=None)
    inverse = np.linalg.inv(columns.T @ columns)
    for i, axis in enumerate("xyz"):
        assert found[axis].bias.value == pytest.approx(solution[0, i], rel=1e-9)
        assert found[axis].scale_factor.value == pytest.approx(solution[1 + i, i] - 1, rel=1e-9)
        low, high = found[axis].bias.intervals["0.95"]
        half = t.ppf(0.975, 6) * np.sqrt(squares[i] / 6 * inverse[0, 0])
        assert (high - low) / 2 == pytest.approx(half, rel=1e-9)
    expected = solution[2, 0] / solution[1, 0]
    assert found.misalignment["m_xy"].value == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(found.correction(data), GRAVITY * direction, atol=0.02)


def test_six_positions_along_the_axes_tell_bias_and_scale_factor():
    # Each axis up and down: the up-down test's formulas, and no scatter to make intervals of.
    data = GRAVITY * np.concatenate([np.eye(3), -np.eye(3)]) * (1 + SCALE) + BIAS
    found = multi_position(data, gravity=GRAVITY)
    for i, axis in enumerate("xyz"):
        # Two readings of one axis, of which another's bias takes a second-order part.
        assert found[axis].bias.value == pytest.approx(BIAS[i], abs=2e-4)
        assert found[axis].bias.intervals["0.95"] is None
    assert not found.misalignment
    assert any("misalignment is taken as zero" in each for each in found.findings)
    stated = multi_position(data, gravity=GRAVITY, sigma=1e-3)["x"].bias
    low, high = stated.intervals["0.95"]
    # The mean of two readings.
    assert (high - low) / 2 == pytest.approx(1.96e-3 / np.sqrt(2), rel=0.01)


def test_a_stated_deviation_that_is_too_small_is_noticed():
    rng = np.random.default_rng(4)
    data = readings(directions(rng, 20), rng, 3e-3)
    for sigma, noticed in ((1e-3, True), (3e-3, False)):
        findings = multi_position(data, gravity=GRAVITY, sigma=sigma).findings
        assert any("scatter more than" in each for each in findings) is noticed


@pytest.mark.parametrize("known", [False, True])
def test_a_position_that_stands_out_is_named_and_the_scatter_told(known):
    """Of 200 tables without one, 2 show one by chance: more than 8 once in 4000."""
    rng = np.random.default_rng(6)
    found, alarms = directions(rng, 24), 0

    def calibrated(data):
        return multi_position(data, gravity=GRAVITY, reference=found if known else None)

    for _ in range(200):
        quiet = calibrated(readings(found, rng, 1e-3))
        alarms += any("stands out" in each for each in quiet.findings)
    assert alarms <= 8
    data = readings(found, rng, 1e-3)
    # The scatter has 15 or 60 degrees of freedom: the tolerance is four standard deviations.
    told = float(re.search(r"residuals scatter by (\S+) m/s\^2", quiet.description)[1])
    assert told == pytest.approx(1e-3, rel=0.8)
    data[16, 1] += 0.05
    (finding,) = [each for each in calibrated(data).findings if "stands out" in each]
    assert finding.startswith("Position 17 stands out from the others")
    assert ("on y" in finding) is known


@pytest.fixture
def moved(tmp_path):
    """A recording of a triad that is turned by hand from each of twelve positions to the next."""
    rng = np.random.default_rng(5)
    direction = directions(rng, 12)
    parts, before = [], direction[0]
    for after in direction:
        turn = before + np.linspace(0, 1, 80)[:, None] * (after - before)
        turn /= np.linalg.norm(turn, axis=1, keepdims=True)
        parts += [turn + 0.05 * rng.standard_normal(turn.shape), np.tile(after, (350, 1))]
        before = after
    samples = readings(np.concatenate(parts), rng, 0.02)
    path = tmp_path / "moved.npz"
    np.savez(path, ax=samples[:, 0], ay=samples[:, 1], az=samples[:, 2], rate_hz=50.0)
    return path


def test_a_recording_is_cut_into_its_rests(moved):
    found = multi_position(moved, gravity=GRAVITY)
    assert found.conditions["positions"] == 12
    assert list(found.axes) == ["ax", "ay", "az"]
    for name, truth in zip(found.axes, BIAS, strict=True):
        # Means of four seconds or more: 0.02/sqrt(200), times about 1.5.
        assert found[name].bias.value == pytest.approx(truth, abs=0.02)


def test_angles_are_of_x_y_and_z_in_whatever_order_the_columns_stand(moved, tmp_path):
    plain = multi_position(moved, gravity=GRAVITY)
    with np.load(moved) as file:
        turned = {name: file[name] for name in ("az", "ax", "ay", "rate_hz")}
        other = {"up": file["ax"], "left": file["ay"], "front": file["az"]}
    np.savez(tmp_path / "turned.npz", **turned)
    found = multi_position(tmp_path / "turned.npz", gravity=GRAVITY)
    assert found.misalignment == plain.misalignment
    assert found.correction.to_dict() == plain.correction.to_dict()
    assert found.correction.to_dict()["axes"] == list(found.axes) == ["ax", "ay", "az"]
    # Names that tell no axis are taken as they stand, and that is said.
    np.savez(tmp_path / "other.npz", rate_hz=50.0, **other)
    found = multi_position(tmp_path / "other.npz", gravity=GRAVITY, unit="m/s^2")
    assert any("up, left, front are taken as x, y, z, in this" in each for each in found.findings)
    assert found.misalignment == plain.misalignment


@pytest.mark.parametrize(
    ("make", "options", "message"),
    [
        (lambda data: data[:5], {}, "has 5 positions; at least 6"),
        (lambda data: data[:8], {}, "are 9 parameters"),
        (lambda data: data[:1] + 1e-6 * np.eye(12, 3), {}, "do not tell|twice"),
        (lambda data: data * [1, 1, 0] + [0, 0, 0.1], {"orthogonal": True}, "scale factor of z"),
        (lambda data: data / GRAVITY, {}, "give --unit g"),
        (lambda data: data, {"unit": "deg/s"}, "not one of an acceleration"),
        (lambda data: data, {"sigma": 0.0}, "positive standard deviation"),
        (lambda data: np.where(data > 9, np.nan, data), {}, "finite numbers"),
        (lambda data: data[[*range(12), 0]], {}, "1 position twice"),
        (lambda data: data[:, :2], {}, r"shape \(positions, 3\)"),
        (lambda data: data, {"reference": np.ones((3, 3))}, r"shape \(12, 3\)"),
        (lambda data: data, {"reference": np.diag([1, 2, 3.0]).repeat(4, 0)}, "equally long"),
        (lambda data: data, {"reference": "reversed"}, "do not follow the reference"),
    ],
)
def test_bad_positions(make, options, message):
    rng = np.random.default_rng(6)
    direction = directions(rng, 12)
    direction[0] = [0, 0, 1.0]
    options = dict(options)
    if isinstance(options.get("reference"), str):
        options["reference"] = -direction
    data = make(readings(direction, rng, 1e-3))
    with pytest.raises(ValueError, match=message):
        multi_position(data, gravity=GRAVITY, **options)


def test_what_is_neither_a_file_nor_numbers_is_refused():
    with pytest.raises(ValueError, match="must hold real numbers; got <U1"):
        multi_position([["a", "b", "c"]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ax,ay\n1,2\n3,4\n", "no column for z"),
        ("ax,ay,az\n1,2,3\n1,x,3\n", "'x' is not a number"),
        ("ax,ay,az\n1,2,3\n1,,3\n", "column ay has no number in row 2"),
        ("ax [g],ay [m/s^2],az [g]\n1,2,3\n1,2,3\n", "different units"),
        ("ax,ay,az,ref_x\n1,2,3,1\n1,2,3,1\n", "no column ref_y"),
        ("ax,acc_x,ay,az\n1,2,3,4\n1,2,3,4\n", "two columns for x"),
        ("ax,ay,az\n" + "1,2,3\n" * 1001, "give its rate with --rate"),
    ],
)
def test_bad_files(tmp_path, text, message):
    path = tmp_path / "means.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        multi_position(path)
