"""A number with a unit: its limits, the unit in which it is shown, and its text."""

import math
from dataclasses import dataclass
from numbers import Real

from workbench.common.errors import WorkbenchError

RPM_IN_RAD_S = math.pi / 30.0
"""One revolution per minute [rad/s]."""


def number_text(value: float, decimals: int) -> str:
    """Return a number with a true minus sign, but none before zero; a dash for NaN or infinity."""
    if not math.isfinite(value):
        return "–"
    if abs(value) >= 1e6:
        return f"{value:.3g}".replace("-", "\N{MINUS SIGN}")
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.removeprefix("-")  # a negative zero would flicker
    return text.replace("-", "\N{MINUS SIGN}")


def significant_text(value: float, digits: int) -> str:
    """Return a number with this many significant digits, and a true minus sign."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")


def number_or_dash(value: float, form: str) -> str:
    """Return a number in a format such as ".3f", a dash where there is none."""
    return "—" if math.isnan(value) else format(value, form)


@dataclass(frozen=True)
class DisplayUnit:
    """Display unit of a quantity.

    Attributes:
        symbol: symbol after the number, "" for none.
        factor: factor from SI to the display unit.
        decimals: usual number of decimals.
    """

    symbol: str
    factor: float = 1.0
    decimals: int = 2

    def shown(self, value: float) -> float:
        """Return a value in SI in the display unit."""
        return value * self.factor

    def read(self, shown: float) -> float:
        """Return a value in the display unit in SI."""
        return shown / self.factor

    @property
    def suffix(self) -> str:
        """The symbol as it stands behind a number: with a space, but for a degree."""
        glue = "" if self.symbol in ("", "°") else "\N{NO-BREAK SPACE}"
        return f"{glue}{self.symbol}"

    def number(self, value: float) -> str:
        """Return a value in SI as text without its unit; a dash if it is not finite."""
        return number_text(self.shown(value), self.decimals)

    def text(self, value: float) -> str:
        """Return a value in SI with its unit, as 12.30 m/s; a dash if it is not finite."""
        return f"{self.number(value)}{self.suffix}" if math.isfinite(value) else "–"


def display_unit(unit: str) -> DisplayUnit:
    """Return the unit in which tables and files show an SI unit: angles are in degrees."""
    if unit == "rad":
        return DisplayUnit("deg", math.degrees(1.0))
    return DisplayUnit("" if unit == "1" else unit)


@dataclass(frozen=True)
class Quantity:
    """A row of a table of numbers: parameters, metrics, limits, preferences, columns.

    Attributes:
        name: unique in its table.
        unit: SI, "1" or %, unless the table says otherwise; "" for what is no number.
        help: what it is, for a tool tip.
        minimum: smallest value allowed.
        maximum: largest value allowed.
    """

    name: str
    unit: str
    help: str
    minimum: float = -math.inf
    maximum: float = math.inf

    @property
    def title(self) -> str:
        """Name in messages."""
        return self.name

    def check(self, value: float, where: str = "") -> float:
        """Return a value as a float.

        Args:
            value: to be set.
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: if it is not a number, or out of range.
        """
        name = f"{where}{self.title}"
        if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
            raise WorkbenchError(f"{name} is '{value}': give it a number")
        if not self.minimum <= value <= self.maximum:
            unit = "" if self.unit in ("", "1") else f" {self.unit}"
            raise WorkbenchError(
                f"{name} is {value:g}{unit}: keep it within "
                f"{self.minimum:g} .. {self.maximum:g}{unit}"
            )
        return float(value)

    def text(self, value: float) -> str:
        """Return a value with its unit as text, to three digits; angles in degrees."""
        if math.isnan(value):
            return "—"
        unit = display_unit(self.unit)
        return f"{unit.shown(value):.3g} {unit.symbol}".rstrip()
