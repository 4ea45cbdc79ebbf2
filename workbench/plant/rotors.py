"""Rotors: the constants of each, and the wrench of their thrusts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.gravity import AIR_DENSITY

MIN_LIFT_SHARE = 0.3
"""Share of thrust along body z below which a rotor does not contribute to hover: 73° of tilt."""
_THRUST_COEFFICIENT = 0.1
"""Thrust over density, squared revolutions per second, and the fourth power of the diameter.
Propellers of drones have 0.06 to 0.14 (UIUC propeller data base), so a diameter computed from it is
accurate to a fifth."""
_ROUNDING_SHARE = 1e-12
"""Share of the largest entry of a column of the allocation that counts as a rounding error."""
PROPELLER_DENSITY = 0.75
"""Mass of a propeller of two blades over the cube of its diameter [kg/m³]: 12 g at 10 in."""


@dataclass(frozen=True)
class Rotor:
    """One rotor, with the constants of Gazebo's motor model.

    Attributes:
        name: the joint's name, or another unique name.
        joint: the joint that turns, or "" where the description has none.
        link: the link that turns with it.
        p_BR: position of the hub R in the body frame B [m].
        axis_B: unit vector of thrust in B.
        direction: +1 turns counter-clockwise seen from the tip of `axis_B`, -1 clockwise.
        motor_constant: thrust over squared speed [N·s²].
        moment_constant: drag torque over thrust [m].
        time_constant_up: lag while speeding up [s].
        time_constant_down: lag while slowing down [s].
        max_rot_velocity: largest speed [rad/s].
        velocity_slowdown: the rotor is drawn turning slower by this factor.
        rotor_drag_coefficient: force against the velocity of the hub perpendicular to the axis,
            over speeds of rotor and hub [N / (rad/s · m/s)].
        rolling_moment_coefficient: moment against that velocity, over the same two speeds [N·m /
            (rad/s · m/s)].
        inertia: of all turning parts about the spin axis [kg·m²]; 0 if not stated.
        inflow_coefficient: thrust lost, over speeds of the rotor and of the hub through the air
            along the axis [N / (rad/s · m/s)]; `k_z` of RotorPy, `drag_coeff_z` of
            gym-pybullet-drones. See `systems.rotors`.
        ground_effect_coefficient: c of the share c (r / 4h)² by which thrust grows at the height h
            above the ground, r being the propeller's radius; `gnd_eff_coeff` of
            gym-pybullet-drones. See `systems.rotors`.
        propeller_radius: r of the ground effect [m].
        linear_motor_constant: thrust over speed, in addition to that over squared speed [N·s]: for
            a measured curve that is not exactly quadratic, such as those of the UIUC propeller data
            base, where the thrust coefficient grows with the speed.
    """

    name: str
    joint: str
    link: str
    p_BR: tuple[float, float, float]
    axis_B: tuple[float, float, float]
    direction: int
    motor_constant: float
    moment_constant: float
    time_constant_up: float
    time_constant_down: float
    max_rot_velocity: float
    velocity_slowdown: float = 10.0
    rotor_drag_coefficient: float = 0.0
    rolling_moment_coefficient: float = 0.0
    inertia: float = 0.0
    inflow_coefficient: float = 0.0
    ground_effect_coefficient: float = 0.0
    propeller_radius: float = 0.0
    linear_motor_constant: float = 0.0

    @property
    def max_thrust(self) -> float:
        """Thrust at the largest speed [N]."""
        most = self.max_rot_velocity
        return self.motor_constant * most**2 + self.linear_motor_constant * most

    @cached_property
    def linear_speed(self) -> float:
        """Speed at which the linear part of thrust is as large as the squared one [rad/s].

        With w for the speed, thrust is motor_constant w (w + linear_speed).
        """
        return self.linear_motor_constant and self.linear_motor_constant / self.motor_constant

    @property
    def lifts(self) -> bool:
        """Whether it contributes to hover; a rotor that pushes forwards or down stays at rest."""
        return self.axis_B[2] > MIN_LIFT_SHARE


def propeller_diameter(motor_constant: float) -> float:
    """Return an estimate of the diameter of a propeller from its motor constant [m]."""
    squared = motor_constant * (2.0 * math.pi) ** 2
    return float((squared / (_THRUST_COEFFICIENT * AIR_DENSITY)) ** 0.25)


def propeller_inertia(diameter: float) -> float:
    """Return an estimate of the inertia about its axis of a propeller with two blades [kg·m²].

    It is that of thin rods, for a diameter [m].
    """
    return PROPELLER_DENSITY * diameter**5 / 12.0


def wrench_matrix(rotors: Sequence[Rotor], p_BoBcm_B: Sequence[float]) -> np.ndarray:
    """Return the 6 x n matrix from thrusts [N] to force and moment about the centre of mass, in B.

    Drag turns the body against the rotor: the moment of a counter-clockwise rotor (direction +1) is
    -moment_constant times its thrust along its axis.
    """
    axes = np.array([rotor.axis_B for rotor in rotors])
    arms = np.array([rotor.p_BR for rotor in rotors]) - np.array(p_BoBcm_B)
    drags = np.array([-rotor.direction * rotor.moment_constant for rotor in rotors])
    return np.hstack([axes, np.cross(arms, axes) + drags[:, None] * axes]).T


class TiltColumn(Protocol):
    """What the allocation knows of a joint that tilts rotors, see `plant.tilt.Tilt`."""

    def column(self, rotors: Sequence[Rotor], p_BoBcm_B: Sequence[float]) -> np.ndarray:
        """Return force and moment about the centre of mass per angle and thrust (6) [1, m]."""


def rotor_rank(rotors: Sequence[Rotor]) -> int:
    """Return how many of thrust, roll, pitch and yaw rotors control independently, up to 4."""
    lifting = np.array([rotor.lifts for rotor in rotors])
    return _rank(wrench_matrix(rotors, (0.0, 0.0, 0.0))[2:] * lifting)


def _rank(rows: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(rows, tol=1e-9 * max(1.0, float(np.abs(rows).max()))))


def allocation_matrix(
    rotors: Sequence[Rotor], p_BoBcm_B: Sequence[float], tilts: Sequence[TiltColumn] = ()
) -> np.ndarray:
    """Return the n x 4 matrix from (force along z [N], moments x, y, z [N·m]) to thrusts [N].

    It is the pseudo-inverse of the last four rows of the wrench matrix: of all thrusts with the
    required wrench it yields those with the least norm. Rotors that do not lift have rows of zeros.

    With m tilts there are m more rows: of the thrust that each turns sideways [N].

    Raises:
        WorkbenchError: if the rotors cannot produce the four independently.
    """
    lifting = np.array([rotor.lifts for rotor in rotors])
    if not lifting.any():
        raise WorkbenchError(
            "no rotor pushes upwards along the base link's z, which must point up: check the "
            "rotors' axes"
        )
    rows = wrench_matrix(rotors, p_BoBcm_B)[2:] * lifting
    if tilts:
        turned = [tilt.column(rotors, p_BoBcm_B)[2:] for tilt in tilts]
        rows = np.hstack([rows, np.transpose(turned)])
    rank = _rank(rows)
    if rank < 4:
        raise WorkbenchError(
            f"the {len(rotors)} rotors cannot control thrust, roll, pitch and yaw independently "
            f"(rank {rank} of 4{_bound(rows)}): check rotor positions and turning directions"
        )
    allocation = np.linalg.pinv(rows)
    n = len(rotors)
    allocation[:n][~lifting] = 0.0  # exactly: the inverse leaves rounding errors
    small = np.abs(allocation) < _ROUNDING_SHARE * np.abs(allocation).max(axis=0)
    small[:n] = False
    allocation[small] = 0.0
    if allocation[:n][lifting, 0].min() <= 0.0:
        raise WorkbenchError(
            "to hover, some rotors would have to push downwards: check the rotors' axes and "
            "turning directions, and that the centre of mass lies between them"
        )
    return allocation


def _bound(rows: np.ndarray) -> str:
    """Return a clause on what of (thrust, roll, pitch, yaw) rotors cannot make independently."""
    scaled = rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), 1e-12)
    weights = np.abs(np.linalg.svd(scaled)[0][:, -1])
    names = [
        name
        for name, weight in zip(("thrust", "roll", "pitch", "yaw"), weights, strict=True)
        if weight > 0.1
    ]
    if len(names) == 1:
        return f", without {names[0]}"
    return f", {' and '.join(names)} go together" if len(names) == 2 else ""
