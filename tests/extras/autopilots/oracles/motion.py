"""What an autopilot is told in these tests, in no autopilot's frames: W is east, north, up.

T is the body's frame, x forward, y left, z up. Each oracle turns both into its own frames.
"""

from typing import NamedTuple

import numpy as np

R_NED_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
R_FRD_FLU = np.diag([1.0, -1.0, -1.0])


class Motion(NamedTuple):
    """Position, velocity and acceleration in W, attitude R_WT, rates in T; the voltage's share."""

    p: np.ndarray
    v: np.ndarray
    a: np.ndarray
    R: np.ndarray
    w: np.ndarray
    voltage: float


class Wish(NamedTuple):
    """What is asked for: position, where it counts, velocity and acceleration in W.

    And a yaw rate about world z.
    """

    p: np.ndarray
    holds_xy: bool
    holds_z: bool
    v: np.ndarray
    a: np.ndarray
    yaw_rate: float


class Rotor(NamedTuple):
    """Force along z of T and moment in T, over its thrust; and thrust over w (w + linear_speed)."""

    force: float
    moment: np.ndarray
    motor_constant: float
    linear_speed: float


def wrench(rotors, thrusts) -> np.ndarray:
    """Return force along z of T and moment in T of the rotors' thrusts."""
    columns = np.array([[rotor.force, *rotor.moment] for rotor in rotors]).T
    return columns @ np.asarray(thrusts)


def thrust_at(rotor, speed) -> float:
    """Return a rotor's thrust [N] at a speed [rad/s]."""
    return rotor.motor_constant * speed * (speed + rotor.linear_speed)


def clip(x, most):
    """Return x within -most .. most."""
    return np.minimum(np.maximum(x, -most), most)


def cross(a, b) -> np.ndarray:
    """Return the vector product: numpy's is slow for two vectors."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def multiply(p, q) -> np.ndarray:
    """Return the product of two quaternions w, x, y, z."""
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.array([w, *(p[0] * q[1:] + q[0] * p[1:] + cross(p[1:], q[1:]))])


def inverse(q) -> np.ndarray:
    """Return the inverse of a unit quaternion."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def quaternion(R) -> np.ndarray:
    """Return a unit quaternion w, x, y, z of a rotation matrix, the largest part of it positive.

    Each part is had of the one matrix of the four products of two parts.
    """
    x, y, z = R[0, 0], R[1, 1], R[2, 2]
    products = np.array(
        [
            [1 + x + y + z, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], 1 + x - y - z, R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], 1 - x + y - z, R[1, 2] + R[2, 1]],
            [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], 1 - x - y + z],
        ]
    )
    row = products[np.argmax(np.diag(products))]
    return row / np.linalg.norm(row)


def matrix(q) -> np.ndarray:
    """Return the matrix of a unit quaternion: v goes to v + 2 w (u x v) + 2 u x (u x v)."""
    u = np.array([[0, -q[3], q[2]], [q[3], 0, -q[1]], [-q[2], q[1], 0]])
    return np.eye(3) + 2.0 * q[0] * u + 2.0 * u @ u
