import pytest
from explanation_documents import make_explanation

from allanfit.report import format_explanation


@pytest.fixture
def explanation(document):
    return make_explanation(document)


def told(explanation, channel: int | None = None) -> str:
    """The text in one line, of one channel or of all."""
    if channel is not None:
        explanation["channels"] = explanation["channels"][channel : channel + 1]
    return " ".join(format_explanation(explanation).split())


GYRO = """\
gyro_x [deg/s]: explained
  gyro, 100 Hz, 360000 samples, 1 h, mean 0.01235 deg/s, point samples
  The five-term model leaves out exponentially correlated noise (Gauss-Markov)
  and a sinusoid; with them it describes the recording.
  A recording of five terms alone differs from them by as much with probability
  4e-7.

  Where it differs
    1. 13.019 Hz to 13.022 Hz (spectrum), × 31, p < 1e-12
       A line at 13.02 Hz stands 31 times above the five terms.
"""

CHANGES = """\
    N  angle random walk  before  0.006550 [0.006534, 0.006566] deg/s/sqrt(Hz)
       -24 %              after   0.005000 [0.004988, 0.005012] deg/s/sqrt(Hz)
                                  the intervals do not overlap
    B  bias instability   before  0.00240  [0.00190, 0.00290]   deg/s
       × 0.42             after   0.00100  [0.00079, 0.00121]   deg/s
                                  the intervals do not overlap
    K  rate random walk   before  1.08e-4  [7.1e-5, 1.45e-4]    deg/s/sqrt(s)
       -7.4 %             after   1.00e-4  [6.6e-5, 1.34e-4]    deg/s/sqrt(s)
    R  rate ramp          before  < 1.5e-7 deg/s/s
                          after   < 1.5e-7 deg/s/s
"""


def test_an_explained_gyro_is_printed_so(explanation):
    text = format_explanation(explanation)
    assert GYRO in text
    assert CHANGES in text


@pytest.mark.parametrize(
    "fact",
    [
        "Exponentially correlated noise (Gauss-Markov): 97 %",
        "sigma 0.00302 [0.00290, 0.00314] deg/s 10.87 [10.44, 11.31] deg/h",
        "correlation time 2.03 [1.81, 2.25] s",
        "or random telegraph noise: 2.6 %; to tell apart: the histogram of 2 s means",
        "A sinusoid: > 99.9 %",
        "frequency 13.020400 [13.020374, 13.020426] Hz",
        "-10234 before, -9987 after: better by 247 ± 21, 12 standard errors",
        "p < 1e-12 before, p = 0.37 after: the better model agrees with the recording",
        "kurtosis: p = 0.21. The distribution is normal",
        "- Look for a source of vibration at 13.02 Hz",
    ],
)
def test_effects_and_evidence_are_told(explanation, fact):
    assert fact in told(explanation, 0)


def test_what_happens_in_time_is_told_in_handy_units_and_with_doubt(explanation):
    text = told(explanation, 1)
    assert "The five-term model probably leaves out steps of the mean and a changing noise" in text
    assert "1. 14.8 min to 15.2 min (time), × 7.1, p = 1e-8" in text
    assert "times 900, 2460 s" in text
    assert "intervals 1500 to 2100 s" in text
    assert "or random telegraph noise: 2 % " in text


def test_a_moment_has_one_time_and_no_size(explanation):
    channel = explanation["channels"][1]
    channel["mismatch"][0] |= {"low": 999.97, "high": 999.98, "ratio": 1.0}
    assert "1. 16.7 min (time), p = 1e-8" in told(explanation, 1)


def test_a_consistent_channel_has_its_coefficients_and_no_more(explanation):
    text = told(explanation, 2)
    assert "gyro_z [deg/s]: consistent" in text
    assert "The five-term model agrees with the recording: nothing left out is seen in it." in text
    assert "Coefficients Q quantization < 1.0e-5 deg/s*s" in text
    assert not any(
        title in text for title in ("Where it differs", "What is left out", "Evidence", "Advice")
    )


def test_an_unexplained_channel_says_so(explanation):
    text = told(explanation, 3)
    assert "no effect of the catalogue explains how; a smooth bump stands for it" in text
    assert "the better model still differs from the recording" in text
    assert "× 0.44" in text
    assert "A smooth bump, which has no name: > 99.9 % A hump about 5 Hz" in text
    assert "K acceleration random walk before 2.00e-6 [1.32e-6, 2.68e-6] g/sqrt(s) the same" in text


def test_effects_beside_something_unexplained(explanation):
    explanation["channels"][0]["verdict"] = "unexplained"
    explanation["channels"][0]["effects"] *= 2
    text = told(explanation, 0)
    assert "(Gauss-Markov) (2 of them) and a sinusoid (2 of them), and something more" in text


def compared(channel):
    """As if beside a simulation with the coefficients that five terms alone have."""
    coefficients = channel["coefficients_before"]
    channel["simulation"] = {"recording": "s.csv", "channel": "x", "coefficients": coefficients}


def test_a_simulation_is_told_what_is_wrong_with_it(explanation):
    compared(explanation["channels"][0])
    first, second, third = explanation["channels"][0]["mismatch"]
    first |= {"cause": "physics", "coefficient": None}
    second |= {"cause": "coefficient", "coefficient": "B"}
    third |= {"cause": "coefficient", "coefficient": "N"}
    text = told(explanation, 0)
    assert "B and N of the simulation are off, and physics is absent from the simulation." in text
    assert "p < 1e-12, physics absent from the simulation" in text
    assert "p = 3.1e-9, B of the simulation is off" in text
    assert "Compared with x of s.csv: B and N" in text
    # A line each for the five terms of the simulation.
    assert text.count(" simul. ") == 5
    first["absent_from"] = "recording"
    second["coefficient"] = "gauss_markov"
    text = told(explanation, 0)
    assert "N and exponentially correlated noise (Gauss-Markov) of the simulation are" in text
    assert "and the simulation has physics that the recording has not." in text


def test_only_coefficients_of_a_simulation_are_off(explanation):
    channel = explanation["channels"][2]
    compared(channel)
    channel["mismatch"] = explanation["channels"][0]["mismatch"][1:2]
    channel["mismatch"][0] |= {"cause": "coefficient", "coefficient": "K"}
    text = told(explanation, 2)
    assert "K of the simulation is off, and no physics is seen to be absent." in text


def test_of_many_mismatches_the_strongest_are_told(explanation):
    explanation["channels"][0]["mismatch"] *= 4
    assert "and 6 weaker ones, which --json tells" in told(explanation, 0)


def test_of_many_times_the_first_are_told(explanation):
    explanation["channels"][1]["effects"][0]["parameters"]["times"]["value"] = [
        *range(100, 1000, 100)
    ]
    assert "times 100, 200, 300, 400, 500, 600 and 3 more s" in told(explanation, 1)


def test_an_effect_of_a_later_version_goes_by_its_name(explanation):
    explanation["channels"][0]["effects"][1]["name"] = "cosmic_rays"
    assert "Cosmic rays: > 99.9 %" in told(explanation, 0)


def test_a_coefficient_appears_or_goes(explanation):
    channel = explanation["channels"][0]
    limit = {"resolved": False, "upper_limit_95": 1e-4}
    channel["coefficients_after"]["B"] |= limit
    channel["coefficients_before"]["K"] |= limit
    text = told(explanation, 0)
    assert "no longer resolved after < 1.0e-4 deg/s" in text
    assert "now resolved after 1.00e-4" in text


def test_what_is_not_known_is_said_so(explanation):
    channel = explanation["channels"][0]
    channel["mismatch"][0] |= {"ratio": None, "p_value": None}
    channel["false_alarm_probability"] = None
    score = channel["improvement"]["held_out_log_score"]
    score |= {"difference": None, "standard_error": None}
    channel["improvement"]["p_value_after"] = None
    text = told(explanation, 0)
    assert "13.019 Hz to 13.022 Hz (spectrum), p undefined" in text
    assert "A recording of five terms alone" not in text
    assert "after: not known" in text


def test_a_great_gain_is_counted_no_further(explanation):
    channel = explanation["channels"][0]
    channel["improvement"]["held_out_log_score"] |= {"difference": 4e5, "standard_error": 0.057}
    assert "over 100 standard errors" in " ".join(format_explanation(explanation).split())


@pytest.mark.parametrize("error", [21.0, 1e-6, None])
@pytest.mark.parametrize("difference", [0.004, -0.004])
def test_no_gain_is_not_counted(difference, error, explanation):
    channel = explanation["channels"][0]
    channel["improvement"]["held_out_log_score"] |= {
        "difference": difference,
        "standard_error": error,
    }
    text = told(explanation, 0)
    assert "after: as good as before" in text
    assert "worse" not in text
    assert "better by" not in text


def test_lines_are_short(explanation):
    lines = format_explanation(explanation).splitlines()
    assert max(map(len, lines)) <= 100
    assert lines[:2] == ["bench <b>3</b>.csv", "  - The time stamps repeat 2 times."]
    assert lines[-1] == "allanfit 0.1.0, checksum sha256:3f1c9a"


def test_strings_cannot_steer_the_terminal(explanation):
    red = "\x1b[31mred"
    channel = explanation["channels"][0]
    explanation["recording"] = channel["channel"] = channel["unit"] = red
    channel["effects"][0] |= {"name": red, "sentence": red}
    channel["mismatch"][0]["sentence"] = red
    channel["advice"] = channel["findings"] = [red]
    assert "\x1b" not in format_explanation(explanation)


def test_what_stands_for_nothing_is_not_told(explanation):
    """A bump of no height is told in words, and a rail by its side."""
    channel = explanation["channels"][0]
    empty = {"value": 0.0, "unit": "", "intervals": {}}
    bump = {"height": empty, "frequency": {"value": 25.0, "unit": "Hz", "intervals": {}}}
    rail = {"value": 0.38, "unit": "rad/s", "intervals": {}}
    clipped = {"limit": rail, "high": {**rail, "value": -0.38}}
    for name, parameters in (("bump", bump), ("saturation", clipped)):
        channel["effects"][0] |= {"name": name, "parameters": parameters}
        channel["effects"] = channel["effects"][:1]
        channel["verdict"] = "unexplained"
        text = told(explanation, 0)
        if name == "bump":
            assert "Something that has no name" in text
            assert "no effect of the catalogue explains how." in text
            assert "height" not in text
            assert "25 Hz" not in text
        else:
            assert "high -0.38" in text
            assert "limit 0.38" not in text
