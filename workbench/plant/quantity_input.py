"""Read names of drones, quantities with units, propellers and batteries from text."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError
from workbench.plant import ranges

DRONE_FILE_ENDING = ".urdf.xacro"
"""Ending of the file of a drone that is made from a data sheet."""
_DRONE_NAME_PATTERN = re.compile(r"[A-Za-z0-9][\w.-]*")
_INCH_M = 0.0254
KILOGRAM_FORCE_N = 9.80665
"""Standard gravity, which defines the kilogram-force [m/s²]."""
_POUND_KG = 0.45359237
LIPO_CELL_V = 3.7
"""Nominal voltage of a lithium-polymer cell [V]."""
_INPUT_NUMBER = r"([0-9]+\.?[0-9]*|\.[0-9]+)(?:e([+-]?[0-9]{1,2}))?"
_PROPELLER_PATTERN = re.compile(
    rf"{_INPUT_NUMBER}\s*[x×]\s*{_INPUT_NUMBER}(?:\s*[x×]\s*([0-9]))?\s*(in|inch|\")?", re.I
)


@dataclass(frozen=True)
class InputQuantity:
    """A quantity with a unit.

    Attributes:
        name: its name, at the begin of a sentence.
        units: factors to the SI unit by unit; the first is the SI unit, which is optional.
        minimum: smallest possible value, in the SI unit.
        maximum: largest possible value.
        example: of the text.
        usual: its plausible range.
    """

    name: str
    units: Mapping[str, float]
    minimum: float
    maximum: float
    example: str
    usual: ranges.Range

    def read(self, text: str) -> float:
        """Return a value in the SI unit.

        Raises:
            WorkbenchError: if it is not such a quantity, or not possible.
        """
        found = re.fullmatch(rf"{_INPUT_NUMBER}\s*([a-z/\"]*)", text.strip(), re.IGNORECASE)
        if found is None:
            raise self._refused(text, "is not a number with a unit")
        number = float(found[1] + (f"e{found[2]}" if found[2] else ""))
        unit = found[3].casefold() or next(iter(self.units)).casefold()
        factors = {name.casefold(): factor for name, factor in self.units.items()}
        if unit not in factors:
            raise self._refused(text, f"has no known unit (these are {', '.join(self.units)})")
        value = number * factors[unit]
        if not self.minimum <= value <= self.maximum:
            si = next(iter(self.units))
            asked = self.usual.meant(number)
            raise self._refused(
                text,
                f"is {value:g} {si}, but a multirotor has {self.minimum:g} to {self.maximum:g} "
                f"{si}{f' ({asked})' if asked else ''}",
            )
        return value

    def _refused(self, text: str, reason: str) -> WorkbenchError:
        return WorkbenchError(
            f"{self.name} '{text[:MAX_ECHO_CHARS]}' {reason}: write it as {self.example}"
        )


_LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": _INCH_M, "inch": _INCH_M, '"': _INCH_M}
_MASS_UNITS = {"kg": 1.0, "g": 0.001, "lb": _POUND_KG, "oz": _POUND_KG / 16.0}
_FORCE_UNITS = {
    "N": 1.0,
    "g": 0.001 * KILOGRAM_FORCE_N,
    "gf": 0.001 * KILOGRAM_FORCE_N,
    "kg": KILOGRAM_FORCE_N,
    "kgf": KILOGRAM_FORCE_N,
    "lb": _POUND_KG * KILOGRAM_FORCE_N,
    "lbf": _POUND_KG * KILOGRAM_FORCE_N,
    "oz": _POUND_KG * KILOGRAM_FORCE_N / 16.0,
}
MASS_INPUT = InputQuantity(
    "the mass", _MASS_UNITS, 0.005, 500.0, "1.2kg or 1200g", ranges.MASS_RANGE
)
MOTOR_MASS_INPUT = InputQuantity(
    "the mass of a motor", _MASS_UNITS, 1e-4, 50.0, "80g", ranges.MOTOR_MASS_RANGE
)
ARM_INPUT = InputQuantity("the arm", _LENGTH_UNITS, 0.01, 5.0, "225mm or 0.225m", ranges.ARM_RANGE)
DIAGONAL_INPUT = InputQuantity(
    "the diagonal", _LENGTH_UNITS, 0.02, 10.0, "450mm or 0.45m", ranges.DIAGONAL_RANGE
)
DIAMETER_INPUT = InputQuantity(
    "the propeller's diameter",
    _LENGTH_UNITS,
    0.01,
    3.0,
    "10in, 254mm or 10x4.5",
    ranges.DIAMETER_RANGE,
)
MAX_THRUST_INPUT = InputQuantity(
    "the largest thrust", _FORCE_UNITS, 0.01, 2000.0, "850g or 8.3N", ranges.MAX_THRUST_RANGE
)
MOTOR_KV_INPUT = InputQuantity(
    "the motor's KV", {"KV": 1.0, "rpm/V": 1.0}, 10.0, 50_000.0, "920KV", ranges.MOTOR_KV_RANGE
)
_VOLTAGE_INPUT = InputQuantity(
    "the battery's voltage", {"V": 1.0}, 1.0, 1000.0, "4S or 14.8V", ranges.VOLTAGE_RANGE
)
_CELLS_INPUT = InputQuantity(
    "the battery",
    {"S": LIPO_CELL_V},
    LIPO_CELL_V,
    60.0 * LIPO_CELL_V,
    "4S or 14.8V",
    ranges.VOLTAGE_RANGE,
)
_CAPACITY_INPUT = InputQuantity(
    "the battery's capacity",
    {"Ah": 1.0, "mAh": 0.001},
    0.01,
    1000.0,
    "5000mAh or 5Ah",
    ranges.CAPACITY_RANGE,
)


def is_drone_name(text: str) -> bool:
    """Return whether a text can name a drone, and its file without the ending."""
    return _DRONE_NAME_PATTERN.fullmatch(text) is not None


def parse_propeller(text: str) -> tuple[float, float | None, int]:
    """Return diameter [m], pitch [m] if given, and the number of blades.

    `10x4.5` is in inches, as on every propeller; a third number counts blades. A diameter alone
    has a unit.

    Raises:
        WorkbenchError: if it is neither.
    """
    found = _PROPELLER_PATTERN.fullmatch(text.strip())
    if found is None:
        return DIAMETER_INPUT.read(text), None, 2
    diameter, pitch = (float(found[group]) * _INCH_M for group in (1, 3))
    blades = int(found[5] or 2)
    if not 0.1 * diameter <= pitch <= 1.5 * diameter or not 2 <= blades <= 8:
        raise WorkbenchError(
            f"'{text}' is not a propeller: write diameter x pitch in inches as 10x4.5, and "
            "blades where they are more than two, as 5x4.3x3"
        )
    return DIAMETER_INPUT.read(f"{diameter}m"), pitch, blades


def parse_battery(text: str) -> tuple[float, float | None]:
    """Return nominal voltage [V] and, if given, capacity [A·h] from `4S` or `4S 5000mAh`.

    Raises:
        WorkbenchError: if it is none.
    """
    voltage, *capacity = re.split(r"[\s,]+", text.strip())
    if len(capacity) > 1:
        raise WorkbenchError(
            f"'{text[:MAX_ECHO_CHARS]}' is not a battery: write it as '4S 5000mAh'"
        )
    kind = _CELLS_INPUT if voltage[-1:] in ("s", "S") else _VOLTAGE_INPUT
    return kind.read(voltage), _CAPACITY_INPUT.read(capacity[0]) if capacity else None
