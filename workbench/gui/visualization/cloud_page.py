"""The page of the lidar's cloud."""

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from workbench.gui.charts.statistics import value_at
from workbench.gui.charts.ticks import number_text
from workbench.gui.style import set_class
from workbench.gui.visualization.cloud import SIDE, SLANTED, TOP, CloudRays, Viewpoint, rays_from
from workbench.gui.visualization.cloud_view import CloudView
from workbench.gui.workspace import Workspace
from workbench.link.topics import PREFIX, Topic

NO_LIDAR = (
    "No lidar measures in this flight. Open a scenario with one, such as “network” or "
    "“all-sensors”, or list lidar under sensors in the scenario."
)


class CloudPage(QWidget):
    """Newest cloud, with choices of view, frame and colours.

    Args:
        workspace: signals and colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._signals = workspace.signals
        self._rays: CloudRays | None = None
        self._stamp: object = None
        self.view = CloudView(workspace.look)
        self.frame = QComboBox()
        self.frame.addItems(["W, level with the world", "B, turned with the drone"])
        self.frame.setAccessibleName("Frame of the cloud")
        self.colours = QComboBox()
        self.colours.addItems(["height", "range"])
        self.colours.setAccessibleName("What the colours stand for")
        self.said = QLabel()
        set_class(self.said, "muted")
        self._lay_out()
        self.frame.currentIndexChanged.connect(self._show_anew)
        self.colours.currentIndexChanged.connect(self._show_anew)
        self.view.show_hint(NO_LIDAR)

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the cloud of a flight that begins."""
        topic = next((each for each in topics if each.name == f"{PREFIX}lidar_cloud"), None)
        self._rays = rays_from(topic.about) if topic is not None else None
        self._stamp = None
        self.said.setText("")
        self.view.show_hint("Waiting for the first scan" if self._rays is not None else NO_LIDAR)

    def refresh(self, now: float) -> None:
        """Show the newest cloud, if it is another one."""
        if self._rays is None:
            return
        newest = self._signals.newest("lidar_cloud")
        stamp, ranges = newest.get("stamp"), newest.get("ranges")
        if stamp == self._stamp or not isinstance(ranges, tuple) or not isinstance(stamp, int):
            return
        self._stamp = stamp
        self._show(stamp * 1e-9, np.array(ranges), self._rays)

    def _show(self, stamp: float, ranges: np.ndarray, rays: CloudRays) -> None:
        points = rays.points_B(ranges)
        roll, pitch, yaw = (
            self._at(f"position_data.{name}", stamp) for name in ("roll", "pitch", "yaw")
        )
        heading = 0.0
        if self.frame.currentIndex() == 0:
            points, heading = points @ turned(roll, pitch, yaw).T, yaw
        by_height = self.colours.currentIndex() == 0
        if by_height and self.frame.currentIndex() == 0:
            values, name = points[:, 2] + self._at("position_data.z", stamp), "Height m"
        elif by_height:
            values, name = points[:, 2], "Above B m"
        else:
            values, name = ranges[np.isfinite(ranges)], "Range m"
        self.view.show_points(points, values, name, heading)
        nearest = float(np.min(ranges, where=np.isfinite(ranges), initial=np.inf))
        self.said.setText(
            f"{len(points)} of {len(ranges)} rays returned, nearest {number_text(nearest, 2)} m, "
            f"at {number_text(stamp, 2)} s"
        )

    def _at(self, name: str, time: float) -> float:
        """Return the value of a signal when the scan was taken; 0 where it is not known."""
        value = value_at(*self._signals.series(name, time - 0.1), time)
        return value if value == value else 0.0

    def _show_anew(self) -> None:
        self._stamp = None
        self.refresh(self._signals.now)

    def _look_from(self, viewpoint: Viewpoint) -> None:
        self.view.look_from(Viewpoint(viewpoint.turn, viewpoint.tilt, self.view.viewpoint.width))
        self.view.setFocus()

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setSpacing(8)
        for text, viewpoint in (("&Top", TOP), ("Si&de", SIDE), ("S&lanted", SLANTED)):
            button = QPushButton(text)
            button.setToolTip(f"See the cloud from there ({text.replace('&', '')[0]})")
            button.clicked.connect(lambda _, at=viewpoint: self._look_from(at))
            row.addWidget(button)
        for text, choice in (("F&rame", self.frame), ("C&olours", self.colours)):
            label = QLabel(text)
            label.setBuddy(choice)
            row.addWidget(label)
            row.addWidget(choice)
        row.addStretch(1)
        page = QVBoxLayout(self)
        page.setContentsMargins(0, 8, 0, 0)
        page.setSpacing(8)
        page.addLayout(row)
        page.addWidget(self.view, 1)
        page.addWidget(self.said, 0, Qt.AlignmentFlag.AlignLeft)


def turned(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Return the orientation of these angles about x, y and z, fixed axes in this order."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (roll, pitch, yaw))
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    made: np.ndarray = about_z @ about_y @ about_x
    return made
