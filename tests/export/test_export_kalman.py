"""Filter matrices: what they make is the noise of the fit."""

import json

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import block_diag

import allanfit
from allanfit.export import (
    ExportError,
    Options,
    Part,
    State,
    discretise,
    export,
    gauss_markov,
    stack,
)
from allanfit.physics import standard_model


def kalman(path, options=None, **more):
    exported = export(path, "kalman", options, **more)
    return json.loads(exported.text), exported.warnings


def matrices(entry, form):
    return {
        name: np.array(rows)
        for name, rows in entry[form].items()
        if name != "dt_s" and np.size(rows)
    }


def allan_variance_from_matrices(discrete, dt, cluster_sizes):
    """By the spectrum of the state-space model and the kernel of the Allan variance."""
    f = np.concatenate([np.geomspace(1e-8, 1e-3, 40_000), np.linspace(1e-3, 0.5, 200_000)[1:]])
    density = np.zeros_like(f)
    # All states here are scalar relaxations and walks, so that the transfer is a simple sum.
    phi, driven, h = (
        np.diag(discrete["Phi"]), np.diag(discrete["Qd"]), discrete["H"][0],
    )  # fmt: skip
    assert np.count_nonzero(discrete["Phi"] - np.diag(phi)) == 0
    for p, q, gain in zip(phi, driven, h, strict=True):
        density += 2 * gain**2 * q / np.abs(1 - p * np.exp(-2j * np.pi * f)) ** 2
    density += 2 * discrete["Rd"][0, 0]
    found = []
    for n in cluster_sizes:
        kernel = 2 * np.sin(np.pi * f * n) ** 4 / (n * np.sin(np.pi * f)) ** 2
        found.append(np.trapezoid(density * kernel, f))
    return np.array(found)


@pytest.mark.parametrize("sampling", ["point", "averaged"])
def test_discrete_matrices_have_the_allan_variance_of_the_fit(write_fit, make_channel, sampling):
    """N small enough that flicker and walk carry the curve from the first octave on."""
    truth = {"N": 1e-5, "B": 2e-3, "K": 3e-5}
    channel = {**make_channel("gyro_x", **truth), "sampling": sampling}
    document, _ = kalman(write_fit(channel))
    (entry,) = document["channels"]
    sizes = np.array([4, 8, 16, 64, 256, 1024, 4096, 16384, 65536])
    found = allan_variance_from_matrices(matrices(entry, "discrete"), 0.01, sizes)
    wanted = standard_model(truth).allan_variance(jnp.asarray(sizes, float), 0.01, sampling)
    error = np.sqrt(found / np.asarray(wanted)) - 1
    # The states are sampled at instants: an averaging sensor's walk differs by 1/(4 n^2).
    assert np.abs(error).max() < 0.052
    assert entry["flicker"]["states"] == 5
    assert entry["flicker"]["worst_error_of_allan_deviation"] <= 0.05


def test_discrete_and_continuous_matrices_are_one_model(write_fit, make_channel):
    document, _ = kalman(write_fit(make_channel("x", unresolved="Q")))
    (entry,) = document["channels"]
    continuous, discrete = matrices(entry, "continuous"), matrices(entry, "discrete")
    dt = entry["discrete"]["dt_s"]
    names = [state["name"] for state in entry["states"]]
    times = np.array(entry["flicker"]["relaxation_times_s"])
    variances = np.array(entry["flicker"]["variances"])
    relaxing = slice(0, len(times))
    # Textbook discretisation of each kind of state.
    np.testing.assert_allclose(np.diag(discrete["Phi"])[relaxing], np.exp(-dt / times), rtol=1e-12)
    np.testing.assert_allclose(
        np.diag(discrete["Qd"])[relaxing], -variances * np.expm1(-2 * dt / times), rtol=1e-9
    )
    np.testing.assert_allclose(np.diag(continuous["Qc"])[relaxing], 2 * variances / times)
    bias, ramp, slope = (names.index(name) for name in ("bias", "ramp", "ramp_rate"))
    assert discrete["Qd"][bias, bias] == pytest.approx(3e-4**2 * dt)
    assert discrete["Phi"][ramp, slope] == pytest.approx(dt)
    assert discrete["Qd"][slope, slope] == 0
    assert continuous["Rc"] == pytest.approx(np.array([[5e-3**2]]))
    assert discrete["Rd"] == pytest.approx(np.array([[5e-3**2 / dt]]))
    assert entry["states"][slope]["initial_variance"] == pytest.approx(1e-14)
    assert entry["states"][bias]["initial_variance"] is None


def simulated(discrete, entry, samples, records, seed):
    """A plain loop over the filter's own equations."""
    random = np.random.default_rng(seed)
    starts = [state["initial_variance"] or 0.0 for state in entry["states"]]
    x = np.sqrt(starts)[:, None] * random.standard_normal((len(starts), records))
    root = np.linalg.cholesky(discrete["Qd"])
    out = np.empty((samples, records))
    for k in range(samples):
        out[k] = (discrete["H"] @ x)[0]
        x = discrete["Phi"] @ x + root @ random.standard_normal(x.shape)
    return out + np.sqrt(discrete["Rd"][0, 0]) * random.standard_normal(out.shape)


def test_the_matrices_make_records_of_the_fit(write_fit, make_channel):
    """Simulated as a filter's model, then measured and identified again."""
    truth = {"N": 5e-3, "B": 4e-3, "K": 2e-3}
    rate_hz, samples, records = 50.0, 30_000, 16
    channel = make_channel("x", rate_hz=rate_hz, samples=samples, **truth)
    (entry,) = kalman(write_fit(channel))[0]["channels"]
    data = simulated(matrices(entry, "discrete"), entry, samples, records, seed=5)

    sizes = [1, 4, 16, 64, 256, 1024]
    curves = np.asarray(allanfit.allan_variance(data.T.copy(), rate_hz, sizes))
    wanted = standard_model(truth).allan_variance(jnp.asarray(sizes, float), 1 / rate_hz, "point")
    deviation = np.sqrt(curves.mean(axis=0) / np.asarray(wanted)) - 1
    error = curves.std(axis=0, ddof=1) / curves.mean(axis=0) / 2 / np.sqrt(records)
    # Six sizes at 4 standard errors (t of 15 degrees): a false alarm in some 150 seeds.
    assert (np.abs(deviation) < 0.05 + 4 * error).all()

    fits = [allanfit.fit(series, rate_hz).least_squares for series in data.T]
    for symbol, true in truth.items():
        ratio = np.array([float(each[symbol]) for each in fits]) / true
        # The mean of each within 4 standard errors of the truth, with what the 5 % that the
        # realisation is allowed can do to B and K. A false alarm in some 300 seeds.
        spread = ratio.std(ddof=1) / np.sqrt(records)
        assert abs(ratio.mean() - 1) < (0.02 if symbol == "N" else 0.1) + 4 * spread, symbol


def test_unresolved_terms_stay_out_and_say_so(write_fit, make_channel):
    path = write_fit(make_channel("x", unresolved="QBKR"))
    document, warnings = kalman(path)
    (entry,) = document["channels"]
    assert [state["name"] for state in entry["states"]] == ["bias"]
    assert entry["discrete"]["Qd"] == [[0.0]]
    assert "constant" in entry["coefficients"]["K"]["how"]
    assert "flicker" not in entry
    assert any("K of x is not resolved" in each for each in warnings)
    assert any("B of x is not resolved" in each for each in warnings)
    (entry,) = kalman(path, Options(walk="limit"))[0]["channels"]
    # The upper limit of this fit is twice the value.
    assert entry["continuous"]["Qc"] == [[pytest.approx(6e-4**2)]]


def test_quantization_is_told_to_belong_to_the_angle(write_fit, make_channel):
    document, warnings = kalman(write_fit(make_channel("x", unresolved="R", Q=3e-5)))
    assert "9e-10 (deg)^2" in document["channels"][0]["coefficients"]["Q"]["how"]
    assert any("Q of x" in each for each in warnings)


def test_several_channels_stack(write_fit, make_channel):
    path = write_fit(make_channel("x"), make_channel("y", N=7e-3), make_channel("a", unit="m/s^2"))
    document, _ = kalman(path)
    each = [matrices(entry, "discrete") for entry in document["channels"]]
    stacked = matrices(document["stacked"], "discrete")
    for name in ("Phi", "Qd", "H", "Rd"):
        np.testing.assert_allclose(
            stacked[name], block_diag(*(entry[name] for entry in each)), atol=1e-18
        )
    assert document["stacked"]["states"][0]["name"] == "x.flicker_1"
    assert document["stacked"]["units"] == ["deg/s", "deg/s", "m/s^2"]
    different = write_fit(make_channel("x"), make_channel("y", rate_hz=50.0))
    document, warnings = kalman(different)
    assert "stacked" not in document
    assert any("differ in rate" in each for each in warnings)


def test_mixed_units_are_refused(write_fit, make_channel):
    path = write_fit(make_channel("x"), make_channel("y", unit="rad/s"))
    with pytest.raises(ExportError, match="x is in deg/s and y in rad/s"):
        kalman(path)
    assert len(kalman(path, channels=["y"])[0]["channels"]) == 1


def test_the_band_is_the_users(write_fit, make_channel):
    path = write_fit(make_channel("x"))
    (entry,) = kalman(path, Options(band_s=(1.0, 100.0)))[0]["channels"]
    assert entry["flicker"]["band_s"] == [1.0, 100.0]
    assert entry["flicker"]["states"] == 2
    with pytest.raises(ExportError, match="band must run"):
        kalman(path, Options(band_s=(100.0, 1.0)))
    with pytest.raises(ExportError, match="no place beside B's own states"):
        kalman(path, Options(walk=100.0))


def test_a_further_effect_is_one_more_part():
    """A resonance, which no term of the standard has, beside a relaxation."""
    f, q, variance = 3.0, 10.0, 2.0
    w = 2 * np.pi * f
    resonance = Part(
        "resonance",
        (State("x", "u", variance), State("x'", "u/s", variance * w**2)),
        F=np.array([[0.0, 1.0], [-(w**2), -w / q]]),
        G=np.array([[0.0], [1.0]]),
        Qc=np.array([[2 * variance * w**3 / q]]),
        H=np.array([[1.0, 0.0]]),
    )
    system = stack([[gauss_markov("B", "b", "u", 5.0, 1.0), resonance]])
    discrete = discretise(system, 0.01)
    # In the steady state the covariance is the initial one: P = Phi P Phi^T + Qd.
    steady = np.diag([1.0, variance, variance * w**2])
    np.testing.assert_allclose(
        discrete.Phi @ steady @ discrete.Phi.T + discrete.Qd, steady, rtol=1e-9, atol=1e-9
    )
    # And the autocovariance is the textbook's damped oscillation.
    damping, damped = w / (2 * q), w * np.sqrt(1 - 1 / (4 * q**2))
    lag = 7
    power = np.linalg.matrix_power(discrete.Phi, lag)[1:, 1:] @ steady[1:, 1:]
    t = lag * 0.01
    wanted = np.cos(damped * t) + damping / damped * np.sin(damped * t)
    assert power[0, 0] == pytest.approx(variance * np.exp(-damping * t) * wanted, rel=1e-9)
