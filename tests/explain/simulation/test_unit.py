"""Whether a simulation without a unit is told to be in another, and only then."""

import numpy as np
import pytest

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain.simulation._references import Reference
from allanfit.explain.simulation._unit import unit_advice

DEGREE = np.pi / 180
# Q, N, B, K and R of a recording in SI, and how well they are known.
TERMS = np.array([0.0, 1e-4, 3e-5, 1e-6, 0.0])
ERRORS = np.array([1e-9, 1e-6, 3e-6, 3e-7, 1e-12])


def advice(ratios, unit="deg/s", assumed=True, errors=ERRORS):
    values = np.random.default_rng(1).standard_normal(1000)
    channel = allanfit.recording_of(values, rate_hz=100.0, unit=unit).channels[0]
    theirs = TERMS * np.array([1.0, *ratios, *[0.0] * (4 - len(ratios))])
    reference = Reference(
        theirs, np.zeros(5), unit, channel.kind, "s.yaml", "data", unit_assumed=assumed
    )
    return unit_advice((TERMS, errors), reference, channel)


@pytest.mark.parametrize(
    ("ratios", "unit", "likely"),
    [
        ((DEGREE,), "deg/s", "rad/s"),
        ((1 / DEGREE, 1 / DEGREE), "rad/s", "deg/s"),
        # N and B of another sensor besides, both far too small.
        ((0.0116, 0.0157), "deg/s", "rad/s"),
        ((3600.0, 3500.0, 4000.0), "deg/s", "deg/h"),
        ((1 / 9.80665,), "m/s^2", "g"),
        ((1000.0, 1100.0), "g", "mg"),
    ],
)
def test_another_unit_is_said(ratios, unit, likely):
    (said,) = advice(ratios, unit)
    assert f"gives no unit and looks to be in {likely}: " in said
    assert f"and {likely} taken for {unit} makes " in said
    assert advice(ratios, unit, assumed=False) == []


@pytest.mark.parametrize(
    ("ratios", "unit"),
    [
        ((1.0, 1.2), "deg/s"),
        # One is off, the other not.
        ((DEGREE, 1.0), "deg/s"),
        # A single one, ten standard deviations from any.
        ((0.9 * DEGREE,), "deg/s"),
        ((0.9 / 9.80665,), "m/s^2"),
        # Too small in all, by what no unit makes.
        ((0.1, 0.12), "deg/s"),
        ((DEGREE, DEGREE), "V"),
        ((), "deg/s"),
    ],
)
def test_other_differences_are_no_unit(ratios, unit):
    assert advice(ratios, unit) == []


def test_what_the_recording_hardly_shows_may_be_anything():
    """Each a fifth, which may as well be a tenth as a half."""
    errors = np.where(TERMS > 0, 0.45 * TERMS, ERRORS)
    assert advice((0.2, 0.2), "m/s^2", errors=errors) == []


def test_explain_says_it_of_a_file_and_not_of_one_in_the_same_unit(tmp_path):
    noise = {"N": 5e-3, "B": 4e-3}
    values = allanfit.simulate(noise, duration_s=163.84, rate_hz=50.0, seed=1)
    recording = allanfit.recording_of(np.asarray(values), rate_hz=50.0, unit="deg/s")
    path = tmp_path / "believed.yaml"
    for factor, unit, told in ((DEGREE, "", 1), (DEGREE, "unit: rad/s\n", 0), (1.0, "", 0)):
        path.write_text(unit + "".join(f"{s}: {v * factor:.6e}\n" for s, v in noise.items()))
        found = explain_recording(recording, simulation=path, posterior=False)
        advised = found.channels[0].to_dict()["advice"]
        assert sum("looks to be in rad/s" in each for each in advised) == told
