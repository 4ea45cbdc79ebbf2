"""The page of the depth camera: its two pictures, and the scale of the depth."""

import math
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from PyQt6.QtCore import QEvent, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QImage, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PyQt6.QtWidgets import QBoxLayout, QLabel, QSizePolicy, QWidget

from workbench.gui.charts.colour_scale import (
    colour_table,
    colour_words,
    colours_of,
    image_of,
    paint_scale,
)
from workbench.gui.charts.ticks import number_text, round_step
from workbench.gui.layout import hbox, vbox
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.systems.sensors.readings import DepthImage

TOO_NEAR = 0xFF000000
BEYOND = 0xFF8A8F98

EVERY = 0.1
"""Between two pictures that are asked for [s]."""
NO_CAMERA = (
    "No depth camera measures in this flight. Open the scenario “all-sensors”, or list "
    "depth_camera under sensors in the scenario; it needs a model with a camera."
)
KIND = "depth_camera"


@dataclass(frozen=True)
class DepthScale:
    """What the colours of a depth image stand for.

    Attributes:
        low: depth of the first colour [m].
        high: of the last one [m].
    """

    low: float
    high: float


def scale_of(depth: np.ndarray) -> DepthScale:
    """Return round ends around the depths that were measured."""
    finite = depth[np.isfinite(depth)]
    if len(finite) == 0:
        return DepthScale(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    step = round_step(max(high - low, 0.5), 6)
    return DepthScale(step * math.floor(low / step), step * math.ceil(high / step))


def depth_colours(depth: np.ndarray, scale: DepthScale, table: np.ndarray) -> np.ndarray:
    """Return a depth image as colours 0xffrrggbb: grey beyond range, black where too near."""
    colours = colours_of(
        np.where(np.isfinite(depth), depth, scale.low), scale.low, scale.high, table
    )
    colours[np.isposinf(depth) | np.isnan(depth)] = BEYOND
    colours[np.isneginf(depth)] = TOO_NEAR
    return colours


def depth_text(depth: float) -> str:
    """Return what a pixel says."""
    if math.isnan(depth):
        return "no measurement"
    if math.isinf(depth):
        return "nothing within range" if depth > 0.0 else "nearer than it measures"
    return f"{number_text(depth, 2)} m"


class ScaleBar(QWidget):
    """Shows which colour is how far.

    Args:
        look: colours.
        table: from near to far.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, table: np.ndarray, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look, self._table = look, table
        self._scale = DepthScale(0.0, 1.0)
        self.setFixedWidth(74)
        self.setAccessibleName("Scale of the depth in m")
        look.changed.connect(self.update)

    def show_scale(self, scale: DepthScale) -> None:
        """Show another scale."""
        if scale != self._scale:
            self._scale = scale
            self.setAccessibleDescription(f"from {scale.low:g} to {scale.high:g} m")
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        box = QRectF(self.rect()).adjusted(8, 0, 0, 0)
        ends = self._scale.low, self._scale.high
        paint_scale(painter, box, *ends, self._table, self._look.colour("ink"), "Depth m")


class PictureView(QWidget):
    """Shows a picture.

    Args:
        look: colours.
        name: of the picture.
        parent: the Qt parent; this object is deleted with it.
    """

    pointed = pyqtSignal(object)
    """Column and row of the pixel under the mouse, None where there is none."""

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._image = QImage()
        self._hint = ""
        self.setMouseTracking(True)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(name)
        look.changed.connect(self.update)

    @property
    def image(self) -> QImage:
        """What is shown."""
        return self._image

    def show_image(self, image: QImage) -> None:
        """Show a picture."""
        self._image, self._hint = image, ""
        self.update()

    def show_hint(self, hint: str) -> None:
        """Say why there is no picture."""
        self._image, self._hint = QImage(), hint
        self.update()

    def box(self) -> QRectF:
        """Return where the picture is."""
        if self._image.isNull():
            return QRectF()
        scale = min(self.width() / self._image.width(), self.height() / self._image.height())
        width, height = scale * self._image.width(), scale * self._image.height()
        return QRectF(0.5 * (self.width() - width), 0.5 * (self.height() - height), width, height)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._look.colour("ground"))
        if self._image.isNull():
            painter.setPen(self._look.colour("muted"))
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(QRectF(self.rect()).adjusted(16, 8, -16, -8), int(flags), self._hint)
        else:
            painter.drawImage(self.box(), self._image)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Tell the pixel."""
        box = self.box()
        if event is None or not box.contains(event.position()):
            self.pointed.emit(None)
            return
        place = event.position() - box.topLeft()
        column = min(int(place.x() / box.width() * self._image.width()), self._image.width() - 1)
        row = min(int(place.y() / box.height() * self._image.height()), self._image.height() - 1)
        self.pointed.emit((column, row))

    def leaveEvent(self, event: QEvent | None) -> None:
        """The mouse is elsewhere."""
        self.pointed.emit(None)


class CameraPage(QWidget):
    """Depth and colour, asked for only while they are seen.

    Args:
        workspace: flight and colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._flight = workspace.flight
        self._asked, self._waits = -np.inf, False
        self._newest: DepthImage | None = None
        self._pixel: tuple[int, int] | None = None
        self._table = colour_table()[::-1]
        self.depth_view = PictureView(workspace.look, "Depth image")
        self.colour_view = PictureView(workspace.look, "Colour image")
        self.scale = ScaleBar(workspace.look, self._table)
        self.said, self.under = QLabel(), QLabel()
        self.key = QLabel("Grey: nothing within range. Black: nearer than it measures.")
        self._pad = QWidget()
        self._beside = QBoxLayout(QBoxLayout.Direction.LeftToRight)
        self._lay_out()
        self.depth_view.pointed.connect(self._point)
        self.colour_view.pointed.connect(self._point)
        self.show_hint(NO_CAMERA)

    def begin(self, view: LiveView) -> None:
        """Forget the pictures: a flight begins."""
        self._newest, self._waits, self._asked = None, False, -np.inf
        has_camera = view.snapshot is not None and any(
            each.kind == KIND for each in view.snapshot.sensors
        )
        self.show_hint("Waiting for the first picture" if has_camera else NO_CAMERA)

    def refresh(self, view: LiveView) -> None:
        """Ask for the next picture, if it is time for one and a camera measures."""
        snapshot = view.snapshot
        if snapshot is None or not any(each.kind == KIND for each in snapshot.sensors):
            return
        now = perf_counter()
        if self._waits or now < self._asked + EVERY:
            return
        self._asked, self._waits = now, True
        self._flight.order(lambda live: live.reading(KIND), self.show_reading, self._refuse)

    def show_reading(self, reading: object) -> None:
        """Show a picture; nothing is painted where it is the same."""
        self._waits = False
        same = self._newest is not None and isinstance(reading, DepthImage)
        if not isinstance(reading, DepthImage) or (
            same and self._newest is not None and reading.stamp == self._newest.stamp
        ):
            return
        self._newest = reading
        scale = scale_of(reading.depth)
        self.depth_view.show_image(image_of(depth_colours(reading.depth, scale, self._table)))
        self.scale.show_scale(scale)
        if reading.colour is not None:
            self.colour_view.show_image(image_of(colour_words(reading.colour)))
        else:
            self.colour_view.show_hint("This camera has no colour image.")
        height, width = reading.depth.shape
        self.said.setText(f"{width} × {height} pixels, at {number_text(reading.stamp, 2)} s")
        self._show_pixel()

    def show_hint(self, hint: str) -> None:
        """Say why there are no pictures."""
        self.depth_view.show_hint(hint)
        self.colour_view.show_hint("")
        self.said.setText("")
        self.under.setText("")

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Set the pictures side by side, or one over the other."""
        wide = self.width() > 1.6 * self.height()
        across, down = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._beside.setDirection(across if wide else down)
        self._pad.setVisible(not wide)  # so that the pictures stand one over the other
        half = (self.width() - self.scale.width()) // 2 if wide else self.height()
        self._beside.setStretch(0, half + (self.scale.width() if wide else 0))
        self._beside.setStretch(1, half)

    def _refuse(self, said: str) -> None:
        self._waits = False
        if self._newest is None:
            self.show_hint(f"The depth camera tells nothing: {said}")

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
        for label in (self.said, self.under, self.key):
            set_class(label, "muted")
        depth = hbox((self.depth_view, 1), self.scale, spacing=4)
        self._beside.setSpacing(10)
        self._beside.addLayout(depth, 1)
        colour = hbox((self.colour_view, 1), spacing=4)
        self._pad.setFixedWidth(self.scale.width())
        colour.addWidget(self._pad)
        self._beside.addLayout(colour, 1)
        below = hbox(self.said, 1, self.under)
        vbox(
            (self._beside, 1),
            below,
            (self.key, Qt.AlignmentFlag.AlignLeft),
            of=self,
            margins=(0, 8, 0, 0),
            spacing=6,
        )
