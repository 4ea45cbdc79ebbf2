"""Units by the names and prefixes of pint, and their conversion to SI.

A unit is a product of names with whole powers: "m/s^2", "deg/s", "kg*m**2", "mV", "meter per
second". Radians are a dimension here, so a rate in Hz is no angular velocity. Beside pint's names
there are those of data sheets: RPM, dps, rps, kph, mps, Nm; and g is a gravity, as no log has
grams: that of the workbench, as for logs of other formats.

The table is bounded, because mapping files come from others. pint evaluates what it reads, and
takes half a second to load.

Source: default_en.txt of pint 0.26, as facts; `tests/logs/test_units.py` compares all values.
"""

import math
import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import NamedTuple

from workbench.common.errors import LONGEST_ECHO, WorkbenchError
from workbench.plant.gravity import GRAVITY

STANDARD_GRAVITY = 9.80665
"""Of the unit g_0 [m/s^2]."""
LARGEST_POWER = 9
BASES = ("m", "s", "rad", "kg", "A", "K")
"""SI units that a unit is a product of."""
_WRITTEN = ("kg", "rad", "m", "s", "A", "K")
"""The order in which they are written."""
Powers = tuple[int, ...]


class Unit(NamedTuple):
    """A unit.

    Attributes:
        factor: to SI.
        powers: of the `BASES`.
        zero: its zero in SI, for temperatures.
    """

    factor: float
    powers: Powers
    zero: float = 0.0

    @property
    def si(self) -> str:
        """The unit of SI of the same dimension, "1" without one."""
        if self.powers in _DERIVED:
            return _DERIVED[self.powers]
        over, under = [], []
        powers = dict(zip(BASES, self.powers, strict=True))
        for base in _WRITTEN:
            power = powers[base]
            text = base if abs(power) == 1 else f"{base}^{abs(power)}"
            (over if power > 0 else under).extend([text] if power else [])
        return "/".join([" ".join(over) or "1", *under])


_NONE, _LENGTH, _TIME, _ANGLE = (0,) * 6, (1, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0)
_RATE, _TURNS, _SPEED = (0, -1, 0, 0, 0, 0), (0, -1, 1, 0, 0, 0), (1, -1, 0, 0, 0, 0)
_ACCELERATION, _MASS, _FORCE = (1, -2, 0, 0, 0, 0), (0, 0, 0, 1, 0, 0), (1, -2, 0, 1, 0, 0)
_PRESSURE, _ENERGY, _POWER = (-1, -2, 0, 1, 0, 0), (2, -2, 0, 1, 0, 0), (2, -3, 0, 1, 0, 0)
_CURRENT, _CHARGE, _VOLTAGE = (0, 0, 0, 0, 1, 0), (0, 1, 0, 0, 1, 0), (2, -3, 0, 1, -1, 0)
_RESISTANCE, _FIELD, _KELVIN = (2, -3, 0, 1, -2, 0), (0, -2, 0, 1, -1, 0), (0, 0, 0, 0, 0, 1)
_DERIVED: dict[Powers, str] = {
    _RATE: "Hz",
    _FORCE: "N",
    _PRESSURE: "Pa",
    _ENERGY: "N m",
    _POWER: "W",
    _CHARGE: "C",
    _VOLTAGE: "V",
    _RESISTANCE: "ohm",
    _FIELD: "T",
    _ACCELERATION: "m/s^2",
    (0, -2, 1, 0, 0, 0): "rad/s^2",
}
_TURN = 2.0 * math.pi
_DEGREE = math.pi / 180.0
_INCH = 0.0254
_POUND = 0.45359237
_PREFIXED = (
    ("m meter metre", 1.0, _LENGTH),
    ("s sec second", 1.0, _TIME),
    ("rad radian", 1.0, _ANGLE),
    ("gram", 1e-3, _MASS),
    ("g_0 g0 g_n standard_gravity", STANDARD_GRAVITY, _ACCELERATION),
    ("A amp ampere", 1.0, _CURRENT),
    ("K kelvin", 1.0, _KELVIN),
    ("Hz hertz", 1.0, _RATE),
    ("N newton", 1.0, _FORCE),
    ("Pa pascal", 1.0, _PRESSURE),
    ("bar", 1e5, _PRESSURE),
    ("J joule", 1.0, _ENERGY),
    ("W watt", 1.0, _POWER),
    ("Wh watt_hour", 3600.0, _ENERGY),
    ("C coulomb", 1.0, _CHARGE),
    ("Ah ampere_hour", 3600.0, _CHARGE),
    ("V volt", 1.0, _VOLTAGE),
    ("ohm Ω", 1.0, _RESISTANCE),
    ("T tesla", 1.0, _FIELD),
    ("G gauss", 1e-4, _FIELD),
)
"""Names, factors and powers of units that take prefixes."""
_PLAIN = (
    ("1 dimensionless", 1.0, _NONE),
    ("% percent", 1e-2, _NONE),
    ("ppm", 1e-6, _NONE),
    ("deg degree °", _DEGREE, _ANGLE),
    ("cdeg", 1e-2 * _DEGREE, _ANGLE),
    ("turn revolution cycle rev", _TURN, _ANGLE),
    ("arcmin arcminute", _DEGREE / 60.0, _ANGLE),
    ("arcsec arcsecond", _DEGREE / 3600.0, _ANGLE),
    ("rpm revolutions_per_minute RPM", _TURN / 60.0, _TURNS),
    ("rps revolutions_per_second RPS", _TURN, _TURNS),
    ("dps", _DEGREE, _TURNS),
    ("min minute", 60.0, _TIME),
    ("h hr hour", 3600.0, _TIME),
    ("day", 86400.0, _TIME),
    ("in inch inches", _INCH, _LENGTH),
    ("ft foot feet", 12.0 * _INCH, _LENGTH),
    ("yd yard", 36.0 * _INCH, _LENGTH),
    ("mi mile", 63360.0 * _INCH, _LENGTH),
    ("nmi nautical_mile", 1852.0, _LENGTH),
    ("mps", 1.0, _SPEED),
    ("kph kmh", 1.0 / 3.6, _SPEED),
    ("mph", 63360.0 * _INCH / 3600.0, _SPEED),
    ("kt knot", 1852.0 / 3600.0, _SPEED),
    ("fps", 12.0 * _INCH, _SPEED),
    ("g", GRAVITY, _ACCELERATION),
    ("mg", 1e-3 * GRAVITY, _ACCELERATION),
    ("kg", 1.0, _MASS),
    ("lb pound", _POUND, _MASS),
    ("oz ounce", _POUND / 16.0, _MASS),
    ("lbf force_pound pound_force", _POUND * STANDARD_GRAVITY, _FORCE),
    ("Nm", 1.0, _ENERGY),
    ("kgf force_kilogram kilogram_force", STANDARD_GRAVITY, _FORCE),
    ("gf force_gram gram_force", 1e-3 * STANDARD_GRAVITY, _FORCE),
    ("psi", _POUND * STANDARD_GRAVITY / _INCH**2, _PRESSURE),
    ("atm atmosphere", 101325.0, _PRESSURE),
)
"""Names, factors and powers of units without prefixes."""
_ZEROS = (
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


def _all_units() -> Iterator[tuple[str, Unit]]:
    """Yield all names with their units; of equal names the last one counts."""
    for names, factor, powers in _PREFIXED:
        for name in names.split():
            for prefix, scale in _PREFIXES.items():
                yield f"{prefix}{name}", Unit(scale * factor, powers)
    for names, factor, powers in (*_PREFIXED, *_PLAIN):
        yield from ((name, Unit(factor, powers)) for name in names.split())


UNITS = dict(_all_units())
"""All units that may be parts of a product, by name."""
TEMPERATURES = {
    name: Unit(factor, _KELVIN, zero) for names, factor, zero in _ZEROS for name in names.split()
}
_PART = re.compile(r"(\D.*?)\^?([+-]?\d{1,2})")
_SPLIT = re.compile(r"\s*(/|\bper\b)\s*|\s*[*·⋅]\s*|\s+|\.(?=[^\W\d])")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def find_unit(text: str) -> Unit:
    """Return a unit by its name.

    Raises:
        WorkbenchError: if it is not known; it names near ones.
    """
    plain = text.strip().translate(_SUPERSCRIPTS).replace("**", "^")
    if plain in TEMPERATURES:
        return TEMPERATURES[plain]
    parts = [part for part in _SPLIT.split(plain) if part] if len(plain) <= LONGEST_ECHO else []
    factor, powers, sign = 1.0, _NONE, 1
    for part in parts:
        if part in ("/", "per"):
            sign = -1
            continue
        unit, power = _part(part)
        if unit is None or abs(power) > LARGEST_POWER:
            raise _unknown(text, part)
        factor *= unit.factor ** (sign * power)
        powers = tuple(a + sign * power * b for a, b in zip(powers, unit.powers, strict=True))
        sign = 1
    if sign < 0 or not parts:
        raise _unknown(text, plain)
    return Unit(factor, powers)


def _part(part: str) -> tuple[Unit | None, int]:
    """Return the unit and power of a part of a product; None if it is not known."""
    if unit := _named(part):
        return unit, 1
    found = _PART.fullmatch(part)
    return (_named(found[1]), int(found[2])) if found else (None, 1)


def _named(name: str) -> Unit | None:
    """Return a unit by its name, also in the plural."""
    return UNITS.get(name) or UNITS.get(name.removesuffix("s"))


def _unknown(text: str, part: str) -> WorkbenchError:
    """Return the error for an unknown unit, with names near to its unknown part."""
    names = " ".join(each[0] for each in (*_PREFIXED, *_PLAIN, *_ZEROS)).split()
    plain = {each.casefold(): each for each in (*names, "ms", "us", "ns", "mm", "cm", "mV", "mA")}
    near = get_close_matches(part.casefold()[:LONGEST_ECHO], plain, n=3)
    hint = f"did you mean {' or '.join(plain[each] for each in near)}?" if near else ""
    shown = text if len(text) <= LONGEST_ECHO else f"{text[:LONGEST_ECHO]}..."
    return WorkbenchError(
        f"unknown unit '{shown}': {hint or 'write one such as m/s^2, deg/s, rpm, ms or mV'}"
    )
