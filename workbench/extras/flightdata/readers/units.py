"""Units by the names and prefixes of pint, and their conversion to SI.

A unit is a product of names with whole powers: "m/s^2", "deg/s", "kg*m**2", "mV", "meter per
second". Radians are a dimension here, so a rate in Hz is no angular velocity. Beside pint's names
there are those of data sheets: RPM, dps, rps, kph, mps, Nm; and g is a gravity, as no log has
grams: that of the workbench, as for logs of other formats.

The table is bounded, because mapping files come from others. pint evaluates what it reads, and
takes half a second to load.

Source: default_en.txt of pint 0.26, as facts; `tests/extras/flightdata/test_units.py` compares all
values.
"""

import math
import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import NamedTuple

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError
from workbench.plant.gravity import GRAVITY

STANDARD_GRAVITY = 9.80665
"""Of the unit g_0 [m/s^2]."""
MAX_UNIT_POWER = 9
BASE_UNITS = ("m", "s", "rad", "kg", "A", "K")
"""SI units that a unit is a product of."""
_WRITING_ORDER = ("kg", "rad", "m", "s", "A", "K")
"""The order in which they are written."""
UnitPowers = tuple[int, ...]


class PhysicalUnit(NamedTuple):
    """A unit.

    Attributes:
        factor: to SI.
        powers: of the `BASE_UNITS`.
        zero: its zero in SI, for temperatures.
    """

    factor: float
    powers: UnitPowers
    zero: float = 0.0

    @property
    def si(self) -> str:
        """The unit of SI of the same dimension, "1" without one."""
        for derived in _DERIVED_UNITS:
            if find_unit(derived).powers == self.powers:
                return derived
        over, under = [], []
        powers = dict(zip(BASE_UNITS, self.powers, strict=True))
        for base in _WRITING_ORDER:
            power = powers[base]
            text = base if abs(power) == 1 else f"{base}^{abs(power)}"
            (over if power > 0 else under).extend([text] if power else [])
        return "/".join([" ".join(over) or "1", *under])


_DERIVED_UNITS = ("Hz", "N", "Pa", "N m", "W", "C", "V", "ohm", "T", "m/s^2", "rad/s^2")
"""Units of SI that are written so, in place of the product of base units."""
_TURN_IN_RAD = 2.0 * math.pi
_DEGREE_IN_RAD = math.pi / 180.0
_METRES_PER_INCH = 0.0254
_KG_PER_POUND = 0.45359237
_PREFIXED_UNITS = (
    ("m meter metre", 1.0, "m"),
    ("s sec second", 1.0, "s"),
    ("rad radian", 1.0, "rad"),
    ("gram", 1e-3, "kg"),
    ("g_0 g0 g_n standard_gravity", STANDARD_GRAVITY, "m/s^2"),
    ("A amp ampere", 1.0, "A"),
    ("K kelvin", 1.0, "K"),
    ("Hz hertz", 1.0, "1/s"),
    ("N newton", 1.0, "kg m/s^2"),
    ("Pa pascal", 1.0, "kg/m/s^2"),
    ("bar", 1e5, "kg/m/s^2"),
    ("J joule", 1.0, "kg m^2/s^2"),
    ("W watt", 1.0, "kg m^2/s^3"),
    ("Wh watt_hour", 3600.0, "kg m^2/s^2"),
    ("C coulomb", 1.0, "A s"),
    ("Ah ampere_hour", 3600.0, "A s"),
    ("V volt", 1.0, "kg m^2/s^3/A"),
    ("ohm Ω", 1.0, "kg m^2/s^3/A^2"),
    ("T tesla", 1.0, "kg/s^2/A"),
    ("G gauss", 1e-4, "kg/s^2/A"),
)
"""Names, factors and units of SI of units that take prefixes."""
_PLAIN_UNITS = (
    ("1 dimensionless", 1.0, "1"),
    ("% percent", 1e-2, "1"),
    ("ppm", 1e-6, "1"),
    ("deg degree °", _DEGREE_IN_RAD, "rad"),
    ("cdeg", 1e-2 * _DEGREE_IN_RAD, "rad"),
    ("turn revolution cycle rev", _TURN_IN_RAD, "rad"),
    ("arcmin arcminute", _DEGREE_IN_RAD / 60.0, "rad"),
    ("arcsec arcsecond", _DEGREE_IN_RAD / 3600.0, "rad"),
    ("rpm revolutions_per_minute RPM", _TURN_IN_RAD / 60.0, "rad/s"),
    ("rps revolutions_per_second RPS", _TURN_IN_RAD, "rad/s"),
    ("dps", _DEGREE_IN_RAD, "rad/s"),
    ("min minute", 60.0, "s"),
    ("h hr hour", 3600.0, "s"),
    ("day", 86400.0, "s"),
    ("in inch inches", _METRES_PER_INCH, "m"),
    ("ft foot feet", 12.0 * _METRES_PER_INCH, "m"),
    ("yd yard", 36.0 * _METRES_PER_INCH, "m"),
    ("mi mile", 63360.0 * _METRES_PER_INCH, "m"),
    ("nmi nautical_mile", 1852.0, "m"),
    ("mps", 1.0, "m/s"),
    ("kph kmh", 1.0 / 3.6, "m/s"),
    ("mph", 63360.0 * _METRES_PER_INCH / 3600.0, "m/s"),
    ("kt knot", 1852.0 / 3600.0, "m/s"),
    ("fps", 12.0 * _METRES_PER_INCH, "m/s"),
    ("g", GRAVITY, "m/s^2"),
    ("mg", 1e-3 * GRAVITY, "m/s^2"),
    ("kg", 1.0, "kg"),
    ("lb pound", _KG_PER_POUND, "kg"),
    ("oz ounce", _KG_PER_POUND / 16.0, "kg"),
    ("lbf force_pound pound_force", _KG_PER_POUND * STANDARD_GRAVITY, "kg m/s^2"),
    ("Nm", 1.0, "kg m^2/s^2"),
    ("kgf force_kilogram kilogram_force", STANDARD_GRAVITY, "kg m/s^2"),
    ("gf force_gram gram_force", 1e-3 * STANDARD_GRAVITY, "kg m/s^2"),
    ("psi", _KG_PER_POUND * STANDARD_GRAVITY / _METRES_PER_INCH**2, "kg/m/s^2"),
    ("atm atmosphere", 101325.0, "kg/m/s^2"),
)
"""Names, factors and units of SI of units without prefixes."""
_TEMPERATURE_ZEROS = (
    ("degC celsius degree_Celsius °C", 1.0, 273.15),
    ("degF fahrenheit degree_Fahrenheit °F", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0),
)
"""Names, factors and zeros of temperatures, which stand alone."""
_PREFIXES = {
    name: scale
    for names, scale in (
        ("p pico", 1e-12),
        ("n nano", 1e-9),
        ("u µ μ micro", 1e-6),
        ("m milli", 1e-3),
        ("c centi", 1e-2),
        ("d deci", 1e-1),
        ("h hecto", 1e2),
        ("k kilo", 1e3),
        ("M mega", 1e6),
        ("G giga", 1e9),
    )
    for name in names.split()
}


def _base_powers(text: str) -> UnitPowers:
    """Return the powers of the `BASE_UNITS` in a product of these, as kg m/s^2."""
    powers = dict.fromkeys(BASE_UNITS, 0)
    for under, product in enumerate(text.split("/")):
        for word in product.removeprefix("1").split():
            base, _, power = word.partition("^")
            powers[base] += int(power or 1) * (-1 if under else 1)
    return tuple(powers.values())


def _all_units() -> Iterator[tuple[str, PhysicalUnit]]:
    """Yield all names with their units; of equal names the last one counts."""
    for names, factor, si in _PREFIXED_UNITS:
        for name in names.split():
            for prefix, scale in _PREFIXES.items():
                yield f"{prefix}{name}", PhysicalUnit(scale * factor, _base_powers(si))
    for names, factor, si in (*_PREFIXED_UNITS, *_PLAIN_UNITS):
        yield from ((name, PhysicalUnit(factor, _base_powers(si))) for name in names.split())


UNIT_BY_NAME = dict(_all_units())
"""All units that may be parts of a product, by name."""
TEMPERATURE_UNITS = {
    name: PhysicalUnit(factor, _base_powers("K"), zero)
    for names, factor, zero in _TEMPERATURE_ZEROS
    for name in names.split()
}
_UNIT_PART_PATTERN = re.compile(r"(\D.*?)\^?([+-]?\d{1,2})")
_UNIT_SPLIT_PATTERN = re.compile(r"\s*(/|\bper\b)\s*|\s*[*·⋅]\s*|\s+|\.(?=[^\W\d])")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def find_unit(text: str) -> PhysicalUnit:
    """Return a unit by its name.

    Raises:
        WorkbenchError: if it is not known; it names near ones.
    """
    plain = text.strip().translate(_SUPERSCRIPTS).replace("**", "^")
    if plain in TEMPERATURE_UNITS:
        return TEMPERATURE_UNITS[plain]
    parts = (
        [part for part in _UNIT_SPLIT_PATTERN.split(plain) if part]
        if len(plain) <= MAX_ECHO_CHARS
        else []
    )
    factor, powers, sign = 1.0, _base_powers("1"), 1
    for part in parts:
        if part in ("/", "per"):
            sign = -1
            continue
        unit, power = _unit_part(part)
        if unit is None or abs(power) > MAX_UNIT_POWER:
            raise _unknown(text, part)
        factor *= unit.factor ** (sign * power)
        powers = tuple(a + sign * power * b for a, b in zip(powers, unit.powers, strict=True))
        sign = 1
    if sign < 0 or not parts:
        raise _unknown(text, plain)
    return PhysicalUnit(factor, powers)


def _unit_part(part: str) -> tuple[PhysicalUnit | None, int]:
    """Return the unit and power of a part of a product; None if it is not known."""
    if unit := _unit_named(part):
        return unit, 1
    found = _UNIT_PART_PATTERN.fullmatch(part)
    return (_unit_named(found[1]), int(found[2])) if found else (None, 1)


def _unit_named(name: str) -> PhysicalUnit | None:
    """Return a unit by its name, also in the plural."""
    return UNIT_BY_NAME.get(name) or UNIT_BY_NAME.get(name.removesuffix("s"))


def _unknown(text: str, part: str) -> WorkbenchError:
    """Return the error for an unknown unit, with names near to its unknown part."""
    names = " ".join(
        each[0] for each in (*_PREFIXED_UNITS, *_PLAIN_UNITS, *_TEMPERATURE_ZEROS)
    ).split()
    plain = {each.casefold(): each for each in (*names, "ms", "us", "ns", "mm", "cm", "mV", "mA")}
    near = get_close_matches(part.casefold()[:MAX_ECHO_CHARS], plain, n=3)
    hint = f"did you mean {' or '.join(plain[each] for each in near)}?" if near else ""
    shown = text if len(text) <= MAX_ECHO_CHARS else f"{text[:MAX_ECHO_CHARS]}..."
    return WorkbenchError(
        f"unknown unit '{shown}': {hint or 'write one such as m/s^2, deg/s, rpm, ms or mV'}"
    )
