"""A flown flight as arrays on one grid, which predictions start from and are compared with."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

AIRBORNE = 0.3
"""Above its height at the start a drone flies [m]."""
TURNING = 0.05
"""Mean command above which the rotors turn."""
MARGIN = 0.2
"""Not counted after the take-off, and before the landing [s]."""


class Motion(NamedTuple):
    """A flight of m samples, and n rotors. W is east, north, up; B forward, left, up.

    Attributes:
        name: of the flight.
        period: between two samples [s].
        q: attitude, w, x, y, z, without jumps (m, 4).
        p: position in W (m, 3) [m].
        v: velocity in W (m, 3) [m/s].
        w: angular velocity in B, of the gyro where there is one (m, 3) [rad/s].
        q_known: as the flight computer knew it, and so the next two; the truth where the log has
            no estimate (m, 4).
        p_known: (m, 3).
        v_known: (m, 3).
        setpoint: position that is gone to, in W (m, 3) [m].
        attitude_setpoint: roll, pitch, yaw that the law asked for (m, 3) [rad]; NaN where unknown.
        thrust_setpoint: as a share of the full one (m); NaN where unknown.
        commands: share of the full command of each rotor, or of its full speed (m, n).
        voltage: of the battery (m) [V]; NaN where unknown.
        measured: whether all that a prediction starts from was measured then (m); in gaps it is
            interpolated.
        lag_shown: whether `commands` are speeds that the rotors had, behind their lag.
    """

    name: str
    period: float
    q: np.ndarray
    p: np.ndarray
    v: np.ndarray
    w: np.ndarray
    q_known: np.ndarray
    p_known: np.ndarray
    v_known: np.ndarray
    setpoint: np.ndarray
    attitude_setpoint: np.ndarray
    thrust_setpoint: np.ndarray
    commands: np.ndarray
    voltage: np.ndarray
    measured: np.ndarray
    lag_shown: bool = False

    @property
    def time(self) -> np.ndarray:
        """Times of the samples (m), 0 at the first one [s]."""
        return self.period * np.arange(len(self.p))

    @property
    def airborne(self) -> tuple[int, int]:
        """From which sample to before which one it flies; none where it never does."""
        if self.commands[0].mean() > TURNING:  # the log begins in flight
            return 0, len(self.p) - 1
        high = np.nonzero(self.p[:, 2] > self.p[0, 2] + AIRBORNE)[0]
        if len(high) == 0:
            return 0, 0
        margin = round(MARGIN / self.period)
        return int(high[0]) + margin, max(int(high[-1]) - margin, int(high[0]) + margin)

    @property
    def longest_gap(self) -> tuple[float, float]:
        """When the longest time in the air begins of which nothing was measured, and ends [s]."""
        first, last = self.airborne
        known = np.flatnonzero(self.measured[first:last])
        edges = np.concatenate([[-1], known, [last - first]])
        longest = int(np.argmax(np.diff(edges)))
        begin, end = edges[longest] + 1, edges[longest + 1]
        return self.period * (first + float(begin)), self.period * (first + float(end))


def rotation(q: np.ndarray) -> Rotation:
    """Return rotations of quaternions w, x, y, z (m, 4)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])


def resampled(values: np.ndarray, period: float, time: np.ndarray) -> np.ndarray:
    """Return samples (m, k), which are `period` [s] apart, at other times, between linearly."""
    grid = period * np.arange(len(values))
    return np.column_stack([np.interp(time, grid, column) for column in values.T])
