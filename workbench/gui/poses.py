"""Poses of frames, the tree of a vehicle's frames, and viewpoints."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.systems.sensors.mounting import unit_rotation


@dataclass(frozen=True)
class Pose:
    """A pose of a frame in another one.

    Attributes:
        p: position (3) [m].
        R: orientation (3, 3).
    """

    p: np.ndarray
    R: np.ndarray

    def after(self, parent: "Pose") -> "Pose":
        """Return this pose in the frame in which the parent's pose is given."""
        return Pose(parent.p + parent.R @ self.p, parent.R @ self.R)

    def roll_pitch_yaw(self) -> tuple[float, float, float]:
        """Return the orientation as angles about the fixed axes x, y and z in turn [rad]."""
        R = self.R
        pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
        roll, yaw = np.arctan2(R[2, 1], R[2, 2]), np.arctan2(R[1, 0], R[0, 0])
        return float(roll), float(pitch), float(yaw)


ORIGIN_POSE = Pose(np.zeros(3), np.eye(3))


def rotation_of(q: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the matrix of a quaternion w, x, y, z, normalised."""
    return unit_rotation(np.asarray(q, dtype=float) / max(float(np.linalg.norm(q)), 1e-12))


def rotation_from_angles(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Return the orientation with these angles about the fixed axes x, y and z in turn [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def frame_pairs(about: Mapping[str, object]) -> tuple[tuple[str, str], ...]:
    """Return parent and child of each frame, as in the topic."""
    said = about.get("frames", ())
    assert isinstance(said, list | tuple)
    return tuple((str(parent), str(child)) for parent, child in said)


def poses_in_parent(numbers: Sequence[float]) -> tuple[Pose, ...]:
    """Return the poses in a message: position and quaternion w, x, y, z of each frame."""
    table = np.asarray(numbers, dtype=float).reshape(-1, 7)
    return tuple(Pose(row[:3], rotation_of(row[3:])) for row in table)


def poses_in_world(pairs: Sequence[tuple[str, str]], poses: Sequence[Pose]) -> Mapping[str, Pose]:
    """Return the pose of each frame in W, by name; a parent precedes its children."""
    found: dict[str, Pose] = {}
    for (parent, child), pose in zip(pairs, poses, strict=False):
        found[child] = pose.after(found.get(parent, ORIGIN_POSE))
    return found


@dataclass(frozen=True)
class Viewpoint:
    """Viewpoint of a parallel projection.

    Attributes:
        turn: rotation about z; at 0 the eye is behind, and x points away from it [rad].
        tilt: elevation of the eye; a quarter turn looks straight down [rad].
        width: visible width [m].
    """

    turn: float = 0.0
    tilt: float = math.pi / 2
    width: float = 40.0

    def axes(self) -> np.ndarray:
        """Return right, up and away of the picture, as rows (3, 3)."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        ct, st = math.cos(self.tilt), math.sin(self.tilt)
        ahead = np.array([c, s, 0.0])
        right = np.array([s, -c, 0.0])
        up = st * ahead + ct * np.array([0.0, 0.0, 1.0])
        away = ct * ahead - st * np.array([0.0, 0.0, 1.0])
        return np.vstack([right, up, away])

    def project(self, points: np.ndarray, width: float, height: float) -> np.ndarray:
        """Return pixels right and down, and the distance away, of points (n, 3)."""
        seen = points @ self.axes().T
        scale = width / self.width
        seen[:, 0] = 0.5 * width + scale * seen[:, 0]
        seen[:, 1] = 0.5 * height - scale * seen[:, 1]
        return seen
