"""The `Vehicle` record: all data of a drone that its controller and the tools need."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import find_named_row
from workbench.common.parameter import SERVO_UNITS
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor
from workbench.plant.sensors import Imu, Sensor
from workbench.plant.servo import Servo
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.tilt import Tilt


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
class VehicleFrame:
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
class VehicleJoint:
    """A joint that moves in flight.

    Attributes:
        name: of the joint.
        kind: as in the description.
        parent: link.
        child: link.
        freedoms: number of them.
        links: that move with it, the child first.
        mass: of these [kg].
    """

    name: str
    kind: str
    parent: str
    child: str
    freedoms: int
    links: tuple[str, ...]
    mass: float


@dataclass(frozen=True)
class VehicleServo:
    """What drives a freedom of a joint.

    Attributes:
        joint: name of the freedom.
        slides: whether it is a translation.
        servo: its numbers, within the limits of the freedom.
    """

    joint: str
    slides: bool
    servo: Servo

    @property
    def setpoint_unit(self) -> str:
        """Unit of its setpoint."""
        return SERVO_UNITS[self.servo.kind][self.slides]


@dataclass(frozen=True)
class TurnedBody:
    """The body that rotors turn at once, where joints swing freely.

    Attributes:
        p_BoBcm_B: where a force does not turn it [m].
        I_BBcm_B: its inertia about that, rows [kg·m²].
    """

    p_BoBcm_B: tuple[float, float, float]
    I_BBcm_B: tuple[tuple[float, float, float], ...]


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
        joints: those that move; all else here is with them at zero.
        cables: names of those that carry loads or tie links together.
        contact_links: of a vehicle with joints, the first links of bodies that can touch something.
        joint_signals: names and units of their positions, then of their velocities, in the order of
            Drake's plant.
        turned: what a law steers, see `plant.swinging`; None if that is all that flies.
        servos: that drive joints, in the order of the plant.
        tilts: joints with servos that turn rotors, where the rotors alone cannot control it.
        unloaded: what flies with open hooks; None without loads on cables.
    """

    name: str
    source: Path
    base_link: str
    mass: float
    p_BoBcm_B: tuple[float, float, float]
    I_BBcm_B: tuple[tuple[float, float, float], ...]
    rotors: tuple[Rotor, ...]
    sensors: tuple[Sensor, ...]
    frames: tuple[VehicleFrame, ...]
    ground_clearance: float
    battery: BatteryPack | None = None
    joints: tuple[VehicleJoint, ...] = ()
    cables: tuple[str, ...] = ()
    contact_links: tuple[str, ...] = ()
    joint_signals: tuple[tuple[str, str], ...] = ()
    turned: TurnedBody | None = None
    servos: tuple[VehicleServo, ...] = ()
    tilts: tuple[Tilt, ...] = ()
    unloaded: "Vehicle | None" = None

    def with_hooks(self, opened: bool) -> "Vehicle":
        """Return what flies with its hooks open or closed."""
        return self.unloaded if opened and self.unloaded else self

    def free_servos(self, commanded: Collection[str] = ()) -> tuple[VehicleServo, ...]:
        """Return the servos that neither tilt rotors nor are commanded by the law.

        Args:
            commanded: joints whose servos the law commands.
        """
        taken = {*commanded, *(tilt.joint for tilt in self.tilts)}
        return tuple(each for each in self.servos if each.joint not in taken)

    @property
    def published_joints(self) -> dict[str, tuple[int, int]]:
        """Places of position and velocity of each freedom in `joint_signals`, by its name.

        Drake names positions and velocities `joint_q` and `joint_w`, or `joint_x` and `joint_v`;
        those of a ball joint are `joint_qx`, ..., which are its names here. What flies freely on
        cables is not among them: its frame moves.
        """
        at = dict(enumerate(self.joint_signals))
        loose = {name[:-3] for name, unit in self.joint_signals if unit == "1"}
        tied = [i for i, (name, _) in at.items() if name.rpartition("_")[0] not in loose]
        positions, velocities = tied[: len(tied) // 2], tied[len(tied) // 2 :]
        found = {}
        for first, second in zip(positions, velocities, strict=True):
            joint, _, suffix = at[second][0].rpartition("_")
            found[joint if suffix in ("w", "v") else at[first][0]] = (first, second)
        return found

    @property
    def published_joint_units(self) -> dict[str, str]:
        """Unit of the position of each published freedom, by its name: rad or m."""
        places = self.published_joints.items()
        return {name: self.joint_signals[place][1] for name, (place, _) in places}

    @property
    def small_joint_signals(self) -> tuple[tuple[str, str], ...]:
        """Names and units of joints' positions with small angles in place of quaternions (j), and
        of velocities (j), as linear models have them.
        """
        found = []
        for name, unit in self.joint_signals:
            if unit != "1":
                found.append((name, unit))
            elif not name.endswith("_qw"):  # the others are halves of small angles
                found.append((f"{name[:-2]}r{name[-1]}", "rad"))
        return tuple(found)

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
    def tilt_lag(self) -> float:
        """Time constant of the slowest servo that tilts rotors, 0 without any [s]."""
        tilting = {tilt.joint for tilt in self.tilts}
        lags = (each.servo.lag for each in self.servos if each.joint in tilting)
        return max(lags, default=0.0)

    @property
    def span(self) -> float:
        """Largest distance between two rotors' hubs [m]."""
        hubs = [rotor.p_BR for rotor in self.rotors]
        return max(math.dist(one, other) for one in hubs for other in hubs)

    def is_moved(self, link: str) -> bool:
        """Return whether a link moves relative to the base link."""
        return any(link in joint.links for joint in self.joints)

    @property
    def body_imus(self) -> tuple[Imu, ...]:
        """The IMUs that no joint moves; an estimator uses the first."""
        imus = (each for each in self.sensors if isinstance(each, Imu))
        return tuple(each for each in imus if not self.is_moved(each.link))

    def frame(self, name: str) -> VehicleFrame:
        """Return the frame of a link.

        Raises:
            WorkbenchError: if the link does not exist.
        """
        return find_named_row("frame", name, self.frames)


def slowest_rotor(vehicle: Vehicle) -> float:
    """Return the largest time constant of a rotor in hover [s], see `Vehicle.rotor_lag`."""
    return vehicle.rotor_lag
