"""Faults by name: of sensors that freeze, of rotors that give less, and how they are repaired."""

from dataclasses import dataclass

from workbench.scenario.parameters import MOST_ROTORS, SENSOR_KINDS


@dataclass(frozen=True)
class FaultMode:
    """A way in which a sensor fails.

    Attributes:
        name: in words.
        value: of the sensor's parameter.
    """

    name: str
    value: float


SENSOR_MODES = (FaultMode("frozen", 1.0), FaultMode("noisy", 2.0), FaultMode("silent", 3.0))


@dataclass(frozen=True)
class Part:
    """What may fail.

    Attributes:
        name: in words.
        parameter: that makes it fail.
        whole: value of that while it does not.
        modes: in which it fails; none where the parameter is a share that it gives.
    """

    name: str
    parameter: str
    whole: float
    modes: tuple[FaultMode, ...]

    def fault(self, value: float) -> str:
        """Return what is the matter at a value of its parameter, "" if nothing is."""
        if value == self.whole:
            return ""
        for mode in self.modes:
            if mode.value == value:
                return f"{self.name} {mode.name}"
        return f"{self.name} at {100.0 * value:.0f} %"


PARTS = (
    *(Part(f"rotor {number}", f"rotor_{number}", 1.0, ()) for number in range(1, MOST_ROTORS + 1)),
    *(Part(kind.replace("_", " "), f"{kind}_fault", 0.0, SENSOR_MODES) for kind in SENSOR_KINDS),
)


@dataclass(frozen=True)
class Turbulence:
    """A degree of turbulence.

    Attributes:
        name: of the degree.
        speed: value of the parameter `turbulence` [m/s].
    """

    name: str
    speed: float


TURBULENCES = (
    Turbulence("still", 0.0),
    Turbulence("light", 7.7),
    Turbulence("moderate", 15.4),
    Turbulence("severe", 23.2),
)
