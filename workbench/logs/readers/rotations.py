"""Convert attitudes of logs to those of the workbench: quaternions, roll, pitch and yaw."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.logs.flight_record import Signal

ANGLES = ("roll", "pitch", "yaw")
QUATERNION = ("q_w", "q_x", "q_y", "q_z")


def continuous(q: np.ndarray) -> np.ndarray:
    """Return unit quaternions (n, 4), w first, with signs that do not jump between rows."""
    norm = np.linalg.norm(q, axis=1, keepdims=True)
    q = np.divide(q, norm, out=np.full(q.shape, np.nan), where=norm > 0.0)
    known = np.flatnonzero(np.isfinite(q).all(axis=1))
    flips = np.sum(q[known[1:]] * q[known[:-1]], axis=1) < 0.0
    q[known[1:]] *= np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
    return q


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


def without_jumps(signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """Return signals with angles that pass through a half turn without a jump.

    Roll, pitch and yaw of a topic continue from sample to sample. Those of setpoints and true
    motion are in the same turn as those of the estimate; behind each gap, as each may have turned
    further there. Signs of quaternions do not change between samples.
    """
    found = dict(signals)
    for angle in ANGLES:
        kept = f"estimate.{angle}", f"position_data.{angle}"
        names = [name for name in signals if name.endswith(f".{angle}")]
        names.sort(key=lambda name: kept.index(name) if name in kept else len(kept))
        reference = None
        for name in names:
            if signals[name].unit == "rad" and len(signals[name].time):
                found[name] = _continued(signals[name], reference)
                reference = reference or (found[name] if name in kept else None)
    for name in signals:
        topic, dot, part = name.rpartition(".")
        group = [f"{topic}{dot}{each}" for each in QUATERNION]
        if part == QUATERNION[0] and all(each in signals for each in group):
            whole = [signals[each] for each in group]
            if all(np.array_equal(each.time, whole[0].time) for each in whole):
                q = np.column_stack([each.values for each in whole])
                flips = np.sum(q[1:] * q[:-1], axis=1) < 0.0
                q[1:] *= np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
                for each, values in zip(group, q.T, strict=True):
                    found[each] = replace(found[each], values=values)
    return found


def _continued(signal: Signal, reference: Signal | None) -> Signal:
    """Return an angle without jumps; after each gap it is in the turn of another one if known."""
    values = np.unwrap(signal.values)
    if reference is not None:
        turn = 2.0 * np.pi
        edges = np.searchsorted(signal.time, [end for _, end in signal.gaps])
        for part in np.split(np.arange(len(values)), np.unique(edges)):
            expected, known = reference.at(signal.time[part], np.inf)
            if known.any():
                away = np.median(expected[known] - values[part][known])
                values[part[0] :] += turn * np.round(away / turn)
    return replace(signal, values=values)
