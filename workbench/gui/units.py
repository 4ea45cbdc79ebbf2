"""Numbers on screens: the unit of a quantity, and its one format.

Degrees and kilometres per hour appear only here. Charts are the exception: the numbers beside
curves have as many decimals as the shown part of an axis needs.
"""

import math
import re

from workbench.common.plain_text import plain_name
from workbench.common.quantity import DisplayUnit, Quantity, number_text, significant_text
from workbench.gui.preferences import Preferences

DEGREES_PER_RADIAN = 180.0 / math.pi
DEGREE_UNIT = DisplayUnit("°", DEGREES_PER_RADIAN, 1)
_DEGREE_UNITS = {
    "rad": DEGREE_UNIT,
    "rad/s": DisplayUnit("°/s", DEGREES_PER_RADIAN, 1),
    "rad/s^2": DisplayUnit("°/s²", DEGREES_PER_RADIAN, 1),
}
_RADIAN_DECIMALS = 3
MAX_UNIT_CHARACTERS = 24
"""Largest number of characters that are shown of a log's unit."""
MICROTESLA_UNIT = DisplayUnit("µT", 1e6)
HECTOPASCAL_UNIT = DisplayUnit("hPa", 0.01)
THRUST_UNIT = DisplayUnit("N", decimals=1)
ROTOR_SPEED_UNIT = DisplayUnit("rad/s", decimals=0)
SHARE_UNIT = DisplayUnit("%", 100.0, 0)
LOG_TIME_UNIT = DisplayUnit("s")
LENGTH_UNIT = DisplayUnit("m")
FREQUENCY_DIGITS = 3
GAIN_DIGITS = 4
TEXT_VALUE_TOLERANCE = 1e-4
"""Relative tolerance within which a text stands for the exact value."""
UNUSUAL_VALUE_DIGITS = 5
"""Significant digits of a value that the usual decimals do not show."""
_POWER_DENSITY_UNIT = re.compile(r"(?:\((.+)\)|(\w+))\^2/Hz")
"""Matches a power spectral density, as `logs.spectrum.density_unit` writes it."""


def unit_for(si: str, preferences: Preferences) -> DisplayUnit:
    """Return the display unit for an SI unit, as in parameters and topics, with its decimals."""
    if si in _DEGREE_UNITS:
        degree = preferences.text("angle_unit") == "degree"
        return _DEGREE_UNITS[si] if degree else DisplayUnit(unit_symbol(si), 1.0, _RADIAN_DECIMALS)
    if si == "m/s" and preferences.text("speed_unit") == "km/h":
        return DisplayUnit("km/h", 3.6)
    if squared := _POWER_DENSITY_UNIT.fullmatch(si):
        of = unit_for(squared[1] or squared[2], preferences)
        symbol = of.symbol if of.symbol.isalpha() else f"({of.symbol})"
        return DisplayUnit(f"{symbol}²/Hz", of.factor**2)
    if si == "T":
        return MICROTESLA_UNIT
    return DisplayUnit(unit_symbol(si))


def entered_number_text(value: float, unit: DisplayUnit, decimals: int | None = None) -> str:
    """Return a value that a user can enter as text without its unit.

    It has the usual decimals, more if these would change the value.

    Args:
        value: in SI.
        unit: the shown unit.
        decimals: usual number of decimals; None for those of the unit.
    """
    shown = unit.shown(value)
    text = f"{shown:.{unit.decimals if decimals is None else decimals}f}"
    if not math.isclose(float(text), shown, rel_tol=TEXT_VALUE_TOLERANCE, abs_tol=1e-12):
        text = f"{shown:.{UNUSUAL_VALUE_DIGITS}g}"
    return "0" + text[2:] if text.startswith("-0") and float(text) == 0.0 else text


def quantity_unit(quantity: Quantity, preferences: Preferences) -> DisplayUnit:
    """Return the display unit for a quantity: that of its SI unit, percent for a share."""
    if quantity.unit == "1" and quantity.maximum <= 1.0:
        return SHARE_UNIT
    return unit_for(quantity.unit, preferences)


def unit_symbol(si: str) -> str:
    """Return an SI unit as text, with raised powers; "" for a number without one."""
    return (
        ""
        if si == "1"
        else plain_name(si.replace("^2", "²").replace("^3", "³"), MAX_UNIT_CHARACTERS)
    )


def place_unit(preferences: Preferences) -> DisplayUnit:
    """Return the unit of latitude and longitude, to 1 cm."""
    if preferences.text("angle_unit") == "degree":
        return DisplayUnit("°", DEGREES_PER_RADIAN, 7)
    return DisplayUnit("rad", 1.0, 9)


def frequency_text(frequency: float) -> str:
    """Return an angular frequency [rad/s] of a loop or a pole with its unit."""
    return f"{significant_text(frequency, FREQUENCY_DIGITS)}\N{NO-BREAK SPACE}rad/s"


def hertz_text(frequency: float) -> str:
    """Return an angular frequency [rad/s] in rad/s and in Hz."""
    hertz = significant_text(frequency / (2.0 * math.pi), FREQUENCY_DIGITS)
    return f"{frequency_text(frequency)} ({hertz}\N{NO-BREAK SPACE}Hz)"


def gain_text(gain: float) -> str:
    """Return the value of a gain without its unit."""
    return significant_text(gain, GAIN_DIGITS)


def age_text(age: float) -> str:
    """Return an age [s] in milliseconds below one second, and in minutes above one."""
    if not math.isfinite(age):
        return "–"
    if age < 0.9995:
        return f"{max(0.0, 1000.0 * age):.0f}\N{NO-BREAK SPACE}ms"
    if age < 59.5:
        return f"{number_text(age, 1 if age < 9.95 else 0)}\N{NO-BREAK SPACE}s"
    return f"{age / 60.0:.0f}\N{NO-BREAK SPACE}min"


def simulated_text(seconds: float, *, paused: bool = False) -> str:
    """Return a time of a flight [s] as minutes and seconds, with hours if needed: 1:02.5.

    Like a clock it is never rounded up.

    Args:
        seconds: the time [s].
        paused: whether it stands still, so that milliseconds are legible.
    """
    if not math.isfinite(seconds):
        return "–"
    decimals = 3 if paused else 1
    whole, part = divmod(int(seconds * 10**decimals + 1e-6), 10**decimals)
    minutes, seconds_left = divmod(whole, 60)
    text = f"{seconds_left:02d}.{part:0{decimals}d}"
    return f"{minutes // 60}:{minutes % 60:02d}:{text}" if minutes >= 60 else f"{minutes}:{text}"
