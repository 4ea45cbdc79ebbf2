"""Plausible ranges of the numbers of a multirotor; what is outside is most often a wrong unit.

They admit every published description that was tried, from a Crazyflie of 27 g to heavy lifters of
12 kg, and more on both sides. A value outside is possible, and gets a remark.
"""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """The plausible values of a quantity.

    Attributes:
        quantity: its name.
        unit: of the limits; "1" for a ratio.
        least: smallest plausible value.
        most: largest plausible value.
        others: units that are written for it by mistake, with their values in `unit`.
    """

    quantity: str
    unit: str
    least: float
    most: float
    others: Mapping[str, float]

    def holds(self, value: float) -> bool:
        """Return whether a value is plausible."""
        return self.least <= value <= self.most

    def meant(self, number: float) -> str:
        """Return a question for the unit in which a number is plausible, "" if there is none."""
        units = [unit for unit, factor in self.others.items() if self.holds(factor * number)]
        return f"did you mean {number:g} {units[0]}?" if units else ""

    def clause(self, value: float, number: float | None = None) -> str:
        """Return a clause about a value that is not plausible, "" for one that is.

        Args:
            value: in `unit`.
            number: as it was written, if in another unit.
        """
        if self.holds(value):
            return ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        text = f"its {self.quantity}, {value:.4g}{unit}, is outside of the usual "
        text += f"{self.least:g} to {self.most:g}{unit}"
        asked = self.meant(value if number is None else number)
        return f"{text}: {asked or 'is it in the correct unit?'}"


_KG_PER_MASS_UNIT = {"g": 0.001, "oz": 0.02835, "lb": 0.4536}
_M_PER_LENGTH_UNIT = {"mm": 0.001, "cm": 0.01, "in": 0.0254}
MASS_RANGE = Range("mass", "kg", 0.01, 200.0, _KG_PER_MASS_UNIT)
MOTOR_MASS_RANGE = Range("mass of a motor", "kg", 5e-4, 5.0, _KG_PER_MASS_UNIT)
ARM_RANGE = Range("arm", "m", 0.015, 2.5, _M_PER_LENGTH_UNIT)
DIAGONAL_RANGE = Range("diagonal", "m", 0.03, 5.0, _M_PER_LENGTH_UNIT)
DIAMETER_RANGE = Range("propeller diameter", "m", 0.015, 2.0, _M_PER_LENGTH_UNIT)
MAX_THRUST_RANGE = Range(
    "largest thrust of a rotor", "N", 0.02, 400.0, {"g": 0.00981, "kg": 9.81, "lb": 4.45}
)
MOTOR_KV_RANGE = Range("KV", "rpm/V", 40.0, 30_000.0, {})
CELL_COUNT_RANGE = Range("number of cells in series", "1", 1.0, 14.0, {})
VOLTAGE_RANGE = Range("battery voltage", "V", 2.5, 120.0, {"mV": 0.001})
CAPACITY_RANGE = Range("battery capacity", "A h", 0.05, 100.0, {"mAh": 0.001})

CHARGE_RANGE = Range("battery capacity", "C", 180.0, 1e6, {"A h": 3600.0, "mA h": 3.6})
RESISTANCE_RANGE = Range("battery resistance", "ohm", 5e-4, 1.0, {"mohm": 0.001})
THRUST_TO_WEIGHT_RANGE = Range("thrust-to-weight", "1", 1.2, 20.0, {})
"""Less cannot resist a gust; racing quadrotors have 15."""
ARM_RATIO_RANGE = Range("arm over the usual one of its mass", "1", 0.25, 4.0, {})
GYRATION_RANGE = Range("radius of gyration over the longest arm", "1", 0.1, 1.5, {})
"""Published ones have 0.3 to 0.8: motors alone are a tenth of the mass at the ends of the arms,
which yields 0.2, and almost no mass lies beyond them."""
TIP_SPEED_RANGE = Range("speed of a blade tip", "m/s", 0.0, 300.0, {})
"""Near that of sound, 340 m/s, they gain no thrust."""
ROTOR_OVERLAP_RANGE = Range(
    "propeller diameter over the distance to the next hub", "1", 0.0, 1.6, {}
)
"""Published ones have up to 1, except coaxial ones."""
ROTOR_LAG_RANGE = Range("time constant of a rotor", "s", 5e-4, 0.5, {"ms": 0.001})
"""Published ones have 0.01 to 0.1 s."""
ROTOR_TORQUE_RANGE = Range("drag torque over thrust and diameter", "1", 0.005, 1.0, {})
"""0.05 to 0.1 is usual, 0.45 published."""
ROTOR_INERTIA_RANGE = Range(
    "inertia of a rotor over that of a propeller with its thrust", "1", 0.07, 30.0, {}
)
"""Published ones have 0.2 to 2; it depends on the fifth power of the diameter, which is accurate to
a fifth, and motor bells add to it."""
HOVER_SPEED_RATIO_RANGE = Range("ratio of the hover speeds of the rotors", "1", 1.0, 2.5, {})
ROTOR_DRAG_RANGE = Range("rotor drag over the weight, at 1 m/s in hover", "1", 0.0, 0.5, {})
"""Published ones have 0.002 to 0.15."""
ROLLING_MOMENT_RANGE = Range(
    "rolling moment over weight times arm, at 1 m/s in hover", "1", 0.0, 0.5, {}
)
INFLOW_LOSS_RANGE = Range("thrust lost in a climb of 1 m/s, over the weight", "1", 0.0, 0.5, {})
GROUND_EFFECT_RANGE = Range("ground effect coefficient", "1", 0.0, 50.0, {})
"""Published ones have 1 to 12."""
PROPELLER_RADIUS_RANGE = Range(
    "propeller radius over that of a propeller with its thrust", "1", 0.3, 3.0, {}
)
