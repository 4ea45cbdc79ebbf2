"""A flown flight as arrays on one grid, the start and reference of predictions."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from workbench.common.series import interpolated_on_grid

POSITION_VELOCITY_ROWS = (4, 5, 6, 10, 11, 12)
"""Place of p_WB and v_WB in a state of the body (13)."""
WRONG_DRONE_REMEDY = "give the drone that flew: `--model`, or in the app fly that drone first"

AIRBORNE_HEIGHT_M = 0.3
"""Height above the start from which on a drone counts as flying [m]."""
MIN_TURNING_COMMAND = 0.05
"""Mean command above which rotors turn."""
MIN_FLYING_SHARE = 0.5
"""Share of the usual command above which rotors carry the drone; those that idle do not."""
GROUND_MARGIN_S = 0.2
"""Time after take-off and before landing that is left out [s]."""


class LoggedMotion(NamedTuple):
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
        speeds_shown: whether `commands` are speeds, commanded or actual, at any voltage.
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
    speeds_shown: bool = False

    @property
    def time(self) -> np.ndarray:
        """Times of the samples (m), 0 at the first one [s]."""
        return self.period * np.arange(len(self.p))

    @property
    def _turning(self) -> np.ndarray:
        """Whether the rotors turn at a sample (m)."""
        return np.asarray(self.commands.mean(axis=1) > MIN_TURNING_COMMAND)

    @property
    def _carried(self) -> np.ndarray:
        """Whether the rotors carry the drone at a sample (m)."""
        mean, turning = self.commands.mean(axis=1), self._turning
        return mean > MIN_FLYING_SHARE * np.median(mean[turning]) if turning.any() else turning

    @property
    def ground(self) -> float:
        """Height of the ground [m]: the lowest one logged, or 0 if the drone is never on it.

        A log from the air that goes below 0 does not say where the ground is; no lower height than
        its own is known to be free.
        """
        lowest, carried = float(self.p[:, 2].min()), self._carried
        return min(lowest, 0.0) if carried[0] and carried[-1] else lowest

    @property
    def airborne(self) -> tuple[int, int]:
        """Slice of the samples in flight; empty if it never flies.

        Of several flights, with the rotors at rest on the ground between them, it is the longest.
        The ground is where the log begins, or, if it begins in flight, where it ends.
        """
        carried = self._carried
        if carried[0] and carried[-1]:
            return 0, len(self.p) - 1
        above = self.p[:, 2] > self.p[-1 if carried[0] else 0, 2] + AIRBORNE_HEIGHT_M
        high = np.flatnonzero(above)
        if len(high) == 0:
            return 0, 0
        # the same number for all samples of a flight
        flight = np.cumsum(~above & ~self._turning)[high]
        numbers, counts = np.unique(flight, return_counts=True)
        high = high[flight == numbers[np.argmax(counts)]]
        margin = round(GROUND_MARGIN_S / self.period)
        first = int(high[0]) + margin if high[0] else 0
        return first, max(int(high[-1]) - margin, first)

    def longest_part(self, gap: float) -> tuple[int, int]:
        """Return the slice of the longest time in the air without a longer gap than some [s].

        Smaller ones are interpolated.
        """
        first, last = self.airborne
        known = np.unique([first, *(first + np.flatnonzero(self.measured[first:last])), last])
        breaks = np.flatnonzero(np.diff(known) > max(1.0, gap / self.period)) + 1
        longest = max(np.split(known, breaks), key=lambda part: int(part[-1] - part[0]))
        return int(longest[0]), int(longest[-1])


def rotation_matrices(q: np.ndarray) -> Rotation:
    """Return the rotations of quaternions w, x, y, z (m, 4)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])


def resampled(values: np.ndarray, period: float, time: np.ndarray) -> np.ndarray:
    """Return samples (m, k), at intervals of `period` [s], interpolated linearly at other times."""
    return interpolated_on_grid(period * np.arange(len(values)), values, time)
