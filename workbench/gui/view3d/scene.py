"""What the 3-D view shows besides the flight: a log that is replayed, and a predicted way."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.poses import turned
from workbench.gui.visualization.log_messages import LogContents

SOURCES = ("position_data", "estimate")
"""Where a log has the motion in W: the true one, or else what the flight computer made of it."""
FIELDS = ("x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class Track:
    """The motion in a log.

    Attributes:
        name: of the log.
        time: of its samples (N) [s].
        p_WB: places in W (N, 3) [m].
        roll_pitch_yaw: attitudes (N, 3), without jumps by a whole turn [rad].
    """

    name: str
    time: np.ndarray
    p_WB: np.ndarray
    roll_pitch_yaw: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """Return the pose X_WB at a time, the nearest one beyond the ends (4, 4) [m]."""
        pose = np.eye(4)
        angles = (float(np.interp(time, self.time, each)) for each in self.roll_pitch_yaw.T)
        pose[:3, :3] = turned(*angles)
        pose[:3, 3] = [np.interp(time, self.time, each) for each in self.p_WB.T]
        return pose


def track_of(contents: LogContents) -> Track | None:
    """Return the motion in a log, None where it has no position."""
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
    """Return a series at other times; zeros where the log has none."""
    if name not in contents.values:
        return np.zeros(len(time))
    own = contents.times[contents.topic_of[name]]
    values = np.asarray(contents.values[name], dtype=float)
    return values if own is time else np.interp(time, own, values)


class Scene(QObject):
    """Tells the 3-D view what else to show.

    Attributes:
        log: name of the log that charts show, "" where they show the flight.
        track: the motion in it, None without.
        time: of the log that is shown [s].
    """

    log_changed = pyqtSignal()
    """Another log, or none."""
    replayed = pyqtSignal()
    """Another time of it."""
    foreseen = pyqtSignal(float, object)
    """When a predicted way ends [s], and places on it in W (N, 3) [m]; none where N is 0."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.log, self.time = "", 0.0
        self.track: Track | None = None

    def show_log(self, contents: LogContents | None) -> None:
        """Show a log, or none any more."""
        self.log = contents.path.name if contents is not None else ""
        self.track = track_of(contents) if contents is not None else None
        self.log_changed.emit()

    def replay(self, time: float) -> None:
        """Show a log's time [s]."""
        self.time = time
        self.replayed.emit()
