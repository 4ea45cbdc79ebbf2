"""Display units: degrees and kilometres per hour appear only on screens."""

import math
import re
from dataclasses import dataclass

from workbench.common.plain_text import plain_name
from workbench.gui.preferences import Preferences


@dataclass(frozen=True)
class Unit:
    """Display unit of a quantity.

    Attributes:
        symbol: symbol after the number, "" for none.
        factor: factor from SI to the display unit.
    """

    symbol: str
    factor: float = 1.0

    def shown(self, value: float) -> float:
        """Return a value in SI in the display unit."""
        return value * self.factor

    def read(self, shown: float) -> float:
        """Return a value in the display unit in SI."""
        return shown / self.factor

    def text(self, value: float, decimals: int = 2) -> str:
        """Return a value in SI with its unit, as 12.30 m/s; a dash if it is not finite."""
        if not math.isfinite(value):
            return "–"
        number = f"{self.shown(value):.{decimals}f}"
        if float(number) == 0.0:
            number = number.removeprefix("-")  # a negative zero would flicker
        glue = "" if self.symbol in ("", "°", "%") else "\N{NO-BREAK SPACE}"
        return f"{number}{glue}{self.symbol}".replace("-", "\N{MINUS SIGN}", 1)


_DEGREES = {
    "rad": Unit("°", 180.0 / math.pi),
    "rad/s": Unit("°/s", 180.0 / math.pi),
    "rad/s^2": Unit("°/s²", 180.0 / math.pi),
}
LONGEST_UNIT = 24
"""Largest number of characters that are shown of a log's unit."""
MICROTESLA = Unit("µT", 1e6)
_DENSITY = re.compile(r"(?:\((.+)\)|(\w+))\^2/Hz")
"""Matches a power spectral density, as `logs.spectrum.density_unit` writes it."""


def unit_for(si: str, preferences: Preferences) -> Unit:
    """Return the display unit for an SI unit, as in parameters and topics."""
    if si in _DEGREES and preferences.text("angle_unit") == "degree":
        return _DEGREES[si]
    if si == "m/s" and preferences.text("speed_unit") == "km/h":
        return Unit("km/h", 3.6)
    if squared := _DENSITY.fullmatch(si):
        of = unit_for(squared[1] or squared[2], preferences)
        symbol = of.symbol if of.symbol.isalpha() else f"({of.symbol})"
        return Unit(f"{symbol}²/Hz", of.factor**2)
    if si == "T":
        return MICROTESLA
    if si in ("1", ""):
        return Unit("")
    return Unit(plain_name(si.replace("^2", "²").replace("^3", "³"), LONGEST_UNIT))
