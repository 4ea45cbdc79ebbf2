"""Convert the axes of autopilots, north-east-down and forward-right-down, to ours.

And quaternions to roll, pitch and yaw.
"""

import numpy as np

from workbench.logs.readers.rotations import continuous, quaternion_from_angles
from workbench.scenario.attitude_axes import tilt_angles


def angles(q: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw (n, 3) of quaternions B to W (n, 4), w first.

    R = Rz(yaw) Ry(pitch) Rx(roll), as in `position_data`.
    """
    w, x, y, z = q.T
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.column_stack([*tilt_angles(q), yaw])


def from_ned_frd(q: np.ndarray) -> np.ndarray:
    """Return quaternions FLU to ENU (n, 4), w first, for those FRD to NED.

    q_ENU = q_T q_NED q_F: q_T turns NED into ENU (half a turn about x + y), q_F FRD into FLU (half
    a turn about x), see PX4's and MAVROS's conversions.
    """
    half = np.sqrt(0.5)
    w, x, y, z = q.T
    return np.column_stack([half * (w + z), half * (x + y), half * (x - y), half * (w - z)])


def enu(ned: np.ndarray) -> np.ndarray:
    """Return vectors east, north, up (n, 3) for vectors north, east, down."""
    return np.asarray(ned[:, [1, 0, 2]] * [1.0, 1.0, -1.0])


def flu(frd: np.ndarray) -> np.ndarray:
    """Return vectors forward, left, up (n, 3) for vectors forward, right, down."""
    return np.asarray(frd * [1.0, -1.0, -1.0])


def quaternion_in_enu(q: np.ndarray) -> np.ndarray:
    """Return attitudes (n, 4) from those of the body's axes FRD in NED (n, 4), without jumps."""
    return continuous(from_ned_frd(q))


def quaternion_of_angles(angles: np.ndarray) -> np.ndarray:
    """Return attitudes (n, 4) from roll, pitch and yaw of FRD in NED (n, 3) [rad]."""
    return quaternion_in_enu(quaternion_from_angles(*angles.T))
