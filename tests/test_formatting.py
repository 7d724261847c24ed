import math
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from allanfit.formatting import (
    Reading,
    duration,
    p_value,
    printable,
    reading,
    significant,
    upper_limit,
)

magnitudes = st.floats(-14, 9).map(lambda exponent: 10.0**exponent)


@pytest.mark.parametrize(
    ("value", "interval", "expected"),
    [
        (0.3, (0.2981, 0.3022), ("0.3000", "[0.2981, 0.3022]")),
        (0.3, (0.2, 0.42), ("0.30", "[0.20, 0.42]")),
        (5e-3, (4.9e-3, 5.1e-3), ("0.00500", "[0.00490, 0.00510]")),
        (9.98e-4, (9.9e-4, 1.007e-3), ("0.0009980", "[0.0009900, 0.0010070]")),
        (1.2345e-7, (1.1e-7, 1.4e-7), ("1.23e-7", "[1.10e-7, 1.40e-7]")),
        (9.5e-5, (8.8e-5, 1.03e-4), ("9.50e-5", "[8.80e-5, 1.030e-4]")),
        (12345.0, (11111.0, 13456.0), ("12300", "[11100, 13500]")),
        (1234567.0, (1200000.0, 1300000.0), ("1.235e+6", "[1.200e+6, 1.300e+6]")),
        (-3.0, (-3.5, -2.5), ("-3.00", "[-3.50, -2.50]")),
        # A bound far below the width keeps digits of its own in place of a zero.
        (5.0, (0.04, 10.0), ("5.0", "[0.040, 10.0]")),
        (5.0, (1e-12, 10.0), ("5.0", "[1.0e-12, 10.0]")),
    ],
)
def test_the_width_of_the_interval_sets_the_digits(value, interval, expected):
    assert reading(value, interval, "u") == (*expected, "u")


@pytest.mark.parametrize("interval", [None, (None, None), (1.0, 1.0), (math.nan, 2.0), ()])
def test_without_an_interval_the_value_stands_alone(interval):
    assert reading(0.123456, interval, "u") == Reading("0.1235", "", "u")


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_no_number_is_undefined(value):
    assert str(reading(value, (0.0, 1.0), "u")) == "undefined u"
    assert significant(value) == "undefined"


@given(magnitudes, st.floats(0, 1), st.floats(1e-6, 10), st.booleans())
def test_rounding_never_inverts_nor_prints_a_zero(value, share, width, negative):
    sign = -1 if negative else 1
    low, high = sorted(
        (sign * value * (1 - min(share * width, 0.999999)), sign * value * (1 + width))
    )
    printed = reading(sign * value, (low, high), "u")
    middle = Decimal(printed.value)
    lower, upper = (Decimal(bound) for bound in printed.interval.strip("[]").split(", "))
    assert lower <= middle <= upper
    assert all((lower, middle, upper))
    half = (high - low) / 2
    # Two digits of half the width: no bound moves by more than a twentieth of it.
    for exact, shown in ((low, lower), (sign * value, middle), (high, upper)):
        assert abs(exact - float(shown)) <= 0.0501 * half + 1e-11 * value


@given(magnitudes)
def test_an_upper_limit_is_never_rounded_down(limit):
    shown = upper_limit(limit, "u").value
    assert shown.startswith("< ")
    assert limit * (1 - 1e-11) <= float(shown[2:]) <= limit * 1.1000001


def test_an_upper_limit_has_two_digits():
    assert str(upper_limit(1.101e-7, "rad")) == "< 1.2e-7 rad"
    assert str(upper_limit(0.1 + 0.2, "u")) == "< 0.30 u"
    assert str(upper_limit(None, "rad")) == "no limit rad"


@pytest.mark.parametrize(
    ("probability", "expected"),
    [(0.4123, "p = 0.41"), (1.0, "p = 1"), (3.21e-7, "p = 3.2e-7"), (0.0, "p < 1e-12")],
)
def test_p_values(probability, expected):
    assert p_value(probability) == expected


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [
        (0.5, "0.5 s"),
        (90, "90 s"),
        (600, "10 min"),
        (3600, "1 h"),
        (5400, "1.5 h"),
        (172800, "2 days"),
        (302400, "3.5 days"),
    ],
)
def test_durations(seconds, expected):
    assert duration(seconds) == expected


def test_numbers_without_interval_are_no_longer_than_they_must():
    assert significant(100.0, 6) == "100"
    assert significant(99.98766, 6) == "99.9877"
    assert significant(0.0) == "0"
    assert significant(2.5e-5) == "2.5e-5"


def test_control_characters_cannot_steer_the_terminal():
    assert printable("gyro\x1b[2J\n") == "gyro\ufffd[2J\ufffd"
