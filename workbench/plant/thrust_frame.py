"""The frame that a vehicle hovers upright in, which is not always its body's.

Where rotors lean one way, or lean inwards around a centre of mass that lies beside the middle,
their forces do not add up along body z, and hover is not level. T is the frame at the body's
origin whose z axis is the direction in which the rotors lift; for most vehicles it is B itself.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor, allocation_matrix, wrench_matrix

IDLE_SPEED_SHARE = 0.1
"""Armed rotors turn at this share of their largest speed, and never slower while flying."""
IDLE_HOVER_SHARE = 0.1
"""But idling they give no more than this share of their hover thrust, however strong they are."""
_UPRIGHT = 1e-9
"""A lean smaller than this is rounding [rad]."""
_ROUNDS = 60
"""Of the iteration for the direction of lift; each gains a digit or more."""


class RotorBody(Protocol):
    """What of a vehicle decides where its rotors lift; see `Vehicle`."""

    @property
    def mass(self) -> float:
        """All-up [kg]."""

    @property
    def rotors(self) -> tuple[Rotor, ...]:
        """In their order."""

    @property
    def p_BoBcm_B(self) -> tuple[float, float, float]:
        """The centre of mass [m]."""

    @property
    def inertia(self) -> np.ndarray:
        """About the centre of mass (3, 3) [kg·m²]."""


@dataclass(frozen=True)
class ThrustFrame:
    """What the law reads of a vehicle, given in T.

    Attributes:
        R_BT: orientation in the body (3, 3).
        rotors: with places and axes in T.
        p_ToTcm_T: the centre of mass [m].
        inertia_T: about the centre of mass (3, 3) [kg·m²].
        mass: all-up [kg].
    """

    R_BT: np.ndarray
    rotors: tuple[Rotor, ...]
    p_ToTcm_T: tuple[float, float, float]
    inertia_T: np.ndarray
    mass: float

    @property
    def q_BT(self) -> list[float]:
        """Orientation in the body as a unit quaternion w, x, y, z."""
        from pydrake.math import RotationMatrix  # who reads a Vehicle need not load Drake

        return [float(q) for q in RotationMatrix(self.R_BT).ToQuaternion().wxyz()]

    @property
    def allocation(self) -> np.ndarray:
        """From force along z of T [N] and moments [N·m] to thrusts (n, 4) [N]."""
        return allocation_matrix(self.rotors, self.p_ToTcm_T)

    @property
    def hover_thrusts(self) -> np.ndarray:
        """Thrusts that hold the vehicle still, (n) [N]."""
        return self.allocation[:, 0] * self.mass * GRAVITY

    @property
    def hover_speeds(self) -> np.ndarray:
        """Rotor speeds that hold the vehicle still, (n) [rad/s]."""
        constants = np.array([rotor.motor_constant for rotor in self.rotors])
        half = 0.5 * np.array([rotor.linear_speed for rotor in self.rotors])
        speeds: np.ndarray = np.sqrt(half**2 + self.hover_thrusts / constants) - half
        return speeds

    @property
    def idle_thrusts(self) -> np.ndarray:
        """Least thrusts of rotors that turn, (n) [N]; 0 for those that do not lift."""
        most = np.array([rotor.max_thrust for rotor in self.rotors])
        linear = np.array([r.linear_motor_constant * r.max_rot_velocity for r in self.rotors])
        # the linear part falls with the speed, all else with its square
        idle = IDLE_SPEED_SHARE**2 * most + IDLE_SPEED_SHARE * (1.0 - IDLE_SPEED_SHARE) * linear
        return np.minimum(idle, IDLE_HOVER_SHARE * self.hover_thrusts)

    @property
    def spin_up_time(self) -> float:
        """By how much spin-up torque leads drag torque in yaw, at hover [s].

        Rotors that change a yaw moment of their drag by dm/dt make spin_up_time dm/dt besides, as
        they turn faster and slower for it: the zero of the yaw loop is at one over it.
        """
        turning = zip(self.rotors, self.hover_speeds, self.allocation[:, 3], strict=True)
        return float(
            sum(
                -rotor.direction
                * rotor.axis_B[2]
                * rotor.inertia
                * share
                / (2.0 * rotor.motor_constant * speed + rotor.linear_motor_constant)
                for rotor, speed, share in turning
                if speed > 0.0
            )
        )

    def roll_pitch_yaw(self, roll_pitch_yaw: Sequence[float]) -> list[float]:
        """Return the body's roll, pitch, yaw that give T the wanted ones [rad]."""
        if np.array_equal(self.R_BT, np.eye(3)):
            return list(roll_pitch_yaw)
        from pydrake.math import RollPitchYaw, RotationMatrix

        R_WT = RotationMatrix(RollPitchYaw(np.array(roll_pitch_yaw, dtype=float)))
        R_WB = R_WT @ RotationMatrix(self.R_BT).inverse()
        return [float(angle) for angle in RollPitchYaw(R_WB).vector()]


def thrust_frame(vehicle: RotorBody) -> ThrustFrame:
    """Return the thrust frame of a vehicle."""
    R_BT = _rotation_of_z_to(lift_direction(vehicle))
    return ThrustFrame(
        R_BT=R_BT,
        rotors=tuple(_seen_from(rotor, R_BT) for rotor in vehicle.rotors),
        p_ToTcm_T=_triple(R_BT.T @ vehicle.p_BoBcm_B),
        inertia_T=R_BT.T @ vehicle.inertia @ R_BT,
        mass=vehicle.mass,
    )


def lift_direction(vehicle: RotorBody) -> np.ndarray:
    """Return the unit vector in B along which the rotors lift.

    It is the one along which a force without moment takes the least thrusts. With F and M the
    rows of the wrench matrix for force and moment, and P the projection onto thrusts without
    moment, the least thrusts for a force along n are proportional to P Fᵀ n, and make the force
    F P Fᵀ n; that is along n for eigenvectors, and power iteration from body z finds the one.
    """
    lifting = np.array([rotor.lifts for rotor in vehicle.rotors])
    wrench = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[:, lifting]
    force, moment = wrench[:3], wrench[3:]
    free = np.eye(wrench.shape[1]) - np.linalg.pinv(moment) @ moment
    lift = force @ free @ force.T
    upright = np.array([0.0, 0.0, 1.0])
    direction = upright
    for _ in range(_ROUNDS):
        direction = lift @ direction
        direction /= np.linalg.norm(direction)
    thrusts = free @ force.T @ direction
    if np.hypot(direction[0], direction[1]) < _UPRIGHT or thrusts.min() <= 0.0:
        return upright
    return direction


def _rotation_of_z_to(direction: np.ndarray) -> np.ndarray:
    """Return the shortest rotation that turns z to a unit vector with positive z (Rodrigues)."""
    x, y, z = direction
    share = 1.0 / (1.0 + z)
    return np.array(
        [
            [1.0 - share * x * x, -share * x * y, x],
            [-share * x * y, 1.0 - share * y * y, y],
            [-x, -y, z],
        ]
    )


def _seen_from(rotor: Rotor, R_BT: np.ndarray) -> Rotor:
    return dataclasses.replace(
        rotor, p_BR=_triple(R_BT.T @ rotor.p_BR), axis_B=_triple(R_BT.T @ rotor.axis_B)
    )


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
