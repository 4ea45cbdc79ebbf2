"""What acts in a ball joint besides Drake's damping.

With the rotation of the child in the parent as a unit vector n and an angle a, and the relative
angular velocity w:

    spring     -k a n
    limit      -(k_s (a - A) + c n·w) n beyond the largest angle A, if that pushes back
    friction   -F w_i / sqrt(w_i² + V²) about each axis i of the child: dry friction F, smoothed

n has the same components in parent and child. As for the limits of other joints, k_s and c come
from the inertia that turns about n, see `joint_forces`. MuJoCo defines the three alike.

Drake has a ball joint's rotation as roll, pitch and yaw, which have no rates at a pitch of 90°.
They are those of a frame M that is fixed in the child C. Before a pitch exceeds
`MAX_BALL_PITCH_RAD`, a flight turns M in C so that the angles begin at zero anew. The velocities
remain: they are those of the child in the parent.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import atan2, cos, sin, sqrt
from pydrake.multibody.plant import MultibodyPlant

from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.plant.model import Model
from workbench.plant.multibody import mobility

STOP_RATE_RAD_S = 100.0
"""Natural frequency of what is pressed against a limit: a steady load of an acceleration a goes
a / STOP_RATE² beyond it."""
STOP_DAMPING_RATIO = 0.5
FRICTION_SPEED = 0.01
"""Velocity over which dry friction is smoothed [rad/s or m/s]."""
MAX_BALL_PITCH_RAD = math.radians(60.0)
"""Largest pitch of a ball joint in a flight: the rates of its angles grow with 1 / cos."""
_NO_TURN = 1e-16
"""Square of half an angle [rad²] below which its rotation has no axis."""


class BallRow(NamedTuple):
    """A ball joint; places are those in the state and the forces of the plant.

    Attributes:
        name: of the joint.
        position: place of the first of its three angles.
        velocity: place of the first of its angular velocity in the parent among the velocities.
        max_angle: A, inf without a limit.
        friction: F.
        damping: Drake's, in the plant.
        stiffness: k.
        mobility: angular acceleration by torque, both in the parent, where all joints begin (3, 3).
    """

    name: str
    position: int
    velocity: int
    max_angle: float
    friction: float
    damping: float
    stiffness: float
    mobility: np.ndarray

    @property
    def acts(self) -> bool:
        """Whether there is any torque."""
        return bool(self.friction or self.stiffness) or self.max_angle < np.inf


def ball_rows(plant: MultibodyPlant, model: Model) -> tuple[BallRow, ...]:
    """Return the ball joints of a finalised plant.

    Args:
        plant: with the vehicle.
        model: of bodies, from `merged_model`, of which it was made.
    """
    balls = [joint for joint in model.joints if joint.freedoms[0].kind == "ball"]
    if not balls:
        return ()
    inverse = mobility(plant, plant.CreateDefaultContext())
    rows = []
    for joint in balls:
        (freedom,), made = joint.freedoms, plant.GetJointByName(joint.name)
        own = slice(made.velocity_start(), made.velocity_start() + 3)
        rows.append(
            BallRow(
                name=joint.name,
                position=made.position_start(),
                velocity=own.start,
                max_angle=freedom.upper,
                friction=freedom.friction,
                damping=freedom.damping,
                stiffness=freedom.stiffness,
                mobility=inverse[own, own],
            )
        )
    return tuple(rows)


def ball_torque(row: BallRow, q_PC: Sequence[Any], w_PC_P: Sequence[Any]) -> list[Any]:
    """Return the torque on the child of a ball joint in the parent (3) [N m].

    Args:
        row: the joint.
        q_PC: rotation of the child in the parent, a quaternion w, x, y, z with w of 0 or more (4).
        w_PC_P: angular velocity of the child in the parent (3) [rad/s].
    """
    torque = [0.0 * w_PC_P[0]] * 3
    half = q_PC[1] * q_PC[1] + q_PC[2] * q_PC[2] + q_PC[3] * q_PC[3]
    turned = [2.0 * x for x in q_PC[1:]]  # the angle times n
    if half > _NO_TURN:
        size = sqrt(half)
        angle = 2.0 * atan2(size, q_PC[0])
        n = [x / size for x in q_PC[1:]]
        turned = [angle * x for x in n]
        if angle > row.max_angle:
            inertia = 1.0 / sum(
                row.mobility[i, j] * n[i] * n[j] for i in range(3) for j in range(3)
            )
            rate = sum(a * b for a, b in zip(n, w_PC_P, strict=True))
            stop = (
                inertia
                * STOP_RATE_RAD_S
                * (STOP_RATE_RAD_S * (angle - row.max_angle) + 2.0 * STOP_DAMPING_RATIO * rate)
            )
            if stop > 0.0:
                torque = [-stop * x for x in n]
    if row.stiffness:
        torque = [a - row.stiffness * b for a, b in zip(torque, turned, strict=True)]
    if row.friction:
        R_PC = rotation(q_PC)
        rubbed = [
            -row.friction * x / sqrt(x * x + FRICTION_SPEED**2) for x in into_body(R_PC, w_PC_P)
        ]
        torque = [a + b for a, b in zip(torque, into_world(R_PC, rubbed), strict=True)]
    return torque


def ball_quaternion(angles: Sequence[Any], q_MC: Sequence[Any]) -> list[Any]:
    """Return the rotation of the child C in the parent (4): w, x, y, z, with w of 0 or more.

    Args:
        angles: Drake's roll, pitch and yaw of M in the parent (3) [rad].
        q_MC: rotation of the child in M, a quaternion (4).
    """
    (a, b, c), (x, y, z) = ([turn(0.5 * each) for each in angles] for turn in (cos, sin))
    w = a * b * c + x * y * z
    v = x * b * c - a * y * z, a * y * c + x * b * z, a * b * z - x * y * c
    u, e = q_MC[0], q_MC[1:]
    real = w * u - sum(i * j for i, j in zip(v, e, strict=True))
    found = [real, *(w * i + u * j + k for i, j, k in zip(e, v, cross(v, e), strict=True))]
    return [-each for each in found] if found[0] < 0.0 else found
