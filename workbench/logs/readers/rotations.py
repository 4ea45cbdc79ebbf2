"""Attitudes in logs: quaternions, and roll, pitch and yaw without jumps."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.common.series import Series

EULER_ANGLE_NAMES = ("roll", "pitch", "yaw")
QUATERNION_NAMES = ("q_w", "q_x", "q_y", "q_z")


def continuous(q: np.ndarray) -> np.ndarray:
    """Return unit quaternions (n, 4), w first, with signs that do not jump between rows."""
    norm = np.linalg.norm(q, axis=1, keepdims=True)
    q = np.divide(q, norm, out=np.full(q.shape, np.nan), where=norm > 0.0)
    known = np.flatnonzero(np.isfinite(q).all(axis=1))
    flips = np.sum(q[known[1:]] * q[known[:-1]], axis=1) < 0.0
    q[known[1:]] *= np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
    return q


def quaternion_from_angles(roll: np.ndarray, pitch: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Return quaternions B to W (n, 4), w first, for roll, pitch and yaw (n).

    R = Rz(yaw) Ry(pitch) Rx(roll), as in `position_data`.
    """
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


def vectors_in_world(q: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors in W (n, 3) for vectors in B."""
    w, part = q[:, :1], q[:, 1:]
    twice = 2.0 * np.cross(part, vectors)
    return np.asarray(vectors + w * twice + np.cross(part, twice))


def without_jumps(signals: Mapping[str, Series]) -> dict[str, Series]:
    """Return signals with angles that pass through a half turn without a jump.

    Roll, pitch and yaw of a topic continue from sample to sample. Those of setpoints and true
    motion are in the same turn as those of the estimate; behind each gap, as each may have turned
    further there. Signs of quaternions do not change between samples.
    """
    found = dict(signals)
    for angle in EULER_ANGLE_NAMES:
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
        group = [f"{topic}{dot}{each}" for each in QUATERNION_NAMES]
        if part == QUATERNION_NAMES[0] and all(each in signals for each in group):
            whole = [signals[each] for each in group]
            if all(np.array_equal(each.time, whole[0].time) for each in whole):
                q = np.column_stack([each.values for each in whole])
                flips = np.sum(q[1:] * q[:-1], axis=1) < 0.0
                q[1:] *= np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
                for each, values in zip(group, q.T, strict=True):
                    found[each] = replace(found[each], values=values)
    return found


def _continued(signal: Series, reference: Series | None) -> Series:
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
