"""What effects do to samples: draws against densities, and against other people's recipes."""

from itertools import pairwise

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.signal import butter, cont2discrete, lfilter, sosfilt

from allanfit.physics import (
    Bump,
    Disturbance,
    DriftingLine,
    DroppedSamples,
    GaussMarkov,
    LowPass,
    Outliers,
    OutputRounding,
    PowerLaw,
    RandomTelegraph,
    Resonance,
    SampleHold,
    Saturation,
    Sinusoid,
    Step,
    Temperature,
    VarianceModulation,
    VibrationRectification,
    WarmUp,
    draw_recording,
    effect_from,
    standard_model,
)

DT = 0.01
KEY = jax.random.key(11)
SAMPLES, RECORDS = 256, 3000
LAGS = np.array([1, 2, 5, 20, 100])


def made(effect, *values):
    return effect(*(jnp.asarray(float(value)) for value in values))


def band_nodes():
    """Nodes and weights over (0, 50 Hz), finer towards zero and about a peak at 13 Hz."""
    edges = [np.geomspace(1e-12, 50, 60), np.linspace(0, 50, 101), 13 + np.linspace(-30, 30, 121)]
    edges = np.unique(np.clip(np.concatenate(edges), 0, 50))
    node, weight = np.polynomial.legendre.leggauss(12)
    frequency = np.diff(edges)[:, None] * (node + 1) / 2 + edges[:-1, None]
    return frequency.ravel(), (np.diff(edges)[:, None] / 2 * weight).ravel()


NOISES = {
    "gauss_markov": made(GaussMarkov, 0.7, 0.05),
    "resonance": made(Resonance, 0.7, 13.0, 6.0),
    "critical resonance": made(Resonance, 0.7, 3.0, 0.5),
    "power_law, 0.4": made(PowerLaw, 0.4, 0.3),
    "power_law, 1.5": made(PowerLaw, 1.5, 0.3),
    "power_law, 2.5": made(PowerLaw, 2.5, 0.3),
    "drifting_line": made(DriftingLine, 0.7, 13.0, 1.5),
    "random_telegraph": made(RandomTelegraph, 0.7, 0.08),
    "uneven random_telegraph": made(RandomTelegraph, 0.7, 0.08, 0.2),
}
AVERAGED = ("gauss_markov", "resonance", "power_law, 1.5", "random_telegraph")


# Parameters are arguments of what is compiled, so that effects of a class share a program.
@eqx.filter_jit
def draws(noise, sampling):
    keys = jax.random.split(KEY, RECORDS)
    return jax.vmap(lambda key: noise.sample(key, SAMPLES, DT, sampling))(keys)


def applied(effect, samples, key=KEY):
    return np.asarray(eqx.filter_jit(effect.apply)(key, jnp.asarray(samples), DT, "point"))


def recording(coefficients, effect, samples):
    model = standard_model(coefficients)
    draw = eqx.filter_jit(draw_recording)
    return np.asarray(draw(KEY, model, [effect], samples, DT, "point"))


@pytest.mark.parametrize(
    ("name", "sampling"),
    [(name, "point") for name in NOISES]
    # The others average as these do.
    + [(name, "averaged") for name in NOISES if name in AVERAGED],
)
def test_draws_have_the_density(name, sampling):
    """Half the mean square of differences over five lags, and the variance where there is one.

    3000 records of 256; |z| < 4.5 of six statistics, false alarm 4e-5 a case, the key being fixed.
    Power laws are drawn as periodic over twice the record, which may cost them 2 %.
    """
    noise, (frequency, weight) = NOISES[name], band_nodes()
    density = np.asarray(eqx.filter_jit(noise.density)(frequency, DT, sampling)) * weight
    waves = 2 * np.sin(np.pi * frequency * DT * LAGS[:, None]) ** 2
    drawn = np.asarray(draws(noise, sampling))
    start = 70
    found = (drawn[:, start + LAGS] - drawn[:, [start]]) ** 2 / 2
    expected = waves @ density
    if "power_law" not in name:
        found = np.column_stack([found, drawn[:, start] ** 2])
        expected = np.append(expected, density.sum())
    error = found.std(axis=0) / np.sqrt(RECORDS)
    # The levels of telegraph noise have one square, and no error.
    slack = expected * (0.02 if "power_law" in name else 1e-9)
    assert np.all(np.abs(found.mean(axis=0) - expected) < 4.5 * error + slack)


def test_uneven_levels_are_held_as_long_as_they_say():
    """80,000 samples of a level held 1.6 s and one held .4 s: 400 visits, |z| < 4.5."""
    noise, samples = made(RandomTelegraph, 1.0, 1.0, 0.8), 80_000
    upper = np.asarray(eqx.filter_jit(noise.sample)(KEY, samples, DT, "point")) > 0
    visits = np.count_nonzero(np.diff(upper.astype(int)) == 1)
    count = samples * DT / 2.0
    assert abs(visits - count) < 4.5 * np.sqrt(count)
    # A dwell is exponential, and as uncertain as the number of visits makes it.
    for held, dwell in ((upper.sum(), 1.6), ((~upper).sum(), 0.4)):
        assert held * DT / visits == pytest.approx(dwell, rel=4.5 / np.sqrt(count))


def periodogram_bins(records):
    """Means over octaves of bins and over records, under a Hann window [u^2/Hz]."""
    count = records.shape[1]
    window = np.hanning(count + 1)[:-1]
    spectrum = np.abs(np.fft.rfft((records - records.mean()) * window)) ** 2
    density = 2 * DT * spectrum / np.sum(window**2)
    edges = np.array([4, 8, 16, 32, 64, 128, 256, count // 2])
    bins = np.stack([density[:, a:b].mean(axis=1) for a, b in pairwise(edges)])
    frequency = np.arange(count // 2 + 1) / (count * DT)
    return bins.T, frequency, edges


def agrees(records, density, *sampling, tolerance=0.02):
    """Octaves of the periodogram within 4.5 standard errors and a tolerance of the density."""
    bins, frequency, edges = periodogram_bins(records)
    curve = np.asarray(eqx.filter_jit(density)(frequency[1:], DT, *sampling))
    expected = np.array([curve[a - 1 : b - 1].mean() for a, b in pairwise(edges)])
    error = bins.std(axis=0) / np.sqrt(len(records))
    return np.all(np.abs(bins.mean(axis=0) - expected) < 4.5 * error + tolerance * expected)


def test_another_recipe_of_a_resonance():
    """Stormer-Verlet in 32 steps a sample, 400 records of 1024. False alarm about 5e-5."""
    random, parts = np.random.default_rng(1), 32
    omega, quality, step = 2 * np.pi * 9.0, 3.0, DT / 32
    x, v = np.zeros((2, 400))
    records = np.empty((400, 1024 + 64))
    for k in range(records.shape[1]):
        records[:, k] = x
        push = np.sqrt(2 * omega**3 / quality * step) * 0.7 * random.standard_normal((parts, 400))
        for kick in push:
            x = x + v * step / 2
            v = v * np.exp(-omega / quality * step) - omega**2 * x * step + kick
            x = x + v * step / 2
    noise = made(Resonance, 0.7, 9.0, 3.0)
    assert agrees(records[:, 64:], noise.density, "point")
    other = made(Resonance, 0.7, 9.0, 3.6)
    assert not agrees(records[:, 64:], other.density, "point")


def test_another_recipe_of_telegraph_noise():
    """Exponential times between switches, looked up: 400 records. False alarm about 5e-5."""
    random = np.random.default_rng(2)
    switches = np.cumsum(random.exponential(0.08, (400, 400)), axis=1)
    assert switches[:, -1].min() > 10.24
    time = np.arange(1024) * DT
    count = np.stack([np.searchsorted(each, time) for each in switches])
    records = 0.7 * ((count + random.integers(0, 2, (400, 1))) % 2 - 0.5)
    noise = made(RandomTelegraph, 0.7, 0.08)
    assert agrees(records, noise.density, "point")
    louder = made(RandomTelegraph, 0.7 * 1.1**0.5, 0.08)
    assert not agrees(records, louder.density, "point")


def test_another_recipe_of_a_filter():
    """SciPy's Butterworth at 16 times the rate, then every 16th sample. False alarm about 5e-5."""
    random = np.random.default_rng(3)
    for order, cutoff in ((2, 45.0), (3, 60.0)):
        white = random.standard_normal((200, 16 * 1100)) * np.sqrt(0.5 * 16 / DT)
        fine = sosfilt(butter(order, cutoff, fs=16 / DT, output="sos"), white)
        low_pass = made(LowPass, cutoff, order)
        assert agrees(fine[:, 16 * 76 :: 16], low_pass.folded)
        assert not agrees(fine[:, 16 * 76 :: 16], low_pass.passed)


def test_a_filter_behind_the_converter():
    """SciPy's Butterworth filter of samples; false alarm about 5e-5."""
    white = np.random.default_rng(4).standard_normal((400, 1500)) * np.sqrt(0.5 / DT)
    found = sosfilt(butter(2, 20.0, fs=1 / DT, output="sos"), white)[:, 476:]
    low_pass = LowPass(jnp.asarray(20.0), jnp.asarray(2.0), digital=True)
    assert agrees(np.asarray(found), low_pass.gain)
    assert not agrees(np.asarray(found), made(LowPass, 20.0, 2.0).gain)


def test_a_running_mean_of_samples():
    """By convolution, of five samples and twice of three; false alarm about 5e-5 each."""
    white = np.random.default_rng(5).standard_normal((400, 1034)) * np.sqrt(0.5 / DT)
    for taps, times, kernel in ((5, 1, np.ones(5) / 5), (3, 2, np.array([1, 2, 3, 2, 1]) / 9)):
        found = np.stack([np.convolve(row, kernel, "valid")[:1024] for row in white])
        # Half of the power passes where sin(n x)^2k = (n sin x)^2k / 2.
        x = brentq(lambda x: (np.sin(taps * x) / (taps * np.sin(x))) ** (2 * times) - 0.5, 0.01, 1)  # noqa: B023
        low_pass = LowPass(
            jnp.asarray(x / np.pi / DT), jnp.asarray(float(times)), running_mean=True
        )
        assert float(low_pass.taps(DT)) == pytest.approx(taps)
        # What leaks to the zeros in 1024 samples is a tenth of the highest octave.
        assert agrees(found, low_pass.gain, tolerance=0.1)
        plain = LowPass(low_pass.cutoff_frequency, low_pass.order, digital=True)
        assert not agrees(found, plain.gain, tolerance=0.1)


def test_a_filter_that_droops():
    """An oscillator damped by 1.2, by SciPy at 16 times the rate. False alarm about 5e-5."""
    random = np.random.default_rng(6)
    turn, damping = 2 * np.pi * 30.0, 1.2
    numerator, denominator, _ = cont2discrete(
        ([turn**2], [1, 2 * damping * turn, turn**2]), DT / 16, "bilinear"
    )
    white = random.standard_normal((200, 16 * 1100)) * np.sqrt(0.5 * 16 / DT)
    fine = lfilter(numerator[0], denominator, white)
    # 1 + c y + y^2 with y = (f/f_0)^2 and c = 4 damping^2 - 2, which is 2 at f_c.
    c = 4 * damping**2 - 2
    y = (np.sqrt(c**2 + 4) - c) / 2
    low_pass = LowPass(jnp.asarray(30.0 * np.sqrt(y)), jnp.asarray(2.0), droop=jnp.asarray(c * y))
    assert agrees(fine[:, 16 * 76 :: 16], low_pass.folded)
    plain = made(LowPass, 30.0 * np.sqrt(y), 2.0)
    assert not agrees(fine[:, 16 * 76 :: 16], plain.folded)


def test_loud_times_are_loud_at_all_frequencies():
    """White noise twice as strong: block means of two seconds as well. 400 each, to 12 %."""
    effect = effect_from("variance_modulation", {"ratio": 2.0, "intervals": [[800.0, 1600.0]]})
    drawn = recording({"N": 1.0}, effect, 160_000)
    means = drawn.reshape(-1, 200).mean(axis=1)
    assert means[400:].std() / means[:400].std() == pytest.approx(2, rel=0.12)


def test_a_strength_that_varies_goes_in_straight_lines():
    """From 1 to 3 and back. Block deviations of 4000 samples each, known to 1.1 %."""
    given = {"times": [0.0, 800.0, 1600.0], "strengths": [1.0, 3.0, 1.0]}
    effect = effect_from(
        "variance_modulation", {"ratio": 3.0, "intervals": [[0.0, 1600.0]], **given}
    )
    drawn = recording({"N": 1.0}, effect, 160_000)
    found = drawn.reshape(40, -1).std(axis=1) * np.sqrt(DT)
    middles = (np.arange(40) + 0.5) / 20
    assert found == pytest.approx(1 + 2 * (1 - np.abs(middles - 1)), rel=0.05)


@eqx.filter_jit
def passed(effect, records):
    keys = jax.random.split(KEY, len(records))
    return jax.vmap(lambda key, each: effect.apply(key, each, DT, "point"))(keys, records)


@pytest.mark.parametrize(
    "effect",
    [
        made(LowPass, 20.0, 2.0),
        made(Bump, 1.2, 8.0, 0.4),
        made(Bump, -1.2, 20.0, 0.4),
        made(SampleHold, 3.0),
        made(SampleHold, 2.4),
    ],
    ids=["low_pass", "bump", "dip", "hold 3", "hold 2.4"],
)
def test_filters_do_to_white_noise_as_they_say(effect):
    """400 records of 1024; false alarm about 5e-5."""
    white = jax.random.normal(KEY, (400, 1024)) * np.sqrt(0.5 / DT)
    assert agrees(np.asarray(passed(effect, white)), effect.gain)
    assert not agrees(np.asarray(white), effect.gain)


def test_filters_pass_a_mean():
    samples = 5.0 + np.sin(np.arange(200.0))
    for effect in (made(LowPass, 120.0, 1.0), made(Bump, 1.0, 8.0, 0.4)):
        assert applied(effect, samples).mean() == pytest.approx(samples.mean())


ZEROS = np.zeros(1000)
TIME = DT * np.arange(1000)


def test_a_sinusoid():
    fixed = Sinusoid(jnp.asarray(2.0), jnp.asarray(3.0), jnp.asarray(0.5))
    expected = 2 * np.sin(2 * np.pi * 3 * TIME + 0.5)
    np.testing.assert_allclose(applied(fixed, ZEROS), expected, atol=1e-12)
    free = made(Sinusoid, 2.0, 3.0)
    one, other = (applied(free, ZEROS, jax.random.key(seed)) for seed in (0, 1))
    assert np.std(one) == pytest.approx(2**0.5)
    assert np.abs(one - other).max() > 0.1
    np.testing.assert_allclose(free.mean(jnp.asarray(TIME)), 2 * np.sin(6 * np.pi * TIME))


def test_warm_up_and_steps():
    found = applied(made(WarmUp, -2.0, 3.0), ZEROS)
    np.testing.assert_allclose(found, -2 * np.exp(-TIME / 3))
    times = jnp.array([5.0, 2.0])
    both = applied(Step(jnp.array([1.0, 10.0]), times), ZEROS)
    np.testing.assert_allclose(both, 1.0 * (TIME >= 5) + 10.0 * (TIME >= 2))
    given = {"amplitude": 1.0, "times": [5.0, 2.0], "heights": [1.5, -0.5]}
    drawn = recording({}, effect_from("step", given), 1000)
    np.testing.assert_allclose(drawn, 1.5 * (TIME >= 5) - 0.5 * (TIME >= 2))
    same = applied(Step(jnp.asarray(3.0), times), ZEROS)
    np.testing.assert_allclose(same, 3.0 * (TIME >= 5) + 3.0 * (TIME >= 2))


def test_disturbances_change_nothing():
    disturbance = Disturbance(jnp.array([[7.0, 8.0], [1.0, 2.0], [1.5, 3.0]]))
    np.testing.assert_array_equal(applied(disturbance, ZEROS), ZEROS)


def test_temperature_is_slow_and_of_one_kelvin():
    """Variance over 400 keys: a fifth is four standard errors, false alarm 1e-4.

    The square has heavier tails: fifteen times the variance of its own square, .19 of its mean.
    """
    silence = np.zeros((400, 1000))
    drawn = np.asarray(passed(made(Temperature, 0.3, 60.0), silence))
    assert np.mean(drawn[:, -1] ** 2) == pytest.approx(0.3**2, rel=0.28)
    assert np.mean((drawn[:, 100] - drawn[:, 0]) ** 2) < 0.1 * 0.3**2
    # Of a standard normal variate the square has the variance 2.
    bent = Temperature(quadratic=jnp.asarray(0.3), time_scale=jnp.asarray(60.0))
    drawn = np.asarray(passed(bent, silence))
    assert np.mean(drawn[:, -1] ** 2) == pytest.approx(2 * 0.3**2, rel=0.7)
    silent = Temperature(time_scale=jnp.asarray(60.0))
    np.testing.assert_array_equal(applied(silent, ZEROS), ZEROS)


def test_outliers():
    """Count and rms of 1e5 samples, within 4.5 standard errors: false alarm 1e-5."""
    found = applied(made(Outliers, 0.01, 5.0), np.zeros(100_000))
    hit = found[found != 0]
    assert abs(len(hit) - 1000) < 4.5 * 1000**0.5
    assert abs(np.mean(hit**2) / 25 - 1) < 4.5 * (2 / len(hit)) ** 0.5


def test_outliers_that_are_alike():
    """As above: of a mean size with a relative deviation of a tenth, and as many up as down."""
    effect = effect_from("outliers", {"fraction": 0.01, "amplitude": 5.0, "alike": 1})
    hit = applied(effect, np.zeros(100_000))
    hit = hit[hit != 0]
    assert abs(np.mean(np.abs(hit)) / 5 - 1) < 4.5 * 0.1 / len(hit) ** 0.5
    assert abs(np.std(np.abs(hit)) / 0.5 - 1) < 4.5 / (2 * len(hit)) ** 0.5
    assert abs(np.mean(hit > 0) - 0.5) < 4.5 * 0.5 / len(hit) ** 0.5


def test_rounding_and_saturation():
    samples = np.array([-0.9, -0.26, 0.1, 0.6])
    rounded = applied(made(OutputRounding, 0.5), samples)
    np.testing.assert_array_equal(rounded, [-1.0, -0.5, 0.0, 0.5])
    clipped = applied(made(Saturation, 0.5), samples)
    np.testing.assert_array_equal(clipped, [-0.5, -0.26, 0.1, 0.5])
    # At one end only, and at two that are not alike.
    for ends, expected in (
        ({"low": 0.0}, [0.0, 0.0, 0.1, 0.6]),
        ({"high": -0.1}, [-0.9, -0.26, -0.1, -0.1]),
        ({"low": -0.3, "high": 0.5}, [-0.3, -0.26, 0.1, 0.5]),
    ):
        effect = effect_from("saturation", {"limit": 0.0, **ends})
        np.testing.assert_allclose(applied(effect, samples), expected)


def test_dropped_samples_close_up():
    """The number dropped of 1e4 within 4.5 standard errors: false alarm 1e-5."""
    effect = made(DroppedSamples, 0.1)
    found = applied(effect, np.arange(10_000.0))
    last = int(found.argmax())
    assert abs(last - 9000) < 4.5 * 900**0.5 + 1
    kept = found[: last + 1]
    assert set(np.diff(kept)) <= {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0}
    np.testing.assert_array_equal(found[last:], found[last : 2 * last - 9999 - 1 : -1])
    enough = effect.enough(10_000)
    longer = applied(effect, np.arange(float(enough)))
    assert np.all(np.diff(longer[:10_000]) > 0)
    assert enough < 11_400


def test_held_samples_repeat():
    found = applied(made(SampleHold, 3.0), np.arange(12.0))
    np.testing.assert_array_equal(found, np.repeat([0.0, 3.0, 6.0, 9.0], 3))
    held = applied(made(SampleHold, 1.25), np.arange(100_000.0))
    # Repeats of 1e5 samples, 4.5 standard errors: false alarm 1e-5.
    assert np.mean(np.diff(held) == 0) == pytest.approx(0.2, abs=4.5 * 0.4 / 1e5**0.5)


def test_a_clock_of_its_own_holds_evenly():
    """At 5 values in 8 samples each is held once or twice, and eight samples bring five."""
    held = applied(SampleHold(jnp.asarray(1.6), regular=True), np.arange(8000.0))
    changes = np.flatnonzero(np.diff(held))
    assert set(np.diff(changes)) == {1, 2}
    assert np.all(changes[5:] - changes[:-5] == 8)
    assert np.all(held <= np.arange(8000))


def test_stronger_noise_in_its_intervals_alone():
    noise = np.asarray(jax.random.normal(KEY, (100_000,)))
    slow = 20 * np.sin(2 * np.pi * 0.01 * DT * np.arange(100_000))
    effect = VarianceModulation(jnp.asarray(3.0), jnp.array([[100.0, 300.0]]))
    change = applied(effect, noise + slow) - noise - slow
    inside = slice(10_000, 30_000)
    assert np.abs(np.delete(change, np.r_[inside])).max() < 1e-12
    assert change[inside].std() == pytest.approx(2.0, rel=0.03)
    assert abs(np.corrcoef(change[inside], slow[inside])[0, 1]) < 0.05


def test_vibration_shifts_the_bias():
    noise = np.asarray(jax.random.normal(KEY, (100_000,)))
    noise = noise * np.where(np.arange(100_000) < 50_000, 1.0, 2.0)
    shifted = applied(made(VibrationRectification, 0.1), noise) - noise
    assert shifted[:49_000].mean() == pytest.approx(0.1, rel=0.03)
    assert shifted[51_000:].mean() == pytest.approx(0.4, rel=0.03)


def test_a_sinusoid_keeps_its_phase_in_float32():
    """After 207,000 turns, where float32 knows phases to an eightieth of a turn."""
    samples, turn = 1_000_000, 850 / 64**2
    with jax.enable_x64(False):
        line = Sinusoid(jnp.asarray(1.0), jnp.asarray(850 / 64), jnp.asarray(0.3))
        draw = eqx.filter_jit(line.apply)
        drawn = draw(jax.random.key(0), jnp.zeros(samples), 1 / 64, "point")
        assert drawn.dtype == jnp.float32
    expected = np.sin(2 * np.pi * (turn * np.arange(samples) % 1) + 0.3)
    np.testing.assert_allclose(drawn, expected, atol=1e-3)
