"""Effects beyond the five terms: their densities against their autocovariances and closed forms."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import butter, freqs, freqz, iirnotch
from scipy.special import gamma

from allanfit.physics import (
    EFFECTS,
    AbstractAddedNoise,
    AbstractFilter,
    Bump,
    DriftingLine,
    GaussMarkov,
    LowPass,
    PowerLaw,
    RandomTelegraph,
    Resonance,
    SampleHold,
    effect_from,
    field_of,
)

# Names and parameters are those of explain's JSON, which other programs read.
CONTRACT = {
    "gauss_markov": ["sigma", "correlation_time"],
    "sinusoid": ["amplitude", "frequency"],
    "drifting_line": ["amplitude", "frequency", "width"],
    "resonance": ["sigma", "frequency", "quality_factor"],
    "low_pass": [
        "cutoff_frequency",
        "order",
        "droop",
        "ripple",
        "attenuation",
        "floor",
        "digital",
        "averaged",
        "recursive",
        "running_mean",
        "oversampled",
        "windowed",
        "last",
    ],
    "power_law": ["exponent", "density"],
    "random_telegraph": ["amplitude", "dwell_time", "upper_share"],
    "temperature": ["sensitivity", "time_scale", "quadratic"],
    "warm_up": ["amplitude", "time_constant"],
    "step": ["amplitude", "times", "heights"],
    "outliers": ["fraction", "amplitude", "alike"],
    "output_rounding": ["lsb"],
    "sample_hold": ["repeat", "regular"],
    "dropped_samples": ["fraction"],
    "saturation": ["limit", "low", "high"],
    "variance_modulation": ["ratio", "intervals", "times", "strengths"],
    "vibration_rectification": ["coefficient"],
    "disturbance": ["intervals"],
    "bump": ["height", "frequency", "width", "high_pass", "flat", "notch", "echo"],
}
DT = 0.01
SAMPLINGS = ("point", "averaged")
each_sampling = pytest.mark.parametrize("sampling", SAMPLINGS)


def made(effect, *values):
    return effect(*(jnp.asarray(float(value)) for value in values))


NOISES = {
    "gauss_markov": made(GaussMarkov, 0.7, 0.05),
    "slow gauss_markov": made(GaussMarkov, 0.7, 1e4),
    "fast gauss_markov": made(GaussMarkov, 0.7, 0.003),
    "resonance": made(Resonance, 0.7, 13.0, 6.0),
    "slow resonance": made(Resonance, 0.7, 0.01, 2.0),
    "fast resonance": made(Resonance, 0.7, 130.0, 3.0),
    "critical resonance": made(Resonance, 0.7, 3.0, 0.5),
    "critical fast resonance": made(Resonance, 0.7, 40.0, 0.5),
    "power_law": made(PowerLaw, 0.6, 0.3),
    "steep power_law": made(PowerLaw, 2.5, 0.3),
    "drifting_line": made(DriftingLine, 0.7, 13.0, 1.5),
    "folded drifting_line": made(DriftingLine, 0.7, 97.0, 2.0),
    "random_telegraph": made(RandomTelegraph, 0.7, 0.08),
    "uneven random_telegraph": made(RandomTelegraph, 0.7, 0.08, 0.2),
}
each_noise = pytest.mark.parametrize("noise", NOISES.values(), ids=NOISES)
FILTERS = {
    "low_pass": made(LowPass, 20.0, 1.3),
    "bump": made(Bump, 1.2, 8.0, 0.4),
    "sample_hold": made(SampleHold, 2.4),
}


def band_integral(density, centre=0.0, width=0.0):
    """Over (0, 50 Hz), by Gauss-Legendre on intervals that shrink towards zero and a peak."""
    edges = [np.zeros(1), np.geomspace(1e-15, 50, 90), np.linspace(0, 50, 101)]
    alias = abs(centre - round(centre * DT) / DT)
    edges.append(alias + width * np.concatenate([np.linspace(-30, 30, 121), [-200, -80, 80, 200]]))
    # Intervals of no width stay, so that all densities are of one number of frequencies, which
    # spares compilations.
    edges = np.sort(np.clip(np.concatenate(edges), 0, 50))
    node, weight = np.polynomial.legendre.leggauss(24)
    frequency = (np.diff(edges)[:, None] * (node + 1) / 2 + edges[:-1, None]).ravel()
    weight = (np.diff(edges)[:, None] / 2 * weight).ravel()
    return np.sum(density(np.where(weight > 0, frequency, 1.0)) * weight, axis=-1)


def peak(noise):
    if isinstance(noise, Resonance):
        return float(noise.frequency), float(noise.frequency / noise.quality_factor)
    return (float(noise.frequency), float(noise.width)) if isinstance(noise, DriftingLine) else ()


def autocovariance(noise, lag, sampling):
    """From the density, at a number of samples."""

    def wave(frequency):
        density = np.asarray(eqx.filter_jit(noise.density)(frequency, DT, sampling))
        return density * np.cos(2 * np.pi * frequency * DT * np.asarray(lag)[:, None])

    return band_integral(wave, *peak(noise))


def continuous(noise, time):
    """Autocovariances at a time [s], from the theory of the continuous process."""
    time = np.abs(time)
    if isinstance(noise, GaussMarkov):
        return float(noise.sigma) ** 2 * np.exp(-time / float(noise.correlation_time))
    if isinstance(noise, RandomTelegraph):
        share = 0.5 if noise.upper_share is None else float(noise.upper_share)
        dwells = 2 * float(noise.dwell_time) * np.array([share, 1 - share])
        spread = float(noise.amplitude) ** 2 * share * (1 - share)
        return spread * np.exp(-time * np.sum(1 / dwells))
    omega, zeta = 2 * np.pi * float(noise.frequency), 0.5 / float(noise.quality_factor)
    turning = omega * np.sqrt(1 - zeta**2)
    wave = np.cos(turning * time) + zeta * omega * time * np.sinc(turning * time / np.pi)
    return float(noise.sigma) ** 2 * np.exp(-zeta * omega * time) * wave


def test_the_catalogue_has_every_name_and_its_parameters():
    found = {name: [each.name for each in effect.parameters] for name, effect in EFFECTS.items()}
    assert list(found.items()) == list(CONTRACT.items())
    for effect in EFFECTS.values():
        fields = set(effect.__dataclass_fields__)
        assert {field_of(parameter) for parameter in effect.parameters} <= fields
        assert effect.what
        assert effect.origin
        if issubclass(effect, AbstractAddedNoise):
            assert effect.scale[0] in fields


def test_an_effect_from_its_name():
    noise = effect_from("power_law", {"exponent": 1.5, "density": 2})
    assert isinstance(noise, PowerLaw)
    assert (noise.exponent, noise.level) == (1.5, 2)
    assert effect_from("step", {"amplitude": [1, 2], "times": [3, 4]}).times.shape == (2,)
    assert effect_from("step", {"amplitude": 1, "times": 3}).times.shape == (1,)
    assert effect_from("temperature", {"time_scale": 60}).sensitivity is None


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("gremlin", {}, "effect 'gremlin' is not known; known are gauss_markov"),
        ("warm_up", {"amplitude": 1}, "warm_up lacks its parameter 'time_constant'"),
        (
            "saturation",
            {"limit": 1, "sign": 1},
            "saturation has no parameter 'sign'; it has high, limit, low",
        ),
        ("saturation", {"limit": "much"}, "limit of saturation must be a number; got 'much'"),
        ("saturation", {"limit": float("nan")}, "limit of saturation must be a number; got nan"),
        ("sinusoid", {"amplitude": [1, 2], "frequency": 1}, "amplitude of sinusoid must be a num"),
        ("disturbance", {"intervals": [1, 2]}, "intervals of disturbance must be pairs of start"),
        ("disturbance", {"intervals": [[8, 2]]}, "from 8 to 2 s, which ends before it starts"),
        ("step", {"amplitude": [1, 2, 3], "times": [4, 5]}, "has 3 amplitudes and 2 times"),
        ("saturation", {"limit": 1, "low": 2, "high": 1}, "low at 2, not below its high at 1"),
        (
            "variance_modulation",
            {"ratio": 2, "intervals": [[1, 2]], "times": [1, 2]},
            "has 2 times and 0 strengths",
        ),
    ],
)
def test_what_is_no_effect(name, parameters, message):
    with pytest.raises(ValueError, match=message):
        effect_from(name, parameters)


@each_sampling
@pytest.mark.parametrize(
    "name", [name for name in NOISES if not name.endswith(("power_law", "drifting_line"))]
)
def test_a_density_has_the_autocovariance_of_its_process(name, sampling):
    """Over an interval each mean has weight one: together, a triangle of two intervals."""
    noise, lag = NOISES[name], np.array([0, 1, 2, 7])
    expected = continuous(noise, lag * DT)
    if sampling == "averaged":
        node, weight = np.polynomial.legendre.leggauss(60)
        node, weight = (node + 1) / 2, weight / 2
        part = [continuous(noise, (lag[:, None] + sign * node) * DT) for sign in (-1, 1)]
        expected = (sum(part) * (1 - node)) @ weight
    # Critical damping is a limit, which the averaged form stays a little away from.
    error = 1e-6 if noise is NOISES["critical fast resonance"] else 1e-8
    np.testing.assert_allclose(autocovariance(noise, lag, sampling), expected, atol=error)


@pytest.mark.parametrize("name", ["drifting_line", "folded drifting_line"])
def test_a_drifting_line_keeps_the_power_of_a_sinusoid(name):
    lag = np.array([0, 3])
    noise = NOISES[name]
    # A normal distribution of frequency damps the wave by the square of the lag.
    f, width = float(noise.frequency), float(noise.width)
    expected = np.exp(-((2 * np.pi * width * lag * DT) ** 2) / 2) * np.cos(2 * np.pi * f * lag * DT)
    np.testing.assert_allclose(
        autocovariance(noise, lag, "point"), 0.7**2 / 2 * expected, atol=1e-10
    )


def allan_variance(noise, sizes, sampling):
    """The integral of the density with the kernel of the Allan variance."""

    def weighted(frequency):
        density = np.asarray(eqx.filter_jit(noise.density)(frequency, DT, sampling))
        half, n = np.pi * frequency * DT, sizes[:, None]
        return density * 2 * np.sin(n * half) ** 4 / (n * np.sin(half)) ** 2

    return band_integral(weighted, *peak(noise))


def test_allan_variance_of_gauss_markov_noise():
    """Textbook of the sensor that averages: IEEE Std 952, correlated noise, and its peak."""
    noise, sizes = made(GaussMarkov, 0.7, 0.2), np.array([1.0, 3.0, 10.0, 38.0, 200.0])
    r = sizes * DT / 0.2
    expected = 2 * 0.7**2 / r * (1 - (3 - 4 * np.exp(-r) + np.exp(-2 * r)) / (2 * r))
    found = allan_variance(noise, sizes, "averaged")
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    assert np.sqrt(found[3]) == pytest.approx(0.617 * 0.7, rel=2e-3)


@pytest.mark.parametrize("exponent", [0.3, 0.8, 1.5, 2.0, 2.6])
def test_allan_variance_of_a_power_law(exponent):
    """h C tau^(alpha - 1) at every size where the sensor averages, and at large ones otherwise.

    Vernotte et al., as in IEEE Std 1139 for whole exponents.
    """
    noise, sizes = made(PowerLaw, exponent, 0.3), np.array([1.0, 2.0, 10.0, 100.0])
    constant = -(np.pi ** (exponent - 1)) / 4 * gamma(-1 - exponent + 1e-9)
    constant *= np.sin(np.pi * (exponent - 1e-9) / 2) * (4 ** (exponent + 1) - 2 ** (exponent + 3))
    expected = 0.3 * constant * (sizes * DT) ** (exponent - 1)
    np.testing.assert_allclose(allan_variance(noise, sizes, "averaged"), expected, rtol=1e-6)
    point = allan_variance(noise, sizes, "point")
    np.testing.assert_allclose(point[-1], expected[-1], rtol=0.02 if exponent < 1 else 1e-3)


def test_a_first_order_filter_folds_as_its_closed_form():
    """The transform of exp(-2 pi f_c |t|) at whole intervals."""
    for cutoff in (3.0, 20.0, 120.0):
        frequency = np.linspace(0, 50, 11)
        x = 2 * np.pi * cutoff * DT
        expected = x / 2 * np.sinh(x) / (np.cosh(x) - np.cos(2 * np.pi * frequency * DT))
        found = eqx.filter_jit(made(LowPass, cutoff, 1.0).folded)(frequency, DT)
        np.testing.assert_allclose(found, expected, atol=4e-5 * (cutoff * DT) ** 2 + 1e-9)


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0, 5.0])
def test_a_filter_passes_the_power_of_its_noise_bandwidth(order):
    """f_c (pi/2 m)/sin(pi/2 m), folded or not."""
    for cutoff in (4.0, 45.0, 200.0):
        low_pass = made(LowPass, cutoff, order)
        folded = eqx.filter_jit(low_pass.folded)
        found = band_integral(lambda f, each=folded: np.asarray(each(f, DT)))
        angle = np.pi / (2 * order)
        # The rest that is integrated and not summed.
        rest = 4e-4 * order * (cutoff * DT / 16) ** (2 * order - 1)
        assert found == pytest.approx(cutoff * angle / np.sin(angle), rel=1e-7 + rest)
        assert float(eqx.filter_jit(low_pass.gain)(jnp.asarray(0.0), DT)) == pytest.approx(1)
    assert float(eqx.filter_jit(low_pass.passed)(jnp.asarray(200.0), DT)) == pytest.approx(0.5)


def test_a_first_order_filter_before_an_average():
    """Lag covariances of interval means of exp(-|t|/c), by integration: (1 - e^-x)^2/x^2 at one."""
    low_pass, x = made(LowPass, 30.0, 1.0), 2 * np.pi * 30.0 * DT
    lag = np.array([0, 1, 2])

    def wave(frequency):
        folded = np.asarray(eqx.filter_jit(low_pass.folded)(frequency, DT, "averaged"))
        return 2 * DT * folded * np.cos(2 * np.pi * frequency * DT * lag[:, None])

    near = (1 - np.exp(-x)) ** 2 / x**2
    expected = [2 * (x - 1 + np.exp(-x)) / x**2, near, near * np.exp(-x)]
    np.testing.assert_allclose(band_integral(wave), np.array(expected) * x / 2, atol=2e-4)


def test_held_values_have_their_autocovariance():
    """p^k where repeats are random; an average over the phase of the triangle where periodic."""
    lag = np.array([0, 1, 2, 3, 5])
    for repeat, expected in (
        (2.4, (1 - 1 / 2.4) ** lag),
        (3.0, np.maximum(1 - lag / 3, 0)),
        (1.0, lag == 0),
    ):
        hold = made(SampleHold, repeat)

        def wave(frequency, hold=hold):
            gain = np.asarray(eqx.filter_jit(hold.gain)(frequency, DT))
            return 2 * DT * gain * np.cos(2 * np.pi * frequency * DT * lag[:, None])

        np.testing.assert_allclose(band_integral(wave), expected, atol=1e-8)


@pytest.mark.parametrize("repeat", [1.1, 2.4, 3.0])
def test_values_held_by_a_clock_have_a_triangle_for_autocovariance(repeat):
    lag = np.array([0, 1, 2, 3, 5])
    hold = SampleHold(jnp.asarray(repeat), regular=True)

    def wave(frequency):
        gain = np.asarray(eqx.filter_jit(hold.gain)(frequency, DT))
        return 2 * DT * gain * np.cos(2 * np.pi * frequency * DT * lag[:, None])

    np.testing.assert_allclose(band_integral(wave), np.maximum(1 - lag / repeat, 0), atol=1e-8)


def test_a_bump_is_where_it_is_said_to_be():
    bump = made(Bump, -1.2, 8.0, 0.4)
    at = 8.0 * np.exp([0.0, 0.4, 40.0])
    expected = np.exp(-1.2 * np.exp([0.0, -0.5, -5000]))
    np.testing.assert_allclose(eqx.filter_jit(bump.gain)(at, DT), expected)
    assert eqx.filter_jit(bump.gain)(jnp.zeros(1), DT) == 1


@pytest.mark.parametrize(("frequency", "quality"), [(8.0, 2.0), (0.3, 30.0), (21.0, 5.0)])
def test_a_notch_is_that_which_firmware_takes_out(frequency, quality):
    """Against the digital filter that SciPy designs."""
    bump = Bump(*map(jnp.asarray, (-40.0, frequency, 1 / quality)), notch=True)
    at = np.geomspace(0.01, 0.499, 400) / DT
    numerator, denominator = iirnotch(frequency, quality, fs=1 / DT)
    expected = np.abs(freqz(numerator, denominator, at, fs=1 / DT)[1]) ** 2
    gain = np.asarray(eqx.filter_jit(bump.gain)(at, DT))
    np.testing.assert_allclose(gain, expected, rtol=1e-4, atol=1e-9)
    assert eqx.filter_jit(bump.gain)(jnp.zeros(1), DT) == 1


@pytest.mark.parametrize(("lag", "part"), [(9, 0.03), (2, -0.4), (40, 0.9)])
def test_an_echo_is_that_of_a_filter_of_two_taps(lag, part):
    bump = Bump(*map(jnp.asarray, (part, 1 / (lag * DT), 1.0)), echo=True)
    at = np.linspace(0.0, 0.5, 400) / DT
    expected = np.abs(freqz([1.0, *(lag - 1) * [0.0], part], worN=at, fs=1 / DT)[1]) ** 2
    np.testing.assert_allclose(eqx.filter_jit(bump.gain)(at, DT), expected, rtol=1e-9)


def test_a_flat_bump_is_a_band_with_steep_flanks():
    """Within .7 widths as high as in the middle to 3 %, beyond 1.5 widths nothing."""
    bump = Bump(*map(jnp.asarray, (1.2, 8.0, 0.4)), flat=True)
    at = 8.0 * np.exp(0.4 * np.array([-1.5, -1.0, -0.7, 0.0, 0.7, 1.0, 1.5]))
    height = np.log(np.asarray(eqx.filter_jit(bump.gain)(at, DT))) / 1.2
    np.testing.assert_allclose(height[2:5], 1.0, atol=0.03)
    np.testing.assert_allclose(height[[1, 5]], np.exp(-0.5))
    assert np.all(height[[0, 6]] < 1e-5)


@pytest.mark.parametrize("order", [1, 2])
def test_a_high_pass_is_a_butterworth_filter(order):
    frequency = np.geomspace(0.01, 10, 30)
    numerator, denominator = butter(order, 2 * np.pi * 0.5, "high", analog=True)
    _, expected = freqs(numerator, denominator, 2 * np.pi * frequency)
    bump = Bump(*map(jnp.asarray, (0.0, 0.5, 1 / (2 * order))), high_pass=True)
    gain = np.asarray(eqx.filter_jit(bump.gain)(frequency, DT))
    np.testing.assert_allclose(gain, np.abs(expected) ** 2, rtol=1e-6)


@each_sampling
@each_noise
def test_a_density_in_single_precision(noise, sampling):
    frequency = np.array([1e-3, 0.011, 0.9, 6.0, 13.0, 31.0, 50.0])
    exact = eqx.filter_jit(noise.density)(frequency, DT, sampling)
    single = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), noise)
    found = eqx.filter_jit(single.density)(frequency.astype(np.float32), DT, sampling)
    assert found.dtype == jnp.float32
    # Far from a line nothing is left in single precision.
    np.testing.assert_allclose(found, exact, rtol=3e-4, atol=1e-20)


FREQUENCY = jnp.array([0.02, 3.0, 14.0, 49.0])
CURVES = {
    **{
        f"{name}, {sampling}": (noise, lambda each, s=sampling: each.density(FREQUENCY, DT, s))
        for name, noise in NOISES.items()
        for sampling in SAMPLINGS
        if name in ("gauss_markov", "resonance", "critical resonance", "power_law", "drifting_line")
    },
    **{
        name: (each, lambda each: each.gain(jnp.append(FREQUENCY, 0.0), DT))
        for name, each in FILTERS.items()
    },
}


@pytest.mark.parametrize("name", CURVES)
def test_gradients_and_batches(name):
    """Slope along the parameters against a finite difference; vmap against a loop."""
    effect, curve = CURVES[name][0], jax.jit(CURVES[name][1])
    if name.startswith("critical"):  # where damping is critical the slope has a side only
        _, slope = jax.jit(lambda at: jax.jvp(curve, (at,), (at,)))(effect)
        assert np.isfinite(slope).all()
        return
    ahead, behind = (jax.tree.map(lambda leaf, s=s: leaf * (1 + s), effect) for s in (1e-5, -1e-5))
    expected = (curve(ahead) - curve(behind)) / 2e-5
    _, slope = jax.jit(lambda at: jax.jvp(curve, (at,), (at,)))(effect)
    size = np.abs(np.asarray(curve(effect)))
    np.testing.assert_allclose(slope, expected, rtol=1e-5, atol=1e-9 * size.max())
    if isinstance(effect, AbstractFilter):
        reverse = jax.jit(jax.grad(lambda at: jnp.sum(curve(at))))(effect)
        assert all(np.isfinite(leaf) for leaf in jax.tree.leaves(reverse))
    both = jax.tree.map(lambda one, other: jnp.stack([one, other]), effect, ahead)
    loop = np.stack([curve(effect), curve(ahead)])
    np.testing.assert_allclose(jax.jit(jax.vmap(curve))(both), loop, rtol=1e-12)
