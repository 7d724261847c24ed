import re
from pathlib import Path

import pint
import pytest

from allanfit.coefficient_units import UNITS, field_units, measured_by, si_unit
from allanfit.report._units import squared_per_hertz, typeset

REGISTRY = pint.UnitRegistry()
# Names that pint spells otherwise, or gives another meaning (g is its gram).
PINT_NAMES = {
    "g": "g_0",
    "mg": "1e-3 * g_0",
    "ug": "1e-6 * g_0",
    "ug/s": "1e-6 * g_0 / s",
    "ug/sqrt(s)": "1e-6 * g_0 / s**0.5",
    "ug/sqrt(Hz)": "1e-6 * g_0 / Hz**0.5",
    "deg/h/sqrt(h)": "deg/hour**1.5",
    "deg/h^2": "deg/hour**2",
    "deg/h": "deg/hour",
    "deg/sqrt(h)": "deg/hour**0.5",
    "m/s/sqrt(h)": "m/s/hour**0.5",
    "deg/min": "deg/minute",
    "rad/h": "rad/hour",
    "mdeg/s": "1e-3 * deg/s",
    "rad/s/sqrt(Hz)": "rad/s/Hz**0.5",
    "m/s^2/sqrt(Hz)": "m/s**2/Hz**0.5",
}
CHANNELS = {
    "gyro": ("rad/s", "mrad/s", "rad/h", "deg/s", "mdeg/s", "deg/min", "deg/h", "rpm"),
    "accelerometer": ("m/s^2", "cm/s^2", "mm/s^2", "g", "mg", "ug"),
}
POWERS_OF_SECOND = {"Q": "* s", "N": "/ Hz**0.5", "B": "", "K": "/ s**0.5", "R": "/ s"}


def in_pint(unit: str) -> str:
    return PINT_NAMES.get(unit, unit)


@pytest.mark.parametrize("symbol", POWERS_OF_SECOND)
@pytest.mark.parametrize(
    ("kind", "unit"), [(kind, unit) for kind, units in CHANNELS.items() for unit in units]
)
def test_conversions_agree_with_pint(kind, unit, symbol):
    coefficient = REGISTRY.Quantity(f"1 * ({in_pint(unit)}) {POWERS_OF_SECOND[symbol]}")
    conversions = [*field_units(kind, unit, symbol), si_unit(kind, unit, symbol)]
    for conversion in conversions:
        name = in_pint(conversion.unit).replace("sqrt(s)", "s**0.5").replace("sqrt(Hz)", "Hz**0.5")
        target = REGISTRY.Quantity(f"1 * {name}")
        ratio = (coefficient / target).to_base_units()
        assert ratio.dimensionless
        assert conversion.factor == pytest.approx(ratio.magnitude, rel=1e-12)


def test_a_gyro_of_the_catalogue():
    (density,) = field_units("gyro", "deg/s", "N")
    assert (density.unit, 5e-3 * density.factor) == ("deg/sqrt(h)", pytest.approx(0.3))
    (instability,) = field_units("gyro", "deg/s", "B")
    assert (instability.unit, 1e-3 * instability.factor) == ("deg/h", pytest.approx(3.6))


@pytest.mark.parametrize("spelling", ["dps", "°/s", "deg/sec", "deg / s"])
def test_other_spellings_are_known(spelling):
    assert field_units("gyro", spelling, "B") == field_units("gyro", "deg/s", "B")


@pytest.mark.parametrize("spelling", ["m/s2", "m/s²", "m/s**2"])
def test_other_spellings_of_an_acceleration_are_known(spelling):
    assert field_units("accelerometer", spelling, "N") == field_units("accelerometer", "m/s^2", "N")


def test_a_unit_in_which_nothing_changes_is_left_out():
    assert field_units("gyro", "deg/h", "B") == []
    assert field_units("accelerometer", "ug", "B") == []


@pytest.mark.parametrize(("kind", "unit"), [("other", "deg/s"), ("gyro", "counts"), ("gyro", "")])
def test_an_unknown_unit_has_no_conversion(kind, unit):
    assert field_units(kind, unit, "N") == []
    assert si_unit(kind, unit, "N") is None


@pytest.mark.parametrize("spelling", ["sqrt", "(", "deg)", "Hz", "deg/h/h/h", "ppm"])
def test_what_measures_no_coefficient_is_told(spelling):
    assert measured_by(spelling) is None


def test_no_two_coefficients_have_one_dimension():
    for kind, units in UNITS.items():
        for symbol, known in units.items():
            for name in (known.si, *known.field):
                assert measured_by(name)[:2] == (kind, symbol), name


def test_the_table_of_the_docs_is_that_of_the_code():
    page = Path(__file__).parents[2].joinpath("docs", "units.md").read_text()
    rows = re.findall(r"^\| ([QNBKR]) \|(.*)\|$", page, re.MULTILINE)
    assert [symbol for symbol, _ in rows] == list("QNBKR")
    for symbol, row in rows:
        cells = [cell.strip() for cell in row.split("|")]
        for kind, (si, factors, names) in zip(UNITS, (cells[:3], cells[3:]), strict=True):
            units = UNITS[kind][symbol]
            assert si == typeset(units.si)
            assert names.split("; ") == [typeset(name) for name in units.field]
            for factor, name in zip(factors.split("; "), units.field, strict=True):
                expected = REGISTRY.Quantity(
                    f"1 * {in_pint(units.si)}".replace("sqrt(s)", "s**0.5")
                )
                target = f"1 * {in_pint(name)}".replace("sqrt(s)", "s**0.5")
                ratio = (expected / REGISTRY.Quantity(target)).to_base_units().magnitude
                assert float(factor) == pytest.approx(ratio, rel=5e-6), (kind, symbol)


def test_units_of_a_density():
    assert squared_per_hertz("g") == "g^2/Hz"
    assert squared_per_hertz("deg/s") == "(deg/s)^2/Hz"
    assert squared_per_hertz("") == "1/Hz"


def test_units_in_print():
    assert typeset("deg/h/sqrt(h)") == "deg/h/√h"
    assert typeset("ug/sqrt(Hz)") == "\N{MICRO SIGN}g/√Hz"
    assert typeset("(m/s^2)^2/Hz") == "(m/s²)²/Hz"
