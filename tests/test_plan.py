"""How long to record: against closed forms, the exact design, simulation, and bad wishes."""

import json
import math
import re
from inspect import unwrap

import jax
import numpy as np
import pytest
from scipy.signal import fftconvolve

import allanfit
from allanfit.cli import main
from allanfit.curves import design, statistics, unit_scale
from allanfit.identify._estimate import solve, target
from allanfit.plan import advice, parse_want
from allanfit.plan._errors import relative_errors
from allanfit.plan._record import counted_design
from allanfit.plan._want import checked_want

GYRO = {"N": 5e-3, "B": 1e-3, "K": 1e-4}


@pytest.mark.parametrize("sampling", ["point", "averaged"])
@pytest.mark.parametrize("samples", [256, 4097, 60_001])
def test_counted_design_is_the_one_that_is_fitted(samples, sampling):
    counted, exact = counted_design(samples, sampling), design((samples,), sampling)
    np.testing.assert_allclose(counted.ordinates, exact.ordinates, rtol=1e-12)
    np.testing.assert_allclose(counted.density, exact.density, rtol=2e-4)
    np.testing.assert_allclose(counted.ramp, exact.ramp[0], rtol=2e-4)
    np.testing.assert_allclose(counted.ramp_variance, exact.ramp_variance[0], rtol=2e-4)


def test_a_long_record_counts_every_ordinate():
    # Float64 counts to 1e10 exactly: order 1 goes with the ramp, order 0 with the mean.
    assert counted_design(10**10, "point").ordinates.sum() == 10**10 - 2


def test_white_noise_alone():
    # n samples tell white noise to 1/sqrt(2 n), quantization noise taken for absent; B and K, which
    # are sought in every record, take next to nothing from it in so long a one.
    samples = 10**8
    expected = 1 / math.sqrt(2 * samples)
    assert relative_errors({"N": 5e-3}, 50.0, samples, "point")["N"] == pytest.approx(
        expected, rel=0.02
    )


@pytest.mark.parametrize("samples", [10_000, 10**9])
def test_ramp_against_white_noise_and_against_a_walk(samples):
    rate_hz, ramp = 20.0, 1e-5
    duration = samples / rate_hz
    # A straight line in white noise of variance N^2 rate: slope variance 12 N^2/T^3.
    white = relative_errors({"N": 5e-3, "R": ramp}, rate_hz, samples, "point")["R"]
    assert white * ramp == pytest.approx(math.sqrt(12 / duration**3) * 5e-3, rel=1e-3)
    # In a walk, ends tell all: K^2/T. The cosine modes beyond 64 hold 2/(pi^2 32) of that.
    walk = relative_errors({"K": 5e-3, "R": ramp}, rate_hz, samples, "point")["R"]
    assert walk * ramp == pytest.approx(5e-3 / math.sqrt(duration), rel=0.01)


def test_simulated_records_scatter_as_planned():
    # White noise, its differences, its sums and its half sums (Kasdin 1995), drawn by NumPy.
    rate_hz, records = 10.0, 300
    coefficients = {"Q": 1.5e-3, "N": 5e-3, "B": 1.5e-2, "K": 1e-2}
    planned = allanfit.plan(coefficients, rate_hz, {"K": 0.14})
    assert planned.duration_s is not None
    samples = round(planned.duration_s * rate_hz)
    normal = np.random.default_rng(5).standard_normal
    data = 5e-3 * math.sqrt(rate_hz) * normal((records, samples))
    data += np.cumsum(1e-2 / math.sqrt(rate_hz) * normal((records, samples)), axis=1)
    data += 1.5e-3 * rate_hz * np.diff(normal((records, samples + 1)), axis=1)
    order = np.arange(1, 4 * samples)
    half_sum = np.cumprod(np.append(1.0, (order - 0.5) / order))
    flicker = fftconvolve(normal((records, 4 * samples)), half_sum[None], axes=1)
    data += 1.5e-2 * flicker[:, 3 * samples : 4 * samples]
    layout = design((samples,))

    def power(x):
        data = target(statistics((x,), layout), layout)
        return solve(data).power * data.unit**2

    solved = jax.jit(jax.vmap(power))(data)
    found = np.sqrt(np.asarray(solved)) * np.asarray(unit_scale(1 / rate_hz))[:4]
    for symbol, true in coefficients.items():
        error = np.sqrt(np.mean((found[:, "QNBK".index(symbol)] / true - 1) ** 2))
        ratio = error / planned.relative_standard_error[symbol]
        # Within 15 % is what is promised, and the standard error of the ratio is 0.04.
        assert 0.8 < ratio < 1.2


@pytest.mark.parametrize("rate_hz", [1.0, 50.0, 10_000.0])
@pytest.mark.parametrize("symbol", ["N", "B", "K", "R"])
def test_the_planned_length_is_just_enough(symbol, rate_hz):
    sensor = {"Q": 2e-3 / math.sqrt(rate_hz), "N": 5e-3, "B": 2e-3, "K": 2e-4, "R": 1e-6}
    planned = allanfit.plan(sensor, rate_hz, {symbol: 0.08})
    assert planned.set_by == symbol
    assert planned.duration_s == planned.durations_s[symbol] == planned.at_s
    found = planned.relative_standard_error
    assert set(found) == set(sensor)
    samples = round(planned.at_s * rate_hz)
    if samples == 256:  # the fewest that a fit takes may tell more
        assert found[symbol] < 0.08
        return
    assert found[symbol] == pytest.approx(0.08, rel=2e-3)
    shorter = relative_errors(sensor, rate_hz, round(0.97 * samples), "point")
    assert shorter[symbol] > 0.08


def test_the_longest_wish_sets_the_length_of_months_at_a_kilohertz():
    planned = allanfit.plan(GYRO | {"K": 2e-6}, 1000.0, {"N": 0.01, "B": 0.05, "K": 0.25})
    assert planned.set_by == "K"
    assert planned.duration_s == planned.durations_s["K"]
    assert planned.duration_s is not None
    assert planned.duration_s > 60 * 86400
    assert planned.durations_s["N"] < 60 < planned.durations_s["B"]
    assert planned.relative_standard_error["N"] < 1e-4


def test_what_takes_centuries_is_told_in_words():
    planned = allanfit.plan(GYRO | {"K": 1e-10}, 100.0, {"B": 0.1, "K": 0.3})
    assert planned.durations_s["K"] is None
    assert planned.duration_s is None
    assert planned.set_by is None
    assert planned.at_s == planned.durations_s["B"]
    assert planned.notes[0] == "K to 30 % is out of reach: it would take more than 10 years."
    json.dumps(planned.to_dict(), allow_nan=False)


def test_a_percent_sign_or_a_fraction():
    assert parse_want("N=1%, B = 10 %,K=0.3") == {"N": 0.01, "B": 0.1, "K": 0.3}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "list such as"),
        ("N", "'N' is no part"),
        ("N=", "no part"),
        ("N=1%,", "no part"),
        ("N=0%", "above 0"),
        ("N=-1%", "above 0"),
        ("N=100%", "below 100 %"),
        ("N=1", "no percent sign; write N=1%"),
        ("N=abc", "'abc', which is no number"),
        ("N=nan%", "no number"),
        ("X=1%", "'X' is wanted"),
        ("N=1%,N=2%", "N twice"),
        ("Q=1%", "none that is resolved"),
    ],
)
def test_a_bad_wish_is_one_sentence(text, message, tmp_path, capsys):
    source = tmp_path / "c.yaml"
    source.write_text("N: 0.005\nQ: 0\n")
    assert main(["plan", str(source), "--rate", "50", "--want", text]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, 1e-9, 1e9, math.nan, math.inf])
def test_a_rate_out_of_range(rate_hz):
    with pytest.raises(ValueError, match="The rate must be from"):
        allanfit.plan(GYRO, rate_hz, {"N": 0.01})


@pytest.mark.parametrize(
    ("coefficients", "want", "message"),
    [
        (GYRO, {}, "Nothing is wanted"),
        (GYRO, {"Q": 0.1}, "absent from the coefficients"),
        ({"N": 1.0, "Z": 1.0}, {"N": 0.1}, "Unknown coefficient 'Z'"),
        ({"N": -1.0}, {"N": 0.1}, "zero or more"),
        ({"N": math.nan}, {"N": 0.1}, "zero or more"),
        # Their squares, or those of their squares, are zero or infinite.
        ({"N": 1e-3, "B": 1e-170}, {"B": 0.1}, "B must be zero, or from 1e-40 to 1e.40; got 1e-17"),
        ({"N": 1e-3, "K": 1e90}, {"N": 0.1}, "K must be zero, or from 1e-40 to 1e.40; got 1e.90"),
        ({"R": 1.0}, {"R": 0.1}, "needs noise"),
        ({"N": 0.0}, {"N": 0.1}, "needs noise"),
    ],
)
def test_coefficients_that_allow_no_plan(coefficients, want, message):
    with pytest.raises(ValueError, match=message):
        allanfit.plan(coefficients, 50.0, want)


def test_a_wish_in_words_is_for_the_command_line():
    # Past the check of types that only tests have.
    with pytest.raises(ValueError, match=r"want is a mapping of symbols .*; got 'B=10%'"):
        unwrap(checked_want)("B=10%")


def fit_document(**resolved_by_channel):
    """A fit JSON with the gyro's values in every channel; which are resolved is given."""
    return {
        "schema": "allanfit.fit/1",
        "channels": [
            {
                "channel": name,
                "unit": "deg/s",
                "coefficients": {
                    symbol: {"value": GYRO.get(symbol, 1e-9), "resolved": symbol in resolved}
                    for symbol in "QNBKR"
                },
            }
            for name, resolved in resolved_by_channel.items()
        ],
    }


def test_channels_of_a_fit_in_table_and_json(tmp_path, capsys):
    source, target = tmp_path / "fit.json", tmp_path / "plan.json"
    source.write_text(json.dumps(fit_document(gyro_x="NB", gyro_y="NBK")))
    arguments = ["plan", str(source), "--rate", "50", "--want", "N=1%,B=10%"]
    assert main([*arguments, "--json", str(target)]) == 0
    out = capsys.readouterr().out
    document = json.loads(target.read_text())
    x, y = document["channels"]
    assert document["schema"] == "allanfit.plan/1"
    # An unresolved K is absent, which is another sensor; and one knows no more for knowing less.
    assert (
        x["durations_s"]["B"] == allanfit.plan({"N": 5e-3, "B": 1e-3}, 50.0, {"B": 0.1}).duration_s
    )
    assert y["duration_s"] == document["duration_s"] > x["duration_s"]
    assert (x["set_by"], y["set_by"]) == ("B", "B")
    assert "channel  N to 1 %  B to 10 %  record" in out
    assert "half-widths of 68 % intervals" in out
    assert "gyro_x: Zero, unresolved or not given, and so taken as absent: Q, K and R." in out
    assert main([*arguments, "--json", "-", "--channel", "gyro_x"]) == 0
    assert json.loads(capsys.readouterr().out)["channels"] == [x]


def test_a_term_that_one_channel_lacks(tmp_path, capsys):
    source = tmp_path / "fit.json"
    source.write_text(json.dumps(fit_document(gyro_x="NB", gyro_y="NBK")))
    arguments = ["plan", str(source), "--rate", "50", "--want", "K=20%"]
    assert main([*arguments, "--channel", "gyro_x"]) == 1
    assert "gyro_x of fit.json has none that is resolved" in capsys.readouterr().err
    assert main([*arguments, "--json", "-", "--channel", "gyro_y"]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert alone["left_out"] == []
    # The others are planned as they would be without it, and it is said.
    why = "gyro_x is left out: it has no K that is resolved and above zero."
    assert main([*arguments, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == alone | {"left_out": [why]}
    assert main(arguments) == 0
    out = capsys.readouterr().out
    assert why in out
    assert "gyro_x" not in out.replace(why, "")


def test_sampling_comes_from_the_file_unless_given(tmp_path, capsys):
    source = tmp_path / "c.yaml"
    source.write_text("N: 1.0e-4\nB: 1.0e-3\nsampling: averaged\n")
    found = {}
    for options in ([], ["--sampling", "point"]):
        arguments = ["plan", str(source), "--rate", "50", "--want", "B=5%", "--json", "-"]
        assert main([*arguments, *options]) == 0
        channel = json.loads(capsys.readouterr().out)["channels"][0]
        found[channel["sampling"]] = channel["duration_s"]
    assert set(found) == {"averaged", "point"}
    assert found["averaged"] != found["point"]


def test_advice_halves_the_interval():
    resolved = dict.fromkeys("NBK", True) | {"Q": False, "R": False}
    (b, k) = advice(GYRO | {"Q": 1e-9}, resolved, 10800.0, 50.0)
    assert b.startswith("To halve the interval of B record ")
    assert k.startswith("To halve the interval of K record ")
    more, total = (float(number) for number in re.findall(r"([\d.]+) h", k))
    assert total == pytest.approx(more + 3.0, abs=0.06)
    before, after = (
        relative_errors(GYRO, 50.0, round(hours * 3600 * 50), "point")["K"] for hours in (3, total)
    )
    assert after == pytest.approx(before / 2, rel=0.01)


def test_advice_is_silent_about_what_is_known_or_not_seen():
    nothing = dict.fromkeys("QNBKR", False)
    assert advice(GYRO, nothing, 7200.0, 50.0) == ()
    assert advice(GYRO, nothing | {"N": True}, 7200.0, 50.0) == ()
    # The fit's own intervals come before expected ones.
    wide = {"N": (4.0e-3, 6.0e-3)}
    (sentence,) = advice(GYRO, nothing | {"N": True}, 7200.0, 50.0, intervals=wide)
    assert "interval of N" in sentence


def test_advice_knows_when_it_is_hopeless():
    eight_years = 2.5e8
    assert advice({"N": 5e-3, "K": 1e-9}, {"N": True, "K": True}, eight_years, 50.0) == (
        "No record of less than 10 years would halve the interval of K.",
    )


@pytest.mark.parametrize("rate_hz", [1e-6, 1e6])
def test_coefficients_at_the_ends_of_what_is_allowed_have_errors(rate_hz):
    found = allanfit.plan({"N": 1e-40, "K": 1e40}, rate_hz, {"K": 0.1})
    assert all(map(math.isfinite, found.relative_standard_error.values()))
