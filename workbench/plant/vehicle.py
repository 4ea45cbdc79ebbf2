"""The `Vehicle` record: all data of a drone that its controller and the tools need."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import find_row
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor
from workbench.plant.sensors import Sensor
from workbench.plant.thrust_frame import thrust_frame


@dataclass(frozen=True)
class BatteryPack:
    """A battery, modelled as a voltage source with a series resistance.

    Attributes:
        capacity: charge of the full battery [C].
        resistance: of cells and leads [Ω].
        open_circuit_voltage: voltage without load [V] over the state of charge, 0 .. 1, rising,
            with linear interpolation.
        hover_duration: time that it hovers the drone [s]; None if not stated.
        sag_compensation: share of its sag that rotor commands compensate, 0 .. 1; None if not
            stated.
    """

    capacity: float
    resistance: float
    open_circuit_voltage: tuple[tuple[float, float], ...]
    hover_duration: float | None = None
    sag_compensation: float | None = None


@dataclass(frozen=True)
class Frame:
    """A named frame F fixed to the body: a link of the description.

    Attributes:
        name: the link's name.
        p_BF: position of its origin in the body frame [m].
        R_BF: its orientation, rows of the rotation matrix.
    """

    name: str
    p_BF: tuple[float, float, float]
    R_BF: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Vehicle:
    """The data of a drone from its description, for the whole project.

    Attributes:
        name: the robot's name in its description.
        source: the file of the description.
        base_link: its frame is the body frame B.
        mass: all-up mass [kg].
        p_BoBcm_B: the centre of mass in B [m].
        I_BBcm_B: inertia about the centre of mass in B, rows [kg·m²], including rotors at rest.
        rotors: in the order in which every thrust or speed vector of the project lists them.
        sensors: the supported ones, as declared.
        frames: all links, base link first.
        battery: None if not stated; the rotors weaken with its voltage.
        ground_clearance: height of the base link's origin above the ground at rest, upright [m].
    """

    name: str
    source: Path
    base_link: str
    mass: float
    p_BoBcm_B: tuple[float, float, float]
    I_BBcm_B: tuple[tuple[float, float, float], ...]
    rotors: tuple[Rotor, ...]
    sensors: tuple[Sensor, ...]
    frames: tuple[Frame, ...]
    ground_clearance: float
    battery: BatteryPack | None = None

    @property
    def inertia(self) -> np.ndarray:
        """Inertia about the centre of mass in B, 3 x 3 [kg·m²]."""
        return np.array(self.I_BBcm_B)

    @property
    def hover_speeds(self) -> np.ndarray:
        """Rotor speeds in hover, n [rad/s]."""
        return thrust_frame(self).hover_speeds

    @property
    def thrust_to_weight(self) -> float:
        """Largest force along body z over the weight."""
        lifting = (rotor for rotor in self.rotors if rotor.lifts)
        lift = sum(rotor.max_thrust * rotor.axis_B[2] for rotor in lifting)
        return float(lift / (self.mass * GRAVITY))

    @property
    def rotor_lag(self) -> float:
        """Largest time constant of a rotor in hover [s].

        In hover the rates of speeding up and slowing down blend to their mean, see
        `dynamics.rotor_response`.
        """
        lifting = (rotor for rotor in self.rotors if rotor.lifts)
        rates = (1.0 / rotor.time_constant_up + 1.0 / rotor.time_constant_down for rotor in lifting)
        return 2.0 / min(rates)

    @property
    def span(self) -> float:
        """Largest distance between two rotors' hubs [m]."""
        hubs = [rotor.p_BR for rotor in self.rotors]
        return max(math.dist(one, other) for one in hubs for other in hubs)

    def frame(self, name: str) -> Frame:
        """Return the frame of a link.

        Raises:
            WorkbenchError: if the link does not exist.
        """
        return find_row("frame", name, self.frames)


def slowest_rotor(vehicle: Vehicle) -> float:
    """Return the largest time constant of a rotor in hover [s], see `Vehicle.rotor_lag`."""
    return vehicle.rotor_lag
