"""Faults by name, such as a frozen sensor or a weak rotor, and their repair."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.plant.sensors import CORE_SENSORS, added_sensors

SENSOR_MODES = {"frozen": 1.0, "noisy": 2.0, "silent": 3.0}
"""Failure modes of a sensor, with the value of its parameter."""
TURBULENCES = {"still": 0.0, "light": 7.7, "moderate": 15.4, "severe": 23.2}
"""Levels of turbulence, by their wind speed at 20 ft (MIL-F-8785C, 3.7.2) [m/s]."""


@dataclass(frozen=True)
class FailingPart:
    """A part that may fail.

    Attributes:
        name: of the part.
        parameter: name of the one that makes it fail.
        whole: value of that parameter without a fault.
        modes: failure modes with their values; empty if the parameter is the remaining share.
    """

    name: str
    parameter: str
    whole: float
    modes: Mapping[str, float]

    def fault(self, value: float) -> str:
        """Return the fault at a value of its parameter in words, or ""."""
        if value == self.whole:
            return ""
        for mode, of_mode in self.modes.items():
            if of_mode == value:
                return f"{self.name} {mode}"
        return f"{self.name} at {100.0 * value:.0f} %"


@cache
def failing_parts() -> tuple[FailingPart, ...]:
    """Return all parts that may fail: the rotors, then the sensors by kind."""
    rotors = (
        FailingPart(f"rotor {number}", f"rotor_{number}", 1.0, {})
        for number in range(1, MAX_WEAKENED_ROTORS + 1)
    )
    sensors = (
        FailingPart(each.kind.replace("_", " "), f"{each.kind}_fault", 0.0, SENSOR_MODES)
        for each in (*CORE_SENSORS, *added_sensors())
    )
    return (*rotors, *sensors)
