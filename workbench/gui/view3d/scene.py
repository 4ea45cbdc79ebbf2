"""Additions to the 3-D view of the flight: a replayed log, and a predicted path."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.poses import turned
from workbench.gui.visualization.log_messages import LogContents

SOURCES = ("position_data", "estimate")
"""Sources of the motion in W in a log: the true one, or else the flight computer's estimate."""
FIELDS = ("x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class Track:
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
        pose[:3, :3] = turned(*angles)
        pose[:3, 3] = [np.interp(time, self.time, each) for each in self.p_WB.T]
        return pose


def track_of(contents: LogContents) -> Track | None:
    """Return the motion in a log, None without a position."""
    for source in SOURCES:
        names = [f"{source}.{each}" for each in FIELDS]
        if any(name not in contents.values for name in names[:3]):
            continue
        time = contents.times[contents.topic_of[names[0]]]
        columns = [_column(contents, name, time) for name in names]
        known = np.isfinite(columns[:3]).all(axis=0)
        if known.sum() > 1:
            motion = np.array(columns)[:, known].T
            angles = np.unwrap(np.nan_to_num(motion[:, 3:]), axis=0)
            return Track(contents.path.name, time[known], motion[:, :3], angles)
    return None


def _column(contents: LogContents, name: str, time: np.ndarray) -> np.ndarray:
    """Return a series resampled at other times; zeros if the log lacks it."""
    if name not in contents.values:
        return np.zeros(len(time))
    own = contents.times[contents.topic_of[name]]
    values = np.asarray(contents.values[name], dtype=float)
    return values if own is time else np.interp(time, own, values)


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
        self.track: Track | None = None

    def show_log(self, contents: LogContents | None) -> None:
        """Show a log, or none."""
        self.log = contents.path.name if contents is not None else ""
        self.track = track_of(contents) if contents is not None else None
        self.log_changed.emit()

    def replay(self, time: float) -> None:
        """Show a time of the log [s]."""
        self.time = time
        self.replayed.emit()
