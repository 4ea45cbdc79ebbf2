"""Faults by name: of sensors that freeze, of rotors that give less, and how they are repaired."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.scenario.parameters import MOST_ROTORS, SENSOR_KINDS

SENSOR_MODES = {"frozen": 1.0, "noisy": 2.0, "silent": 3.0}
"""Ways in which a sensor fails, with the value of its parameter."""
TURBULENCES = {"still": 0.0, "light": 7.7, "moderate": 15.4, "severe": 23.2}
"""Degrees of turbulence, by the wind speed at 20 ft that makes it (MIL-F-8785C, 3.7.2) [m/s]."""


@dataclass(frozen=True)
class Part:
    """What may fail.

    Attributes:
        name: in words.
        parameter: that makes it fail.
        whole: value of that while it does not.
        modes: in which it fails, with their values; none where the parameter is a share that it
            gives.
    """

    name: str
    parameter: str
    whole: float
    modes: Mapping[str, float]

    def fault(self, value: float) -> str:
        """Return what is the matter at a value of its parameter, "" if nothing is."""
        if value == self.whole:
            return ""
        for mode, of_mode in self.modes.items():
            if of_mode == value:
                return f"{self.name} {mode}"
        return f"{self.name} at {100.0 * value:.0f} %"


PARTS = (
    *(Part(f"rotor {number}", f"rotor_{number}", 1.0, {}) for number in range(1, MOST_ROTORS + 1)),
    *(Part(kind.replace("_", " "), f"{kind}_fault", 0.0, SENSOR_MODES) for kind in SENSOR_KINDS),
)
