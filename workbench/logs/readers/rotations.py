"""Convert attitudes of logs to those of the workbench: quaternions, roll, pitch and yaw."""

import numpy as np

ANGLES = ("roll", "pitch", "yaw")
QUATERNION = ("q_w", "q_x", "q_y", "q_z")


def continuous(q: np.ndarray) -> np.ndarray:
    """Return unit quaternions (n, 4), w first, with signs that do not jump between rows."""
    norm = np.linalg.norm(q, axis=1, keepdims=True)
    q = np.divide(q, norm, out=np.full(q.shape, np.nan), where=norm > 0.0)
    flips = np.sum(q[1:] * q[:-1], axis=1) < 0.0
    sign = np.cumprod(np.where(flips, -1.0, 1.0))
    return np.asarray(q * np.concatenate([[1.0], sign])[:, None]) if len(q) else q


def angles(q: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw (n, 3) of quaternions B to W (n, 4), w first.

    R = Rz(yaw) Ry(pitch) Rx(roll), as in `position_data`.
    """
    w, x, y, z = q.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.column_stack([roll, pitch, yaw])


def quaternion(roll: np.ndarray, pitch: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Return quaternions B to W (n, 4), w first, for roll, pitch and yaw (n), see `angles`."""
    c_r, c_p, c_y = (np.cos(0.5 * angle) for angle in (roll, pitch, yaw))
    s_r, s_p, s_y = (np.sin(0.5 * angle) for angle in (roll, pitch, yaw))
    return np.column_stack(
        [
            c_r * c_p * c_y + s_r * s_p * s_y,
            s_r * c_p * c_y - c_r * s_p * s_y,
            c_r * s_p * c_y + s_r * c_p * s_y,
            c_r * c_p * s_y - s_r * s_p * c_y,
        ]
    )


def in_world(q: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors in W (n, 3) for vectors in B."""
    w, part = q[:, :1], q[:, 1:]
    twice = 2.0 * np.cross(part, vectors)
    return np.asarray(vectors + w * twice + np.cross(part, twice))


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
