import pytest

from allanfit.report import format_text
from allanfit.report._rows import coefficient_rows

GYRO = """\
gyro_x [deg/s]
  gyro, 100 Hz, 360000 samples, 1 h, mean 0.01235 deg/s, point samples
  Q  quantization              < 1.0e-5 deg/s*s
     not resolved              < 0.036 arcsec
  N  angle random walk         0.005000 [0.004988, 0.005012] deg/s/sqrt(Hz)
     resolved, 0.01 s to 49 s  0.30000  [0.29928, 0.30072]   deg/sqrt(h)
  B  bias instability          0.00100  [0.00079, 0.00121]   deg/s
     resolved, 58 s to 120 s   3.60     [2.84, 4.36]         deg/h
  K  rate random walk          1.00e-4  [6.6e-5, 1.34e-4]    deg/s/sqrt(s)
     resolved, 140 s to 660 s  21.6     [14.3, 28.9]         deg/h/sqrt(h)
  R  rate ramp                 < 1.5e-7 deg/s/s
     not resolved              < 2.0 deg/h^2
  fit      the five terms agree with both curves (p = 0.41)
  sampler  emcee, 8000 draws, R-hat at most 1.007, effective sample size at
           least 1730, acceptance 0.43: converged
  slopes   N 0.0051, B 0.00163, K 1.42e-4: the classical reading of the curve,
           biased
  longer   To halve the interval of K record 6.2 h more (7.2 h in all).
  - The code width is 0.8 of the noise; see `output_rounding`.
"""


def test_a_gyro_is_printed_so(document):
    assert GYRO in format_text(document)


def test_a_curve_without_a_slope_to_read_says_so(document):
    channel = document["channels"][0]
    channel["slope_reading"] = dict.fromkeys("QNBKR")
    assert "slopes   none: the classical reading" in format_text(document)


def test_an_accelerometer_has_two_field_units_for_velocity_random_walk(document):
    text = format_text(document)
    assert "0.07061   [0.07044, 0.07078]     m/s/sqrt(h)\n" in text
    assert "120.00    [119.71, 120.29]       ug/sqrt(Hz)\n" in text


def test_a_fit_that_fails_says_so(document):
    text = " ".join(format_text(document).split())
    assert "do not explain the curves (p = 3.2e-7): run `allanfit explain` on the" in text
    assert "intervals from the fast posterior, not sampled" in text
    assert "warning the least squares stopped after 200 steps" in text


def test_a_sampler_that_did_not_converge_says_so(document):
    posterior = document["channels"][0]["posterior"]
    posterior["converged"] = False
    posterior["r_hat"]["B"] = None
    text = " ".join(format_text(document).split())
    assert "acceptance 0.43: not converged, do not trust the intervals" in text


def test_a_resolved_zero_is_a_limit(document):
    document["channels"][0]["coefficients"]["N"] |= {"value": 0.0, "resolved": True}
    assert "  N  angle random walk         < 0.0051 deg/s/sqrt(Hz)\n" in format_text(document)


def test_what_is_undefined_is_said(document):
    channel = document["channels"][0]
    channel["goodness_of_fit"] = {"p_value": None, "consistent": True}
    channel["coefficients"]["Q"] |= {"upper_limit_95": None, "intervals": {"0.95": [0.0, None]}}
    for values in channel["curves"]["allan"]["terms"].values():
        values[:] = [None] * len(values)
    text = format_text(document)
    assert "the goodness of fit could not be judged" in text
    assert "no limit deg/s*s" in text
    assert "     resolved      " in text


def test_advice_is_given_where_there_is_any(document):
    text = format_text(document)
    assert "  longer   To halve the interval of K record 6.2 h more (7.2 h in all).\n" in text
    assert text.count("  longer ") == 1


def test_the_text_names_file_findings_version_and_checksum(document):
    lines = format_text(document).splitlines()
    assert lines[:2] == [
        "bench <b>3</b>.csv",
        "  - The time stamps repeat 2 times; <img src=x> was in the header.",
    ]
    assert lines[-1] == "allanfit 0.1.0, checksum sha256:3f1c9a"
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("key", ["recording", "channel"])
def test_names_cannot_steer_the_terminal(document, key):
    (document if key == "recording" else document["channels"][0])[key] = "\x1b[31mred"
    assert "\x1b" not in format_text(document)


def test_a_term_that_is_never_the_largest_says_so(document):
    channel = document["channels"][0]
    terms = channel["curves"]["allan"]["terms"]
    terms["B"] = [min(each) / 2 for each in zip(terms["N"], terms["K"], strict=True)]
    channel["coefficients"]["B"]["resolved"] = True
    states = {row.symbol: row.state for row in coefficient_rows(channel)}
    assert states["B"] == "resolved, never the largest"
    # Earlier documents have no terms, from which nothing is told.
    del channel["curves"]["allan"]["terms"]
    assert {row.state for row in coefficient_rows(channel)} <= {"resolved", "not resolved"}
