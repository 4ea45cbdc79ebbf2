"""Units of mapping files: against pint, and refused where they are not known."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.readers.units import (
    BASE_UNITS,
    TEMPERATURE_UNITS,
    UNIT_BY_NAME,
    find_unit,
)

UNKNOWN_TO_PINT = {"rev", "RPM", "RPS", "dps", "kmh"}
OTHER_IN_PINT = {
    "g": "a gram",
    "mg": "a milligram",
    "hbar": "Planck's constant",
    "Nm": "a yarn count",
}
"""Names of other things there; of a gauss, with any prefix, the dimension differs."""


def test_units_are_those_of_pint(case):
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    bases = [registry.Unit(each) for each in ("m", "s", "radian", "kg", "ampere", "kelvin")]
    assert len(bases) == len(BASE_UNITS)
    unknown = set()
    for name, unit in UNIT_BY_NAME.items():
        if name in OTHER_IN_PINT or name.endswith(("G", "gauss")):
            continue
        with case(name):
            try:
                theirs = registry.Quantity(1.0, name)
            except pint.UndefinedUnitError:
                unknown.add(name)
                continue
            product = registry.Quantity(1.0)
            for base, power in zip(bases, unit.powers, strict=True):
                product *= registry.Quantity(1.0, base) ** power
            assert theirs.dimensionality == product.dimensionality
            assert unit.factor == pytest.approx(theirs.to(product.units).magnitude, rel=1e-9)
    assert unknown == UNKNOWN_TO_PINT
    for name, unit in TEMPERATURE_UNITS.items():
        with case(name):
            theirs = [registry.Quantity(each, name).to("kelvin").magnitude for each in (0, 1)]
            assert [unit.zero, unit.zero + unit.factor] == pytest.approx(theirs)


@pytest.mark.parametrize(
    ("text", "factor", "si"),
    [
        ("m/s^2", 1.0, "m/s^2"),
        ("m/s²", 1.0, "m/s^2"),
        ("m s**-2", 1.0, "m/s^2"),
        ("cm/s/s", 1e-2, "m/s^2"),
        ("deg/s", 0.017453292519943295, "rad/s"),
        ("degrees per second", 0.017453292519943295, "rad/s"),
        ("rps", 6.283185307179586, "rad/s"),
        ("dps", 0.017453292519943295, "rad/s"),
        ("RPM", 0.10471975511965977, "rad/s"),
        ("rev/min", 0.10471975511965977, "rad/s"),
        ("msec", 1e-3, "s"),
        ("km/h", 1.0 / 3.6, "m/s"),
        ("knots", 0.5144444444444445, "m/s"),
        ("mG", 1e-7, "T"),
        ("kg*m^2", 1.0, "kg m^2"),
        ("%", 1e-2, "1"),
        ("1/min", 1.0 / 60.0, "Hz"),
    ],
)
def test_products_of_units(text, factor, si):
    unit = find_unit(text)
    assert (unit.factor, unit.si) == (pytest.approx(factor), si)


def test_a_rate_is_no_angular_velocity():
    assert find_unit("Hz").powers != find_unit("rad/s").powers == find_unit("rpm").powers


def test_unknown_units_are_refused_with_near_names(case):
    for text, near in (
        ("Volts", "volt"),
        ("degs/sek", "sec"),
        ("milisecond", "second"),
        ("m/", "did you mean m"),
        ("", "m/s^2"),
        ("counts", "write one"),
        ("m^99", "write one"),
        ("9**9**9**9", "write one"),
        ("s" * 10_000, "write one"),
        ("m/(s^2)", "unknown"),
    ):
        with case(text[:20]), pytest.raises(WorkbenchError, match="unknown unit") as found:
            find_unit(text)
        assert near in str(found.value) and len(str(found.value)) < 250
