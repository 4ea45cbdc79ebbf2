"""A flown flight as arrays on one grid, the start and reference of predictions."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

AIRBORNE = 0.3
"""Height above the start from which on a drone counts as flying [m]."""
TURNING = 0.05
"""Mean command above which rotors turn."""
MARGIN = 0.2
"""Time after take-off and before landing that is left out [s]."""


class Motion(NamedTuple):
    """A flight of m samples and n rotors. W is east, north, up; B is forward, left, up.

    Attributes:
        name: of the flight.
        period: between samples [s].
        q: attitude, w, x, y, z, without jumps (m, 4).
        p: position in W (m, 3) [m].
        v: velocity in W (m, 3) [m/s].
        w: angular velocity in B, from the gyro if there is one (m, 3) [rad/s].
        q_known: attitude known to the flight computer (m, 4); like the next two, the true one if
            the log has no estimate.
        p_known: position (m, 3).
        v_known: velocity (m, 3).
        setpoint: position setpoint in W (m, 3) [m].
        attitude_setpoint: roll, pitch, yaw commanded by the law (m, 3) [rad]; NaN where unknown.
        thrust_setpoint: as a share of the full one (m); NaN where unknown.
        commands: share of the full command of each rotor, or of its full speed (m, n).
        voltage: of the battery (m) [V]; NaN where unknown.
        measured: whether all inputs of a prediction were measured at a sample (m); in gaps they are
            interpolated.
        lag_shown: whether `commands` are actual rotor speeds, after their lag.
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
        """Slice of the samples in flight; empty if it never flies."""
        if self.commands[0].mean() > TURNING:  # the log begins in flight
            return 0, len(self.p) - 1
        high = np.nonzero(self.p[:, 2] > self.p[0, 2] + AIRBORNE)[0]
        if len(high) == 0:
            return 0, 0
        margin = round(MARGIN / self.period)
        return int(high[0]) + margin, max(int(high[-1]) - margin, int(high[0]) + margin)

    @property
    def longest_gap(self) -> tuple[float, float]:
        """Begin and end of the longest time in the air without measurements [s]."""
        first, last = self.airborne
        known = np.flatnonzero(self.measured[first:last])
        edges = np.concatenate([[-1], known, [last - first]])
        longest = int(np.argmax(np.diff(edges)))
        begin, end = edges[longest] + 1, edges[longest + 1]
        return self.period * (first + float(begin)), self.period * (first + float(end))


def rotation(q: np.ndarray) -> Rotation:
    """Return the rotations of quaternions w, x, y, z (m, 4)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])


def resampled(values: np.ndarray, period: float, time: np.ndarray) -> np.ndarray:
    """Return samples (m, k), at intervals of `period` [s], interpolated linearly at other times."""
    grid = period * np.arange(len(values))
    return np.column_stack([np.interp(time, grid, column) for column in values.T])
