"""The page of the lidar's cloud, with choices of view, frame and colours."""

from functools import partial

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QWidget

from workbench.gui.cloud_rays import CloudRays, find_rays, pose_at
from workbench.gui.layout import buddy, button, choice, hbox, label, vbox
from workbench.gui.poses import Viewpoint, rotation_from_angles
from workbench.gui.sensor_offer import SensorOffer
from workbench.gui.units import LENGTH_UNIT, LOG_TIME_UNIT
from workbench.gui.visualization.cloud_view import (
    SIDE_VIEWPOINT,
    SLANTED_VIEWPOINT,
    TOP_VIEWPOINT,
    CloudView,
)
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class CloudPage(QWidget):
    """The newest cloud, with choices of view, frame and colours.

    Args:
        workspace: signals and colours.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._signals = workspace.signals
        self._rays: CloudRays | None = None
        self._stamp: object = None
        self.view = CloudView(workspace.look)
        frames = ("W, aligned with the world", "B, turned with the drone")
        self.frame = choice("Frame of the cloud", frames)
        self.colours = choice("Meaning of the colours", ("height", "range"))
        self.said = label(kind="muted")
        self.offer = SensorOffer(workspace, "lidar")
        self._lay_out()
        self.frame.currentIndexChanged.connect(self._show_anew)
        self.colours.currentIndexChanged.connect(self._show_anew)
        self.view.show_hint(self.offer.said)

    def begin(self, view: LiveView) -> None:
        """Show the cloud of a new flight."""
        self._rays = find_rays(view.topics)
        self.offer.begin(view)
        self._stamp = None
        self.said.setText("")
        self.view.show_hint(self.offer.said or "Waiting for the first scan")

    def refresh(self, now: float) -> None:
        """Show the newest cloud, if it has changed."""
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
        _, (roll, pitch, yaw) = pose_at(self._signals, stamp)
        heading = 0.0
        if self.frame.currentIndex() == 0:
            points, heading = points @ rotation_from_angles(roll, pitch, yaw).T, yaw
        by_height = self.colours.currentIndex() == 0
        if by_height and self.frame.currentIndex() == 0:
            values, name = points[:, 2] + pose_at(self._signals, stamp)[0][2], "Height m"
        elif by_height:
            values, name = points[:, 2], "Above B m"
        else:
            values, name = ranges[np.isfinite(ranges)], "Range m"
        self.view.show_points(points, values, name, heading)
        nearest = float(np.min(ranges, where=np.isfinite(ranges), initial=np.inf))
        self.said.setText(
            f"{len(points)} of {len(ranges)} rays returned, nearest {LENGTH_UNIT.text(nearest)}, "
            f"at {LOG_TIME_UNIT.text(stamp)}"
        )

    def _show_anew(self) -> None:
        self._stamp = None
        self.refresh(self._signals.now)

    def _look_from(self, viewpoint: Viewpoint) -> None:
        self.view.look_from(Viewpoint(viewpoint.turn, viewpoint.tilt, self.view.viewpoint.width))
        self.view.setFocus()

    def _lay_out(self) -> None:
        views = (
            ("&Top", TOP_VIEWPOINT, "T"),
            ("Si&de", SIDE_VIEWPOINT, "S"),
            ("Sla&nted", SLANTED_VIEWPOINT, "P"),
        )
        row = hbox(
            *(
                button(
                    text, partial(self._look_from, at), help=f"Show the cloud from there ({key})"
                )
                for text, at, key in views
            ),
            buddy("F&rame", self.frame, kind=""),
            self.frame,
            buddy("C&olours", self.colours, kind=""),
            self.colours,
            1,
            spacing=8,
        )
        vbox(
            row,
            (self.view, 1),
            self.offer,
            (self.said, Qt.AlignmentFlag.AlignLeft),
            of=self,
            margins=(0, 8, 0, 0),
            spacing=8,
        )
