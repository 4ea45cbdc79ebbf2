"""Additions to the 3-D view of the flight: a replayed log, and a predicted path."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.common.flight import Flight
from workbench.gui.poses import rotation_from_angles

LOG_POSE_TOPICS = ("position_data", "estimate")
"""Sources of the motion in W in a log: the true one, or else the flight computer's estimate."""
LOG_POSE_FIELDS = ("x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class LogTrack:
    """The motion in a log.

    Attributes:
        name: name of the log.
        time: times of its samples (N) [s].
        p_WB: positions in W (N, 3) [m].
        roll_pitch_yaw: attitudes (N, 3), unwrapped [rad].
    """

    name: str
    time: np.ndarray
    p_WB: np.ndarray
    roll_pitch_yaw: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """Return the pose X_WB at a time, beyond the ends the nearest one (4, 4) [m]."""
        pose = np.eye(4)
        angles = (float(np.interp(time, self.time, each)) for each in self.roll_pitch_yaw.T)
        pose[:3, :3] = rotation_from_angles(*angles)
        pose[:3, 3] = [np.interp(time, self.time, each) for each in self.p_WB.T]
        return pose


def log_track(flight: Flight) -> LogTrack | None:
    """Return the motion in a log, None without a position."""
    for source in LOG_POSE_TOPICS:
        names = [f"{source}.{each}" for each in LOG_POSE_FIELDS]
        if any(name not in flight for name in names[:3]):
            continue
        time = flight[names[0]].time
        columns = [_resampled_series(flight, name, time) for name in names]
        known = np.isfinite(columns[:3]).all(axis=0)
        if known.sum() > 1:
            motion = np.array(columns)[:, known].T
            angles = np.unwrap(np.nan_to_num(motion[:, 3:]), axis=0)
            return LogTrack(flight.source.name, time[known], motion[:, :3], angles)
    return None


def _resampled_series(flight: Flight, name: str, time: np.ndarray) -> np.ndarray:
    """Return a series resampled at other times; zeros if the log lacks it."""
    if name not in flight:
        return np.zeros(len(time))
    own = flight[name]
    return own.values if np.array_equal(own.time, time) else np.interp(time, own.time, own.values)


class Scene(QObject):
    """Additions to the 3-D view.

    Attributes:
        log: name of the log in the charts, "" if they show the flight.
        track: the motion in it, None without one.
        time: shown time of the log [s].
    """

    log_changed = pyqtSignal()
    """A different log, or none."""
    replayed = pyqtSignal()
    """A different time of the log."""
    foreseen = pyqtSignal(float, object)
    """End of a predicted path [s], and positions on it in W (N, 3) [m]; none if N is 0."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.log, self.time = "", 0.0
        self.track: LogTrack | None = None

    def show_log(self, flight: Flight | None) -> None:
        """Show a log, or none."""
        self.log = flight.source.name if flight is not None else ""
        self.track = log_track(flight) if flight is not None else None
        self.log_changed.emit()

    def replay(self, time: float) -> None:
        """Show a time of the log [s]."""
        self.time = time
        self.replayed.emit()
