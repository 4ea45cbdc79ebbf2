"""From a data sheet to a description: known numbers of a multirotor not yet built, and estimates.

Each estimate states its source. `write_xacro` writes every `SheetFigure` with its formula. So a
description states what was estimated and how, and changes with a number in it that is replaced by a
measured one.
"""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.plant.sensor_blocks import SensorBlock
from workbench.plant.thrust_curve import MotorMeasurement

ROTOR_COUNTS_BY_LAYOUT = {"x": (4, 6, 8, 10, 12), "plus": (4, 6, 8, 10, 12), "coaxial": (6, 8, 12)}
"""Numbers of rotors by layout: two arms in front, one arm in front, or two with two rotors each."""
MAX_ARM_END_MASS_SHARE = 0.8
"""Largest share of the mass at the ends of the arms; the frame has mass, too."""


@dataclass(frozen=True)
class Propeller:
    """A propeller as its name states it; lengths in m, pitch None if unknown."""

    diameter: float
    pitch: float | None = None
    blades: int = 2

    @property
    def label(self) -> str:
        """Its name in inches."""
        pitch = "" if self.pitch is None else f"x{self.pitch / 0.0254:.3g}"
        blades = "" if self.blades == 2 else f" with {self.blades} blades"
        return f"{self.diameter / 0.0254:.3g}{pitch} in{blades}"


@dataclass(frozen=True)
class DataSheet:
    """The known numbers of a multirotor before it is built.

    Attributes:
        name: of the drone.
        mass: all-up, with battery [kg].
        arm: distance from the centre to the axis of a rotor [m].
        propeller: of every rotor.
        rotors: their number.
        layout: one of `ROTOR_COUNTS_BY_LAYOUT`.
        measured: for one motor with this propeller, None without a thrust curve.
        max_thrust: of one motor with this propeller [N], None if unknown.
        motor_kv: speed over voltage without load [RPM/V], None if unknown.
        voltage: nominal voltage of the battery [V], None if unknown.
        capacity: of the battery [A·h], None if unknown.
        motor_mass: of one motor with its propeller and speed controller [kg], None if unknown.
        sensors: on it, with usual numbers.
    """

    name: str
    mass: float
    arm: float
    propeller: Propeller
    rotors: int = 4
    layout: str = "x"
    measured: MotorMeasurement | None = None
    max_thrust: float | None = None
    motor_kv: float | None = None
    voltage: float | None = None
    capacity: float | None = None
    motor_mass: float | None = None
    sensors: tuple[SensorBlock, ...] = ()

    @property
    def has_battery(self) -> bool:
        """Whether voltage and capacity of the battery are known."""
        return self.voltage is not None and self.capacity is not None

    @property
    def arms(self) -> int:
        """Number of arms."""
        return self.rotors // 2 if self.layout == "coaxial" else self.rotors

    def check(self) -> None:
        """Check that the multirotor can be built and can fly.

        Raises:
            WorkbenchError: that names the contradicting numbers.
        """
        if self.rotors not in ROTOR_COUNTS_BY_LAYOUT[self.layout]:
            known = ", ".join(map(str, ROTOR_COUNTS_BY_LAYOUT[self.layout]))
            raise WorkbenchError(
                f"{self.rotors} rotors cannot be laid out as {self.layout}: it is for {known}"
            )
        gap = 2.0 * self.arm * math.sin(math.pi / self.arms)
        if self.propeller.diameter >= gap:
            raise WorkbenchError(
                f"propellers of {self.propeller.diameter:.3g} m touch each other: with arms of "
                f"{self.arm:.3g} m their axes are {gap:.3g} m apart; is the arm measured from the "
                "centre to a rotor, and the diagonal from rotor to rotor?"
            )
        if self.motor_mass and self.rotors * self.motor_mass > MAX_ARM_END_MASS_SHARE * self.mass:
            raise WorkbenchError(
                f"{self.rotors} motors of {self.motor_mass:.3g} kg leave too little of a mass of "
                f"{self.mass:.3g} kg: is the mass all-up, with the battery?"
            )
        if (
            self.measured is None
            and self.max_thrust is None
            and None in (self.motor_kv, self.voltage)
        ):
            raise WorkbenchError(
                "nothing says how strong the motors are: give the largest thrust of one motor "
                "(--max-thrust 850g), a thrust curve (--thrust-curve FILE), or KV and battery "
                "(--motor-kv 920KV --battery 4S)"
            )
