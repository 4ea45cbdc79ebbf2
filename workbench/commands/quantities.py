"""Numbers with units, as a data sheet has them: 450mm, 1.2kg, 10x4.5, 4S 5000mAh."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.errors import LONGEST_ECHO, WorkbenchError

_INCH = 0.0254
_GRAVITY = 9.80665
"""By definition, of a kilogram-force [m/s²]."""
_POUND = 0.45359237
_CELL = 3.7
"""Nominal voltage of a lithium-polymer cell [V]."""
_NUMBER = r"([0-9]+\.?[0-9]*|\.[0-9]+)(?:e([+-]?[0-9]{1,2}))?"
_PROPELLER = re.compile(
    rf"{_NUMBER}\s*[x×]\s*{_NUMBER}(?:\s*[x×]\s*([0-9]))?\s*(in|inch|\")?", re.I
)


@dataclass(frozen=True)
class Quantity:
    """A kind of number that is written with a unit.

    Attributes:
        name: what it is, the beginning of a sentence.
        units: factor to the SI unit by unit; the first is the SI unit, which may be left out.
        minimum: smallest that is believed, in the SI unit.
        maximum: largest that is believed.
        example: how it is written.
    """

    name: str
    units: Mapping[str, float]
    minimum: float
    maximum: float
    example: str

    def read(self, text: str) -> float:
        """Return a value in the SI unit.

        Raises:
            WorkbenchError: if it is no such quantity, or not believed.
        """
        found = re.fullmatch(rf"{_NUMBER}\s*([a-z/\"]*)", text.strip(), re.IGNORECASE)
        if found is None:
            raise self._refused(text, "is no number with a unit")
        number = float(found[1] + (f"e{found[2]}" if found[2] else ""))
        unit = found[3].casefold() or next(iter(self.units)).casefold()
        factors = {name.casefold(): factor for name, factor in self.units.items()}
        if unit not in factors:
            raise self._refused(text, f"has no known unit (these are {', '.join(self.units)})")
        value = number * factors[unit]
        if not self.minimum <= value <= self.maximum:
            si = next(iter(self.units))
            raise self._refused(
                text,
                f"is {value:g} {si}, and of a multirotor {self.minimum:g} to {self.maximum:g} {si}",
            )
        return value

    def _refused(self, text: str, reason: str) -> WorkbenchError:
        return WorkbenchError(
            f"{self.name} '{text[:LONGEST_ECHO]}' {reason}: write it as {self.example}"
        )


_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": _INCH, "inch": _INCH, '"': _INCH}
_MASSES = {"kg": 1.0, "g": 0.001, "lb": _POUND, "oz": _POUND / 16.0}
_FORCES = {
    "N": 1.0,
    "g": 0.001 * _GRAVITY,
    "gf": 0.001 * _GRAVITY,
    "kg": _GRAVITY,
    "kgf": _GRAVITY,
    "lb": _POUND * _GRAVITY,
    "lbf": _POUND * _GRAVITY,
    "oz": _POUND * _GRAVITY / 16.0,
}
MASS = Quantity("the mass", _MASSES, 0.005, 500.0, "1.2kg or 1200g")
MOTOR_MASS = Quantity("the mass of a motor", _MASSES, 1e-4, 50.0, "80g")
ARM = Quantity("the arm", _LENGTHS, 0.01, 5.0, "225mm or 0.225m")
DIAGONAL = Quantity("the diagonal", _LENGTHS, 0.02, 10.0, "450mm or 0.45m")
DIAMETER = Quantity("the propeller's diameter", _LENGTHS, 0.01, 3.0, "10in, 254mm or 10x4.5")
MAX_THRUST = Quantity("the largest thrust", _FORCES, 0.01, 2000.0, "850g or 8.3N")
MOTOR_KV = Quantity("the motor's KV", {"KV": 1.0, "rpm/V": 1.0}, 10.0, 50_000.0, "920KV")
_VOLTAGE = Quantity("the battery's voltage", {"V": 1.0}, 1.0, 1000.0, "4S or 14.8V")
_CELLS = Quantity("the battery", {"S": _CELL}, _CELL, 60.0 * _CELL, "4S or 14.8V")
_CAPACITY = Quantity(
    "the battery's capacity", {"Ah": 1.0, "mAh": 0.001}, 0.01, 1000.0, "5000mAh or 5Ah"
)


def read_propeller(text: str) -> tuple[float, float | None, int]:
    """Return diameter [m], pitch [m] where it is given, and the number of blades.

    `10x4.5` is in inches, as on every propeller; a third number counts blades. A diameter alone
    has a unit.

    Raises:
        WorkbenchError: if it is neither.
    """
    found = _PROPELLER.fullmatch(text.strip())
    if found is None:
        return DIAMETER.read(text), None, 2
    diameter, pitch = (float(found[group]) * _INCH for group in (1, 3))
    blades = int(found[5] or 2)
    if not 0.1 * diameter <= pitch <= 1.5 * diameter or not 2 <= blades <= 8:
        raise WorkbenchError(
            f"the propeller '{text}' is none: write diameter x pitch in inches as 10x4.5, and "
            "blades where they are more than two, as 5x4.3x3"
        )
    return DIAMETER.read(f"{diameter}m"), pitch, blades


def read_battery(text: str) -> tuple[float, float | None]:
    """Return nominal voltage [V] and, where it is given, capacity [A·h] of `4S` or `4S 5000mAh`.

    Raises:
        WorkbenchError: if it is none.
    """
    voltage, *capacity = re.split(r"[\s,]+", text.strip())
    if len(capacity) > 1:
        raise WorkbenchError(
            f"the battery '{text[:LONGEST_ECHO]}' is none: write it as '4S 5000mAh'"
        )
    kind = _CELLS if voltage[-1:] in ("s", "S") else _VOLTAGE
    return kind.read(voltage), _CAPACITY.read(capacity[0]) if capacity else None
