"""A record with a gap: what is in its shorter stretch counts as much."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate

SAMPLES = 30_000
PIECES = ((0, 17_000), (17_200, SAMPLES))


def spikes(values, rng):
    hit = rng.random(SAMPLES) < 0.003
    values[hit] += 12 * rng.standard_normal(hit.sum())


def knock(values, rng):
    values[25_000:25_200] += 8 * rng.standard_normal(200)


def loud(values, rng):
    values[20_000:26_000] += rng.standard_normal(6000)


def edge(values, rng):
    values[17_200] = 150.0


@pytest.mark.parametrize(
    ("causes", "names"),
    [
        ((spikes,), {"outliers"}),
        ((knock,), {"disturbance"}),
        ((loud,), {"variance_modulation"}),
        ((edge,), {"disturbance"}),
        # The second is cut out once the first has been found.
        ((spikes, knock), {"outliers", "disturbance"}),
    ],
    ids=["spikes", "knock", "loud", "edge", "knock beside spikes"],
)
def test_what_disturbs_the_shorter_stretch_is_found_there(causes, names):
    rng = np.random.default_rng(21)
    values = rng.standard_normal(SAMPLES) + 0.006 * np.cumsum(rng.standard_normal(SAMPLES))
    for cause in causes:
        cause(values, rng)
    state = investigate(values, PIECES, "point", np.array([0.0, 1.0, 0.0, 3e-5]))
    assert {finding.name for finding in state.findings} == names
    # To three standard deviations of 1/sqrt(2 x 30,000).
    assert abs(np.exp(state.model.theta[1] / 2) - 1) < 0.0125
    if edge in causes:
        assert state.knocks == [(17_198, 17_203)]
    elif knock in causes:
        ((start, stop),) = state.knocks
        assert 24_500 < start <= 25_000 <= 25_200 <= stop < 25_700
    elif loud in causes:
        ends = np.flatnonzero(state.flags(state.modulation.loud))[[0, -1]]
        assert ends == pytest.approx([20_000, 26_000], abs=300)


def stepping(values):
    values[24_000:] += 0.5


def warming(values):
    values += 1.5 * np.exp(-np.arange(SAMPLES) / 1500)


def swaying(values):
    values += 0.1 * np.sin(2 * np.pi * np.arange(SAMPLES) / 3200 + 1)


@pytest.mark.parametrize(
    ("cause", "pieces", "name", "key", "true", "margin"),
    [
        (stepping, PIECES, "step", "time", 24_000, 60),
        # The longest begins when the sensor is nearly warm.
        (warming, ((0, 6000), (6100, SAMPLES)), "warm_up", "time_constant", 1500, 300),
        (
            swaying,
            ((0, 10_000), (10_100, 20_000), (20_100, SAMPLES)),
            "sinusoid",
            "frequency",
            1 / 3200,
            3e-6,
        ),
    ],
    ids=["step", "warm-up", "oscillation"],
)
def test_a_course_is_found_in_any_stretch(cause, pieces, name, key, true, margin):
    rng = np.random.default_rng(22)
    values = rng.standard_normal(SAMPLES) + 1e-4 * np.cumsum(rng.standard_normal(SAMPLES))
    cause(values)
    state = investigate(values, pieces, "point", np.array([0.0, 1.0, 0.0, 1e-8]))
    assert [finding.name for finding in state.findings] == [name]
    (course,) = state.courses
    assert course.shape[key] == pytest.approx(true, abs=margin)


def ringing(values):
    """A knock, and what rings behind it: in its own band, and weaker than the noise before long."""
    time = np.arange(3000)
    values[12_000:12_100] += 30 * rng_of(9).standard_normal(100)
    values[12_000:15_000] += 2.0 * np.exp(-time / 700) * np.sin(2 * np.pi * 0.06 * time)


def weaker(values):
    """A strong knock and two weak ones."""
    for at, size in ((6000, 15.0), (14_000, 2.0), (22_000, 2.0)):
        time = np.arange(400)
        values[at : at + 400] += size * np.exp(-time / 80) * np.sin(2 * np.pi * 0.13 * time)


def wrong_start(values):
    values[0] += 200
    values[9000:9150] += 8 * rng_of(9).standard_normal(150)


def rng_of(seed):
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    ("cause", "times"),
    [
        (ringing, ((12_000, 12_900),)),
        (weaker, ((6000, 6150), (14_000, 14_100), (22_000, 22_100))),
        (wrong_start, ((0, 1), (9000, 9150))),
    ],
)
def test_what_a_knock_hides_is_cut_out_as_well(cause, times):
    rng = rng_of(23)
    values = rng.standard_normal(SAMPLES) + 0.003 * np.cumsum(rng.standard_normal(SAMPLES))
    cause(values)
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 1e-5]))
    assert [finding.name for finding in state.findings] == ["disturbance"]
    cut = np.zeros(SAMPLES, bool)
    for start, stop in state.knocks:
        cut[start:stop] = True
    for start, stop in times:
        assert cut[start:stop].all()
    assert cut.sum() < 0.15 * SAMPLES
    assert abs(np.exp(state.model.theta[1] / 2) - 1) < 0.0125


@pytest.mark.parametrize("height", [1e2, 1e9])
def test_a_false_start_is_cut_out_however_large_it_is(height):
    """The five terms that were fitted with it are far from those without."""
    values = rng_of(24).standard_normal(SAMPLES)
    values[:4] = height
    level = height**2 * 4 / SAMPLES
    state = investigate(values, ((0, SAMPLES),), "point", np.array([level, level, level, level]))
    assert [finding.name for finding in state.findings] == ["disturbance"]
    assert state.gains["disturbance"].nats > 0
    assert abs(np.exp(state.model.theta[1] / 2) - 1) < 0.0125
