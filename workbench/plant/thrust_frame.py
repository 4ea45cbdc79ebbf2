"""The frame in which a vehicle hovers level, which is not always its body frame.

If the rotors are tilted to one side, or inwards around an off-centre centre of mass, their total
force is not along body z, and the body is not level in hover. T is the frame at the origin of B
with its z axis along the lift of the rotors. For most vehicles it is B itself.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np

from workbench.common.vectors import float_triple
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor, allocation_matrix, wrench_matrix
from workbench.plant.tilt import Tilt

IDLE_SPEED_SHARE = 0.1
"""Armed rotors turn at this share of their largest speed, and never slower while flying."""
IDLE_HOVER_SHARE = 0.1
"""Limit of the idle thrust of a rotor, as a share of its hover thrust."""
_UPRIGHT_TILT_RAD = 1e-9
"""A smaller tilt counts as a rounding error [rad]."""
_LIFT_ITERATIONS = 60
"""Number of iterations for the direction of lift; each gains a digit or more."""


class RotorBody(Protocol):
    """The attributes of a vehicle that determine the lift of its rotors, see `Vehicle`."""

    @property
    def mass(self) -> float:
        """All-up [kg]."""

    @property
    def rotors(self) -> tuple[Rotor, ...]:
        """In the order of the description."""

    @property
    def p_BoBcm_B(self) -> tuple[float, float, float]:
        """The centre of mass [m]."""

    @property
    def inertia(self) -> np.ndarray:
        """About the centre of mass (3, 3) [kg·m²]."""

    @property
    def tilts(self) -> tuple[Tilt, ...]:
        """Servos that tilt rotors, as far as the allocation needs them."""


@dataclass(frozen=True)
class ThrustFrame:
    """The attributes of a vehicle that the law uses, in T; arrays cannot be changed.

    Attributes:
        R_BT: orientation in the body (3, 3).
        rotors: with positions and axes in T.
        p_ToTcm_T: the centre of mass [m].
        inertia_T: about the centre of mass (3, 3) [kg·m²].
        mass: all-up [kg].
        tilts: with points and axes in T (m).
    """

    R_BT: np.ndarray
    rotors: tuple[Rotor, ...]
    p_ToTcm_T: tuple[float, float, float]
    inertia_T: np.ndarray
    mass: float
    tilts: tuple[Tilt, ...] = ()

    @property
    def q_BT(self) -> list[float]:
        """Orientation in the body as a unit quaternion w, x, y, z."""
        from pydrake.math import RotationMatrix  # reading a Vehicle does not load Drake

        return [float(q) for q in RotationMatrix(self.R_BT).ToQuaternion().wxyz()]

    @cached_property
    def allocation(self) -> np.ndarray:
        """Matrix from force along z of T [N] and moments [N·m] to thrusts (n, 4) [N].

        With tilts to thrusts and their angles (n + m, 4) [N, rad].
        """
        found = allocation_matrix(self.rotors, self.p_ToTcm_T, self.tilts)
        n = len(self.rotors)
        hover = found[:n, 0] * self.mass * GRAVITY
        for row, tilt in zip(found[n:], self.tilts, strict=True):
            row /= sum(hover[each.rotor] for each in tilt.turns)
        return _fixed(found)

    @cached_property
    def effects(self) -> np.ndarray:
        """Matrix from thrusts [N], and angles [rad], to force and moments (4, n + m)."""
        lifting = np.array([rotor.lifts for rotor in self.rotors])
        columns = [*(wrench_matrix(self.rotors, self.p_ToTcm_T)[2:] * lifting).T]
        for tilt in self.tilts:
            hover = sum(self.hover_thrusts[each.rotor] for each in tilt.turns)
            columns.append(hover * tilt.column(self.rotors, self.p_ToTcm_T)[2:])
        return _fixed(np.array(columns).T)

    @cached_property
    def hover_thrusts(self) -> np.ndarray:
        """Thrusts that hold the vehicle still, (n) [N]."""
        return _fixed(self.allocation[: len(self.rotors), 0] * self.mass * GRAVITY)

    @cached_property
    def hover_speeds(self) -> np.ndarray:
        """Rotor speeds that hold the vehicle still, (n) [rad/s]."""
        constants = np.array([rotor.motor_constant for rotor in self.rotors])
        half = 0.5 * np.array([rotor.linear_speed for rotor in self.rotors])
        return _fixed(np.sqrt(half**2 + self.hover_thrusts / constants) - half)

    @cached_property
    def idle_thrusts(self) -> np.ndarray:
        """Smallest thrusts of turning rotors, (n) [N]; 0 for those that do not lift."""
        most = np.array([rotor.max_thrust for rotor in self.rotors])
        linear = np.array([r.linear_motor_constant * r.max_rot_velocity for r in self.rotors])
        # the linear part is proportional to the speed, the rest to its square
        idle = IDLE_SPEED_SHARE**2 * most + IDLE_SPEED_SHARE * (1.0 - IDLE_SPEED_SHARE) * linear
        return _fixed(np.minimum(idle, IDLE_HOVER_SHARE * self.hover_thrusts))

    @cached_property
    def spin_up_time(self) -> float:
        """Lead of spin-up torque over drag torque in yaw, at hover [s].

        Rotors that change the yaw moment of their drag at dm/dt also produce spin_up_time dm/dt by
        their change of speed. The zero of the yaw loop is at the inverse of this time.
        """
        n = len(self.rotors)
        turning = zip(self.rotors, self.hover_speeds, self.allocation[:n, 3], strict=True)
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
        """Return the roll, pitch and yaw of the body for which T has the given ones [rad]."""
        if np.array_equal(self.R_BT, np.eye(3)):
            return list(roll_pitch_yaw)
        from pydrake.math import RollPitchYaw, RotationMatrix

        R_WT = RotationMatrix(RollPitchYaw(np.array(roll_pitch_yaw, dtype=float)))
        R_WB = R_WT @ RotationMatrix(self.R_BT).inverse()
        return [float(angle) for angle in RollPitchYaw(R_WB).vector()]


@lru_cache(maxsize=64)
def thrust_frame(vehicle: RotorBody) -> ThrustFrame:
    """Return the thrust frame of a vehicle; gains, trims and limits ask for it many times."""
    R_BT = _rotation_of_z_to(lift_direction(vehicle))
    return ThrustFrame(
        R_BT=_fixed(R_BT),
        rotors=tuple(_rotor_in_thrust_frame(rotor, R_BT) for rotor in vehicle.rotors),
        p_ToTcm_T=float_triple(R_BT.T @ vehicle.p_BoBcm_B),
        inertia_T=_fixed(R_BT.T @ vehicle.inertia @ R_BT),
        mass=vehicle.mass,
        tilts=tuple(tilt.turned_by(R_BT.T) for tilt in vehicle.tilts),
    )


def _fixed(array: np.ndarray) -> np.ndarray:
    """Return an array that several callers share, so that none can change it."""
    array.setflags(write=False)
    return array


def lift_direction(vehicle: RotorBody) -> np.ndarray:
    """Return the unit vector of the lift of the rotors in B.

    Along it a force without moment needs the smallest thrusts. Let F and M be the rows of the
    wrench matrix for force and moment, and P the projection onto thrusts without moment. The
    smallest thrusts for a force along n are proportional to P Fᵀ n, and produce the force F P Fᵀ n.
    It is along n if n is an eigenvector, which power iteration from body z finds.
    """
    lifting = np.array([rotor.lifts for rotor in vehicle.rotors])
    wrench = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[:, lifting]
    force, moment = wrench[:3], wrench[3:]
    if vehicle.tilts:  # which make the yaw moment
        moment = moment[:2]
    free = np.eye(wrench.shape[1]) - np.linalg.pinv(moment) @ moment
    lift = force @ free @ force.T
    upright = np.array([0.0, 0.0, 1.0])
    direction = upright
    for _ in range(_LIFT_ITERATIONS):
        direction = lift @ direction
        direction /= np.linalg.norm(direction)
    thrusts = free @ force.T @ direction
    if np.hypot(direction[0], direction[1]) < _UPRIGHT_TILT_RAD or thrusts.min() <= 0.0:
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


def _rotor_in_thrust_frame(rotor: Rotor, R_BT: np.ndarray) -> Rotor:
    return dataclasses.replace(
        rotor, p_BR=float_triple(R_BT.T @ rotor.p_BR), axis_B=float_triple(R_BT.T @ rotor.axis_B)
    )
