"""The page of the depth camera: its images, and the colours of distances."""

import math
from time import perf_counter

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QEvent, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QResizeEvent
from PyQt6.QtWidgets import QBoxLayout, QWidget

from workbench.gui.charts.colour_scale import colour_table, colours_of
from workbench.gui.charts.ticks import round_step
from workbench.gui.instruments.plane_view import PlaneView
from workbench.gui.layout import fill, hbox, label, vbox
from workbench.gui.sensor_offer import SensorOffer
from workbench.gui.theme import Look
from workbench.gui.units import LENGTH_UNIT, LOG_TIME_UNIT
from workbench.gui.workspace import Workspace
from workbench.live.orders import GetReading
from workbench.live.view import LiveView
from workbench.systems.sensors.readings import DepthImage

TOO_NEAR_COLOUR = (0x00, 0x00, 0x00)
OUT_OF_RANGE_COLOUR = (0x8A, 0x8F, 0x98)
PICTURE_REQUEST_PERIOD_S = 0.1
"""Least period between requests for pictures [s]."""
DEPTH_CAMERA_KIND = "depth_camera"
DepthColourRange = tuple[float, float]
"""Depths of the first and the last colour [m]."""


def depth_range(depth: np.ndarray) -> DepthColourRange:
    """Return round ends around the measured depths."""
    finite = depth[np.isfinite(depth)]
    if len(finite) == 0:
        return (0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    step = round_step(max(high - low, 0.5), 6)
    return (step * math.floor(low / step), step * math.ceil(high / step))


def depth_colours(depth: np.ndarray, scale: DepthColourRange, table: np.ndarray) -> np.ndarray:
    """Return a depth image as red, green, blue: grey beyond the range, black below it."""
    colours = colours_of(np.where(np.isfinite(depth), depth, scale[0]), *scale, table)
    colours[np.isposinf(depth) | np.isnan(depth)] = OUT_OF_RANGE_COLOUR
    colours[np.isneginf(depth)] = TOO_NEAR_COLOUR
    return colours


def depth_text(depth: float) -> str:
    """Return a pixel's value as text."""
    if math.isnan(depth):
        return "no measurement"
    if math.isinf(depth):
        return "nothing within range" if depth > 0.0 else "nearer than it measures"
    return LENGTH_UNIT.text(depth)


class PictureView(PlaneView):
    """Shows a picture.

    Args:
        look: source of colours.
        name: name of the picture.
    """

    pointed = pyqtSignal(object)
    """Column and row of the pixel under the mouse, None without one."""

    def __init__(self, look: Look, name: str) -> None:
        super().__init__(look, name)
        self._image = pg.ImageItem(axisOrder="row-major")
        self.add(self._image)
        self.view.invertY(True)
        self.setMouseTracking(True)
        self.setMinimumSize(160, 120)
        self.apply_colours()

    def show_image(self, colours: np.ndarray) -> None:
        """Show red, green and blue bytes (height, width, 3)."""
        super().show_hint("")
        self._image.setImage(colours, levels=(0, 255))
        self.show_area(QRectF(0.0, 0.0, colours.shape[1], colours.shape[0]))

    def show_hint(self, hint: str) -> None:
        """Show why there is no picture."""
        super().show_hint(hint)
        self._image.clear()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Report the pixel."""
        assert event is not None
        at = self.place_at(event.position())
        column, row = math.floor(at.x()), math.floor(at.y())
        shown = self._image.image
        inside = shown is not None and 0 <= row < shown.shape[0] and 0 <= column < shown.shape[1]
        self.pointed.emit((column, row) if inside else None)

    def leaveEvent(self, event: QEvent | None) -> None:
        """Report that the mouse has left."""
        self.pointed.emit(None)


class CameraPage(QWidget):
    """Depth and colour images, requested only while visible.

    Args:
        workspace: flight and colours.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight = workspace.flight
        self._asked, self._waits = -np.inf, False
        self._newest: DepthImage | None = None
        self._pixel: tuple[int, int] | None = None
        self._table = colour_table()[::-1]
        self.depth_view = PictureView(workspace.look, "Depth image")
        self.colour_view = PictureView(workspace.look, "Colour image")
        self.said, self.under = label(kind="muted"), label(kind="muted")
        self.key = label("Grey: nothing within range. Black: nearer than it measures.", "muted")
        self._beside = QBoxLayout(QBoxLayout.Direction.LeftToRight)
        self.offer = SensorOffer(workspace, DEPTH_CAMERA_KIND)
        self._scale: DepthColourRange | None = None
        self._lay_out()
        self.depth_view.pointed.connect(self._point)
        self.colour_view.pointed.connect(self._point)
        self.show_hint(self.offer.said)

    def begin(self, view: LiveView) -> None:
        """Clear the pictures: a flight begins."""
        self._newest, self._waits, self._asked, self._scale = None, False, -np.inf, None
        self.offer.begin(view)
        self.show_hint(self.offer.said or "Waiting for the first picture")

    def refresh(self, view: LiveView) -> None:
        """Request the next picture if one is due and a camera is active."""
        snapshot = view.snapshot
        if snapshot is None or not any(each.kind == DEPTH_CAMERA_KIND for each in snapshot.sensors):
            return
        now = perf_counter()
        if self._waits or now < self._asked + PICTURE_REQUEST_PERIOD_S:
            return
        self._asked, self._waits = now, True
        self._flight.do(GetReading(DEPTH_CAMERA_KIND), self.show_reading, self._refuse)

    def show_reading(self, reading: object) -> None:
        """Show a picture; nothing is painted if it is unchanged."""
        self._waits = False
        same = self._newest is not None and isinstance(reading, DepthImage)
        if not isinstance(reading, DepthImage) or (
            same and self._newest is not None and reading.stamp == self._newest.stamp
        ):
            return
        self._newest = reading
        scale = self._scale_for(reading.depth)
        self.depth_view.show_image(depth_colours(reading.depth, scale, self._table))
        self.depth_view.show_scale(self._table, *scale, "Depth m")
        if reading.colour is not None:
            self.colour_view.show_image(reading.colour)
        else:
            self.colour_view.show_hint("This camera has no colour image.")
        height, width = reading.depth.shape
        self.said.setText(f"{width} × {height} pixels, at {LOG_TIME_UNIT.text(reading.stamp)}")
        self._show_pixel()

    def _scale_for(self, depth: np.ndarray) -> DepthColourRange:
        """Return a scale that has all depths of this flight so far: a colour keeps its meaning."""
        scale = depth_range(depth)
        if not np.isfinite(depth).any():
            return self._scale or scale
        if self._scale is not None:
            scale = (min(scale[0], self._scale[0]), max(scale[1], self._scale[1]))
        self._scale = scale
        return scale

    def show_hint(self, hint: str) -> None:
        """Show why there are no pictures."""
        self.depth_view.show_hint(hint)
        self.colour_view.show_hint("")
        self.said.setText("")
        self.under.setText("")

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the pictures side by side, or one above the other."""
        wide = self.width() > 1.6 * self.height()
        across, down = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._beside.setDirection(across if wide else down)

    def _refuse(self, said: str) -> None:
        self._waits = False
        if self._newest is None:
            self.show_hint(f"The depth camera has failed: {said}")

    def _point(self, pixel: tuple[int, int] | None) -> None:
        self._pixel = pixel
        self._show_pixel()

    def _show_pixel(self) -> None:
        if self._pixel is None or self._newest is None:
            self.under.setText("Point at a picture to read a pixel")
            return
        column, row = self._pixel
        if row < self._newest.depth.shape[0] and column < self._newest.depth.shape[1]:
            depth = depth_text(float(self._newest.depth[row, column]))
            self.under.setText(f"Column {column}, row {row}: {depth}")

    def _lay_out(self) -> None:
        self._beside.setSpacing(10)
        fill(self._beside, (self.depth_view, 1), (self.colour_view, 1))
        below = hbox(self.said, 1, self.under)
        vbox(
            (self._beside, 1),
            self.offer,
            below,
            (self.key, Qt.AlignmentFlag.AlignLeft),
            of=self,
            margins=(0, 8, 0, 0),
            spacing=6,
        )
