"""The multi-position test of an accelerometer triad: bias, scale factor and misalignment."""

from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float64
from scipy.stats import chi2

from ..formatting import p_value, significant
from ._gravity import checked_gravity, refuse_wrong_unit
from ._intervals import Intervals, normal_intervals, student_intervals
from ._known_attitude import attitude_columns, fit_attitudes
from ._norm_fit import ORTHOGONAL, PARAMETERS, NormFit, correction_matrix, fit_norm, jacobian
from ._outlier import rounding, stands_out, studentized
from ._positions import PositionData, Positions, read_positions
from ._result import AxisCalibration, Calibration, Correction, Quantity, Residuals

_FEWEST = 6
# Largest over smallest singular value of the Jacobian: 5 for well-spread positions.
_WORST_CONDITION = 300.0
_POOR_CONDITION = 30.0
# Positions are along the axes if no product of two components is larger than this (12 degrees).
_ALONG_AXES = 0.2
_LARGEST_SCALE_ERROR = 0.3
_INCONSISTENT = 0.01
# Parts of gravity.
_SOLVED = 1e-9
_NORM_CONVENTION = (
    "a = T K (y - b), K = diag(1/(1 + S)), T = [[1, -alpha_yz, alpha_zy], [0, 1, -alpha_zx], "
    "[0, 0, 1]] (Tedaldi et al. 2014): x is the sensor's own axis, y lies in the plane of its x "
    "and y axes"
)
_ATTITUDE_CONVENTION = (
    "y = b + C a with C_ii = 1 + S_i; m_ij = C_ij/C_ii is the angle by which axis i of the sensor "
    "leans toward axis j of the body"
)
_SCATTER = (
    "Student's t intervals from the Jacobian and the scatter of the residuals, {freedom} degrees "
    "of freedom{each}."
)
_STATED = "Normal intervals from the Jacobian and the stated standard deviation of a reading."
_NONE = (
    "No intervals: as many parameters as equations leave no scatter; add positions, or state the "
    "standard deviation of a reading with --sigma."
)

_fit_norm = jax.jit(fit_norm)
_fit_attitudes = jax.jit(fit_attitudes)
_jacobian = jax.jit(jacobian)


def multi_position(
    positions: PositionData,
    *,
    gravity: float | None = None,
    unit: str | None = None,
    sigma: float | None = None,
    reference: np.ndarray | None = None,
    orthogonal: bool = False,
    rate_hz: float | None = None,
    channels: Sequence[str] | None = None,
    topic: str | None = None,
) -> Calibration:
    """Bias, scale factor and misalignment of a triad at rest in six or more positions.

    Without known attitudes the corrected reading must be as long as gravity in each position,

        |T K (y - b)| = g,

    K = diag(1/(1 + S)), T upper triangular with three small angles (Tedaldi, Pretto and Menegatti
    2014, ICRA, eqs. 2 to 4 and 10): nine parameters by Levenberg-Marquardt. That needs nine
    positions, more for intervals, some of them between the axes. Positions that all lie along the
    axes, as in the classical six-position test, tell bias and scale factor alone; the angles,
    which hardly touch these there, are then zero and a finding says so.

    With known attitudes y = b + C a is linear least squares with the full matrix C.

    Covariances are s^2 (J'J)^-1 with s^2 from the residuals, or from `sigma`.

    **Arguments:**

    - `positions`: means of shape (positions, 3), or a CSV of means with the columns ax, ay, az
      and perhaps ref_x, ref_y, ref_z; or a recording, by its time stamps, its `rate_hz`, or as a
      `Recording`, which is cut into the stretches in which the sensor was at rest.
    - `gravity`: where the test was made [m/s^2]; the standard one if not given.
    - `unit`, `channels`, `topic`: as in `allanfit.load`; without any unit, m/s^2.
    - `sigma`: standard deviation of a mean, in the unit of the readings, if it is known; of raw
      codes in the unit behind the scale factor.
    - `reference`: the specific force along the axes of the body, of any length, shape
      (positions, 3).
    - `orthogonal`: take the axes as orthogonal, for bias and scale factor from six positions.

    **Raises:** `ValueError` for too few positions, positions that leave a parameter undetermined,
    readings that are not gravity, a fit that does not converge, and what is wrong with the file.
    """
    local, findings = checked_gravity(gravity)
    if sigma is not None and not 0 < sigma < np.inf:
        raise ValueError(f"sigma must be a positive standard deviation; got {sigma}.")
    found = read_positions(
        positions,
        unit=unit,
        rate_hz=rate_hz,
        channels=channels,
        topic=topic,
        reference=reference,
        gravity=local,
    )
    findings += found.findings
    count = len(found.readings)
    if count < _FEWEST:
        raise ValueError(
            f"{found.name} has {count} position{'s' * (count != 1)}; at least {_FEWEST} are "
            "needed, such as each axis up and down, and nine or more, some of them between the "
            "axes, for misalignment."
        )
    size = float(np.median(np.linalg.norm(found.readings, axis=1)))
    refuse_wrong_unit(found.name, found.unit.name, size, local)
    known = None if sigma is None else sigma * found.unit.factor / local
    with jax.enable_x64(True):
        if found.reference is None:
            return _by_norm(found, local, known, orthogonal, findings)
        return _by_attitude(found, found.reference, local, known, findings)


def _by_norm(
    found: Positions,
    gravity: float,
    sigma: float | None,
    orthogonal: bool,
    findings: tuple[str, ...],
) -> Calibration:
    readings = jnp.asarray(found.readings / gravity)
    size, about = (ORTHOGONAL, ()) if orthogonal else _parameters_told(found, gravity)
    condition = _condition(np.asarray(_jacobian(jnp.zeros(size), readings)))
    _refuse_degenerate(found.name, condition, PARAMETERS[:size])
    fit = _converged(_fit_norm(readings, jnp.zeros(size)), found.name)
    count = len(found.readings)
    freedom = count - size
    squares = float(jnp.sum(fit.residual**2))
    about += _about_fit(condition, squares, freedom, sigma)
    slopes = _jacobian(fit.value, readings)
    leverage = jnp.sum((slopes @ fit.inverse) * slopes, axis=1)
    rounded = _rounding(found, gravity)
    about += _about_outlier(
        np.asarray(studentized(fit.residual, leverage, freedom, rounded)), freedom
    )
    interval = _interval(squares, freedom, sigma)
    errors = np.sqrt(np.diag(np.asarray(fit.inverse)))
    values = np.asarray(fit.value)
    factor, unit = gravity / found.unit.factor, found.unit.name

    def quantity(index: int, kind: str) -> Quantity:
        value = float(values[index])
        return Quantity(value, kind, interval(value, float(errors[index])))

    return Calibration(
        procedure="multi-position",
        source=found.name,
        description=_description(count, gravity, "attitudes unknown")
        + _scatter(squares, freedom, factor, unit),
        intervals=_meaning(freedom, sigma),
        conditions=_conditions(gravity, count, False, size == ORTHOGONAL, condition[0]),
        axes={
            axis: AxisCalibration(quantity(i, "").scaled(factor, unit), quantity(3 + i, "1"))
            for i, axis in enumerate(found.axes)
        },
        findings=(*findings, *about),
        misalignment={
            name: quantity(i, "rad") for i, name in enumerate(PARAMETERS) if 6 <= i < size
        },
        misalignment_convention=_NORM_CONVENTION,
        correction=Correction(
            np.asarray(correction_matrix(fit.value)), values[:3] * factor, unit, found.axes
        ),
        residuals=_residuals(np.asarray(fit.residual) * factor, unit, ("length",) * count),
    )


def _by_attitude(
    found: Positions,
    reference: Float64[np.ndarray, "positions 3"],
    gravity: float,
    sigma: float | None,
    findings: tuple[str, ...],
) -> Calibration:
    condition = _condition(np.asarray(attitude_columns(jnp.asarray(reference))))
    _refuse_degenerate(found.name, condition, ("bias", "column x", "column y", "column z"))
    fit = jax.tree.map(
        np.asarray, _fit_attitudes(jnp.asarray(found.readings / gravity), jnp.asarray(reference))
    )
    count = len(found.readings)
    freedom = count - fit.inverse.shape[0]
    factor, unit = gravity / found.unit.factor, found.unit.name
    diagonal = np.diag(fit.matrix)
    if np.abs(diagonal - 1).max() > _LARGEST_SCALE_ERROR:
        raise ValueError(
            f"{found.name}: the readings do not follow the reference columns (axis "
            f"{found.axes[int(np.argmax(np.abs(diagonal - 1)))]}); check their signs and the order "
            "of rows."
        )
    squares = np.sum(fit.residual**2, axis=0)
    about = _about_fit(condition, float(squares.sum()), 3 * freedom, sigma)
    columns = attitude_columns(jnp.asarray(reference))
    leverage = jnp.sum((columns @ fit.inverse) * columns, axis=1)
    rounded = _rounding(found, gravity)
    each = [
        studentized(residual, leverage, freedom, rounded)
        for residual in jnp.asarray(fit.residual.T)
    ]
    about += _about_outlier(np.stack(each, axis=1), freedom, found.axes)
    axes, misalignment = {}, {}
    for i, axis in enumerate(found.axes):
        interval = _interval(float(squares[i]), freedom, sigma)
        error = np.sqrt(np.diag(fit.inverse))
        bias, scale = float(fit.bias[i]), float(diagonal[i] - 1)
        axes[axis] = AxisCalibration(
            Quantity(bias, "", interval(bias, float(error[0]))).scaled(factor, unit),
            Quantity(scale, "1", interval(scale, float(error[1 + i]))),
            residuals=_residuals(fit.residual[:, i] * factor, unit, (axis,) * count),
        )
        for j in range(3):
            if j != i:
                name = f"m_{'xyz'[i]}{'xyz'[j]}"
                angle = float(fit.matrix[i, j] / diagonal[i])
                # To first order, of the ratio C_ij/C_ii.
                gradient = np.zeros(4)
                gradient[[1 + j, 1 + i]] = np.array([1.0, -angle]) / diagonal[i]
                spread = float(np.sqrt(gradient @ fit.inverse @ gradient))
                misalignment[name] = Quantity(angle, "rad", interval(angle, spread))
    return Calibration(
        procedure="multi-position",
        source=found.name,
        description=_description(count, gravity, "attitudes known")
        + _scatter(float(squares.sum()), 3 * freedom, factor, unit),
        intervals=_meaning(freedom, sigma, " an axis"),
        conditions=_conditions(gravity, count, True, False, condition[0]),
        axes=axes,
        findings=(*findings, *about),
        misalignment=misalignment,
        misalignment_convention=_ATTITUDE_CONVENTION,
        correction=Correction(np.linalg.inv(fit.matrix), fit.bias * factor, unit, found.axes),
    )


def _rounding(found: Positions, gravity: float) -> float:
    """Least standard deviation of a reading, by its rounding, in parts of gravity."""
    rounded = rounding(found.readings / found.unit.factor) * found.unit.factor / gravity
    # The solver stops before rounding alone is left, and no sensor is known as well.
    return max(rounded, _SOLVED)


def _parameters_told(found: Positions, gravity: float) -> tuple[int, tuple[str, ...]]:
    """How many parameters the positions tell, and what to say of those that they do not."""
    readings = jnp.asarray(found.readings / gravity)
    direction = np.asarray(readings / jnp.linalg.norm(readings, axis=1, keepdims=True))
    between = np.abs(direction * np.roll(direction, 1, axis=1)).max()
    if between < _ALONG_AXES:
        return ORTHOGONAL, (
            "The positions all lie along the axes and say nothing about the angles between these: "
            "misalignment is taken as zero. To find it, add positions tilted by about 45 degrees.",
        )
    full = len(PARAMETERS)
    if len(readings) < full:
        raise ValueError(
            f"{found.name} has {len(readings)} positions, and bias, scale factor and misalignment "
            f"are {full} parameters; add positions, or take the axes as orthogonal with "
            "--orthogonal."
        )
    return full, ()


def _condition(columns: Float64[np.ndarray, "rows parameters"]) -> tuple[float, int]:
    """Condition number, and the parameter that is told worst."""
    _, values, directions = np.linalg.svd(columns, full_matrices=False)
    worst = int(np.argmax(np.abs(directions[-1])))
    if len(columns) < columns.shape[1]:
        return np.inf, worst
    return float(values[0] / max(values[-1], np.finfo(float).eps * values[0])), worst


def _refuse_degenerate(name: str, condition: tuple[float, int], parameters: Sequence[str]) -> None:
    number, worst = condition
    if number > _WORST_CONDITION:
        shown = "infinite" if number > 1e9 else f"{number:.3g}"
        raise ValueError(
            f"{name}: the positions do not tell {parameters[worst]} (condition number of the "
            f"Jacobian {shown}, where {_WORST_CONDITION:g} is the most); turn the sensor so that "
            "each axis points up, down and between."
        )


def _converged(fit: NormFit, name: str) -> NormFit:
    values = np.asarray(fit.value)
    if not (bool(fit.converged) and np.isfinite(values).all()):
        raise ValueError(
            f"{name}: no bias, scale factor and misalignment make the readings as long as gravity; "
            "check that the sensor was at rest in each position, and the unit."
        )
    if np.abs(values[:ORTHOGONAL]).max() > _LARGEST_SCALE_ERROR:
        worst = int(np.argmax(np.abs(values[:ORTHOGONAL])))
        size = f"{100 * values[worst]:.3g} %{' of gravity' if worst < 3 else ''}"
        raise ValueError(
            f"{name}: the {PARAMETERS[worst]} comes out as {size}, which no working sensor has; "
            "check the unit, the positions, and that it was at rest."
        )
    return fit


def _interval(
    squares: float, freedom: int, sigma: float | None
) -> Callable[[float, float], Intervals]:
    """Intervals about a value whose error is `spread` times that of one reading."""
    if sigma is not None:
        return lambda value, spread: normal_intervals(value, sigma * spread)
    # Numbers that fit exactly are still rounded.
    scatter = max(np.sqrt(squares / max(freedom, 1)), np.finfo(float).eps)
    return lambda value, spread: student_intervals(value, scatter * spread, freedom)


def _about_fit(
    condition: tuple[float, int], squares: float, freedom: int, sigma: float | None
) -> tuple[str, ...]:
    findings = ()
    if condition[0] > _POOR_CONDITION:
        findings += (
            f"The positions are poorly spread (condition number {condition[0]:.3g}, 5 is good), "
            "which the intervals show; add positions between the others.",
        )
    if sigma is not None and freedom > 0:
        chance = float(chi2.sf(squares / sigma**2, freedom))
        if chance < _INCONSISTENT:
            findings += (
                f"The residuals scatter more than the stated standard deviation ({p_value(chance)})"
                ": the intervals are too narrow; leave it out to have them from the scatter.",
            )
    return findings


def _about_outlier(
    studentized: Float64[np.ndarray, "positions *axes"], freedom: int, axes: Sequence[str] = ()
) -> tuple[str, ...]:
    """The position that stands out most, if by more than one test in a hundred would show."""
    worst = stands_out(studentized, freedom)
    if worst is None:
        return ()
    position, *axis = np.unravel_index(worst, studentized.shape)
    where = f" on {axes[int(axis[0])]}" if axis else ""
    return (
        f"Position {position + 1} stands out from the others{where} (studentized residual "
        f"{studentized.flat[worst]:.1f}), and widens all intervals: repeat it, or leave it out.",
    )


def _scatter(squares: float, freedom: int, factor: float, unit: str) -> str:
    """The standard deviation of a reading, as the residuals tell it."""
    if freedom <= 0:
        return ""
    size = significant(factor * np.sqrt(squares / freedom), 2)
    return f", residuals scatter by {f'{size} {unit}'.strip()}"


def _meaning(freedom: int, sigma: float | None, each: str = "") -> str:
    if sigma is not None:
        return _STATED
    return _SCATTER.format(freedom=freedom, each=each) if freedom > 0 else _NONE


def _description(count: int, gravity: float, attitudes: str) -> str:
    return f"{count} positions, {attitudes}, gravity {significant(gravity, 6)} m/s^2"


def _conditions(
    gravity: float, count: int, known: bool, orthogonal: bool, condition: float
) -> dict[str, object]:
    return {
        "gravity": gravity,
        "positions": count,
        "attitudes_known": known,
        "orthogonal": orthogonal,
        "condition_number": condition,
    }


def _residuals(
    values: Float64[np.ndarray, " positions"], unit: str, groups: tuple[str, ...]
) -> Residuals:
    number = np.arange(1.0, len(values) + 1)
    return Residuals(number, "position", np.asarray(values, np.float64), unit, groups)
