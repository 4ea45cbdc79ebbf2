"""The pages of the depth camera and of the lidar's cloud."""

import dataclasses
import math
from functools import partial
from time import perf_counter

import numpy as np
from PyQt6.QtCore import QEvent, QPointF, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import (
    QFocusEvent,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PyQt6.QtWidgets import (
    QBoxLayout,
    QSizePolicy,
    QWidget,
)
from pyqtgraph.functions import arrayToQPolygonF

from workbench.gui.charts.colour_scale import (
    colour_table,
    colour_words,
    colours_of,
    image_of,
    paint_scale,
)
from workbench.gui.charts.ticks import number_text, round_step
from workbench.gui.cloud_rays import CloudRays, find_rays, pose_at
from workbench.gui.layout import buddy, button, choice, hbox, label, vbox
from workbench.gui.poses import Viewpoint, turned
from workbench.gui.theme import Look
from workbench.gui.workspace import Workspace
from workbench.link.topics import Topic
from workbench.live.view import LiveView
from workbench.systems.sensors.readings import DepthImage

TOO_NEAR = 0xFF000000
BEYOND = 0xFF8A8F98

EVERY = 0.1
"""Least period between requests for pictures [s]."""
NO_CAMERA = (
    "No depth camera is on in this flight. Open the scenario “all-sensors”, or list "
    "depth_camera under sensors in the scenario; it needs a model with a camera."
)
KIND = "depth_camera"


Scale = tuple[float, float]
"""Depths of the first and the last colour [m]."""


def scale_of(depth: np.ndarray) -> Scale:
    """Return round ends around the measured depths."""
    finite = depth[np.isfinite(depth)]
    if len(finite) == 0:
        return (0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    step = round_step(max(high - low, 0.5), 6)
    return (step * math.floor(low / step), step * math.ceil(high / step))


def depth_colours(depth: np.ndarray, scale: Scale, table: np.ndarray) -> np.ndarray:
    """Return a depth image as colours 0xffrrggbb: grey beyond the range, black below it."""
    colours = colours_of(np.where(np.isfinite(depth), depth, scale[0]), *scale, table)
    colours[np.isposinf(depth) | np.isnan(depth)] = BEYOND
    colours[np.isneginf(depth)] = TOO_NEAR
    return colours


def depth_text(depth: float) -> str:
    """Return a pixel's value as text."""
    if math.isnan(depth):
        return "no measurement"
    if math.isinf(depth):
        return "nothing within range" if depth > 0.0 else "nearer than it measures"
    return f"{number_text(depth, 2)} m"


class ScaleBar(QWidget):
    """Shows which colour stands for which distance.

    Args:
        look: source of colours.
        table: colours from near to far.
    """

    def __init__(self, look: Look, table: np.ndarray) -> None:
        super().__init__()
        self._look, self._table = look, table
        self._scale = (0.0, 1.0)
        self.setFixedWidth(74)
        self.setAccessibleName("Scale of the depth in m")
        look.changed.connect(self.update)

    def show_scale(self, scale: Scale) -> None:
        """Show another scale."""
        if scale != self._scale:
            self._scale = scale
            self.setAccessibleDescription(f"from {scale[0]:g} to {scale[1]:g} m")
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        box = QRectF(self.rect()).adjusted(8, 0, 0, 0)
        paint_scale(painter, box, *self._scale, self._table, self._look.colour("ink"), "Depth m")


class PictureView(QWidget):
    """Shows a picture.

    Args:
        look: source of colours.
        name: name of the picture.
    """

    pointed = pyqtSignal(object)
    """Column and row of the pixel under the mouse, None without one."""

    def __init__(self, look: Look, name: str) -> None:
        super().__init__()
        self._look = look
        self._image = QImage()
        self._hint = ""
        self.setMouseTracking(True)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(name)
        look.changed.connect(self.update)

    def show_image(self, image: QImage) -> None:
        """Show a picture."""
        self._image, self._hint = image, ""
        self.update()

    def show_hint(self, hint: str) -> None:
        """Show why there is no picture."""
        self._image, self._hint = QImage(), hint
        self.update()

    def box(self) -> QRectF:
        """Return the area of the picture."""
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
        """Report the pixel."""
        box = self.box()
        if event is None or not box.contains(event.position()):
            self.pointed.emit(None)
            return
        place = event.position() - box.topLeft()
        column = min(int(place.x() / box.width() * self._image.width()), self._image.width() - 1)
        row = min(int(place.y() / box.height() * self._image.height()), self._image.height() - 1)
        self.pointed.emit((column, row))

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
        self.scale = ScaleBar(workspace.look, self._table)
        self.said, self.under = label(kind="muted"), label(kind="muted")
        self.key = label("Grey: nothing within range. Black: nearer than it measures.", "muted")
        self._pad = QWidget()
        self._beside = QBoxLayout(QBoxLayout.Direction.LeftToRight)
        self._lay_out()
        self.depth_view.pointed.connect(self._point)
        self.colour_view.pointed.connect(self._point)
        self.show_hint(NO_CAMERA)

    def begin(self, view: LiveView) -> None:
        """Clear the pictures: a flight begins."""
        self._newest, self._waits, self._asked = None, False, -np.inf
        has_camera = view.snapshot is not None and any(
            each.kind == KIND for each in view.snapshot.sensors
        )
        self.show_hint("Waiting for the first picture" if has_camera else NO_CAMERA)

    def refresh(self, view: LiveView) -> None:
        """Request the next picture if one is due and a camera is active."""
        snapshot = view.snapshot
        if snapshot is None or not any(each.kind == KIND for each in snapshot.sensors):
            return
        now = perf_counter()
        if self._waits or now < self._asked + EVERY:
            return
        self._asked, self._waits = now, True
        self._flight.order(lambda live: live.reading(KIND), self.show_reading, self._refuse)

    def show_reading(self, reading: object) -> None:
        """Show a picture; nothing is painted if it is unchanged."""
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
        self._pad.setVisible(not wide)  # so that the pictures can be one above the other
        half = (self.width() - self.scale.width()) // 2 if wide else self.height()
        self._beside.setStretch(0, half + (self.scale.width() if wide else 0))
        self._beside.setStretch(1, half)

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
        depth = hbox((self.depth_view, 1), self.scale, spacing=4)
        self._beside.setSpacing(10)
        self._beside.addLayout(depth, 1)
        self._pad.setFixedWidth(self.scale.width())
        colour = hbox((self.colour_view, 1), self._pad, spacing=4)
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


TURN = math.radians(10.0)
"""Rotation per key press [rad]."""
POINTS = 500.0
"""Number of points that would fill the width side by side, if there is much room."""
NEAREST, FARTHEST = 2.0, 200.0
"""Smallest and largest visible width [m]."""
NO_LIDAR = (
    "No lidar is on in this flight. Open a scenario with one, such as “network” or "
    "“all-sensors”, or list lidar under sensors in the scenario."
)


TOP = Viewpoint()
SIDE = Viewpoint(turn=math.pi / 2, tilt=0.0)
SLANTED = Viewpoint(turn=math.radians(25.0), tilt=math.radians(32.0))


def paint_points(
    seen: np.ndarray, colours: np.ndarray, ground: int, width: int, height: int, size: int
) -> np.ndarray:
    """Return a picture 0xffrrggbb (height, width) of projected points, the nearest on top.

    Args:
        seen: pixels right and down, and distance (n, 3).
        colours: colours of the points (n).
        ground: background colour.
        width: width of the picture [pixels].
        height: height of the picture [pixels].
        size: size of a point [pixels].
    """
    picture = np.full((height, width), ground, dtype=np.uint32)
    order = np.argsort(-seen[:, 2])
    u, v = seen[order, 0].astype(np.intp), seen[order, 1].astype(np.intp)
    inside = (u >= 0) & (u < width - size) & (v >= 0) & (v < height - size)
    u, v, ink = u[inside], v[inside], colours[order][inside]
    for down in range(size):
        for right in range(size):
            picture[v + down, u + right] = ink
    return picture


class CloudView(QWidget):
    """Shows points around the drone, which is in the centre.

    Drag, or arrow keys: rotate. Wheel, or + and -: zoom. T, S, P: view from the top, the side, or
    obliquely.

    Args:
        look: source of colours.
    """

    turned = pyqtSignal()
    """The viewpoint has changed."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._points = np.zeros((0, 3))
        self._values = np.zeros(0)
        self._ends = (0.0, 1.0)
        self._name = "Height m"
        self._heading = 0.0
        self._hint = ""
        self._dragged: QPointF | None = None
        self.viewpoint = SLANTED
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 160)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Lidar cloud")
        self.setAccessibleDescription("Arrows turn it, plus and minus change the distance")
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        look.changed.connect(self.update)

    def show_points(
        self, points: np.ndarray, values: np.ndarray, name: str, heading: float
    ) -> None:
        """Show points around the drone.

        Args:
            points: positions relative to the drone (n, 3) [m].
            values: values for the colours (n).
            name: name of the values, with unit.
            heading: heading of the drone in the frame of the points [rad].
        """
        self._points, self._values, self._name, self._heading = points, values, name, heading
        self._hint = ""
        if len(values):
            low, high = np.percentile(values, (1.0, 99.0))
            step = round_step(max(high - low, 0.5), 8)
            # whole steps, so that the colours do not flicker between scans
            self._ends = step * math.floor(low / step), step * math.ceil(high / step)
        self.update()

    def show_hint(self, hint: str) -> None:
        """Show why there are no points."""
        if hint != self._hint:
            self._points, self._values, self._hint = np.zeros((0, 3)), np.zeros(0), hint
            self.update()

    def look_from(self, viewpoint: Viewpoint) -> None:
        """Change the viewpoint."""
        width = min(max(viewpoint.width, NEAREST), FARTHEST)
        tilt = min(max(viewpoint.tilt, -math.pi / 2), math.pi / 2)
        self.viewpoint = dataclasses.replace(viewpoint, width=width, tilt=tilt)
        self.turned.emit()
        self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        painter.drawImage(0, 0, self._picture())
        self._paint_rings(painter)
        self._paint_drone(painter)
        ink = self._look.colour("ink")
        if self._hint:
            painter.setPen(self._look.colour("muted"))
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(QRectF(self.rect()).adjusted(20, 20, -20, -20), int(flags), self._hint)
        elif len(self._values):
            box = QRectF(self.width() - 88.0, 10.0, 84.0, min(260.0, self.height() - 20.0))
            painter.fillRect(box.adjusted(-6, -4, 0, 4), self._look.colour("field"))
            paint_scale(painter, box, *self._ends, self._table(), ink, self._name)
        if self.hasFocus():
            painter.setPen(QPen(self._look.colour("accent"), 2))
            painter.drawRect(self.rect().adjusted(1, 1, -1, -1))

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Start rotating."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self._dragged = event.position()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Rotate."""
        if event is not None and self._dragged is not None:
            way = event.position() - self._dragged
            self._dragged = event.position()
            self._turn(-way.x() * 0.008, way.y() * 0.008)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Stop rotating."""
        self._dragged = None

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom."""
        if event is not None:
            self._zoom(0.85 ** (event.angleDelta().y() / 120.0))
            event.accept()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Rotate by keys."""
        turns = {
            Qt.Key.Key_Left: (TURN, 0.0),
            Qt.Key.Key_Right: (-TURN, 0.0),
            Qt.Key.Key_Up: (0.0, TURN),
            Qt.Key.Key_Down: (0.0, -TURN),
        }
        zooms = {Qt.Key.Key_Plus: 0.8, Qt.Key.Key_Equal: 0.8, Qt.Key.Key_Minus: 1.25}
        views = {Qt.Key.Key_T: TOP, Qt.Key.Key_S: SIDE, Qt.Key.Key_P: SLANTED}
        key = event.key() if event is not None else 0
        if key in turns:
            self._turn(*turns[Qt.Key(key)])
        elif key in zooms:
            self._zoom(zooms[Qt.Key(key)])
        elif key in views:
            self.look_from(dataclasses.replace(views[Qt.Key(key)], width=self.viewpoint.width))
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show the keyboard focus."""
        self.update()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Hide the keyboard focus."""
        self.update()

    def _turn(self, turn: float, tilt: float) -> None:
        at = self.viewpoint
        self.look_from(dataclasses.replace(at, turn=at.turn + turn, tilt=at.tilt + tilt))

    def _zoom(self, factor: float) -> None:
        self.look_from(dataclasses.replace(self.viewpoint, width=self.viewpoint.width * factor))

    def _table(self) -> np.ndarray:
        # leaves out the end close to the background's brightness
        return colour_table(0.2, 1.0) if self._look.is_dark else colour_table(0.0, 0.82)

    def _picture(self) -> QImage:
        """Return the picture of the points in screen pixels."""
        ratio = self.devicePixelRatioF()
        width, height = max(1, int(self.width() * ratio)), max(1, int(self.height() * ratio))
        ground = self._look.colour("field").rgb() & 0xFFFFFFFF
        seen = self.viewpoint.project(self._points, width, height)
        colours = colours_of(self._values, *self._ends, self._table())
        size = round(max(2.0, self.width() / POINTS) * ratio)
        picture = image_of(paint_points(seen, colours, ground, width, height, size))
        picture.setDevicePixelRatio(ratio)
        return picture

    def _paint_rings(self, painter: QPainter) -> None:
        """Paint circles of round distances around the drone, at its height."""
        step = round_step(0.5 * self.viewpoint.width, 3)
        painter.setPen(QPen(self._look.colour("line"), 0))
        angles = np.linspace(0.0, 2.0 * math.pi, 73)
        circle = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
        for number in (1, 2, 3):
            seen = self.viewpoint.project(number * step * circle, self.width(), self.height())
            painter.setPen(QPen(self._look.colour("line"), 0))
            painter.drawPolyline(arrayToQPolygonF(seen[:, 0], seen[:, 1]))
            painter.setPen(self._look.colour("muted"))
            nearest = seen[int(np.argmin(seen[:, 2] - 1e-3 * seen[:, 1]))]
            painter.drawText(QPointF(nearest[0] + 4, nearest[1] - 3), f"{number * step:g} m")

    def _paint_drone(self, painter: QPainter) -> None:
        """Paint an arrow along the drone's x."""
        size = 0.035 * self.viewpoint.width
        c, s = math.cos(self._heading), math.sin(self._heading)
        shape = size * np.array([[1.0, 0, 0], [-0.7, 0.6, 0], [-0.35, 0, 0], [-0.7, -0.6, 0]])
        turned = shape @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        seen = self.viewpoint.project(turned, self.width(), self.height())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self._look.colour("field"), 1))
        painter.setBrush(self._look.colour("accent"))
        painter.drawPolygon(arrayToQPolygonF(seen[:, 0], seen[:, 1]))
        painter.setBrush(Qt.BrushStyle.NoBrush)


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
        self._lay_out()
        self.frame.currentIndexChanged.connect(self._show_anew)
        self.colours.currentIndexChanged.connect(self._show_anew)
        self.view.show_hint(NO_LIDAR)

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the cloud of a new flight."""
        self._rays = find_rays(topics)
        self._stamp = None
        self.said.setText("")
        self.view.show_hint("Waiting for the first scan" if self._rays is not None else NO_LIDAR)

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
            points, heading = points @ turned(roll, pitch, yaw).T, yaw
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
            f"{len(points)} of {len(ranges)} rays returned, nearest {number_text(nearest, 2)} m, "
            f"at {number_text(stamp, 2)} s"
        )

    def _show_anew(self) -> None:
        self._stamp = None
        self.refresh(self._signals.now)

    def _look_from(self, viewpoint: Viewpoint) -> None:
        self.view.look_from(Viewpoint(viewpoint.turn, viewpoint.tilt, self.view.viewpoint.width))
        self.view.setFocus()

    def _lay_out(self) -> None:
        views = (("&Top", TOP, "T"), ("Si&de", SIDE, "S"), ("S&lanted", SLANTED, "S"))
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
            (self.said, Qt.AlignmentFlag.AlignLeft),
            of=self,
            margins=(0, 8, 0, 0),
            spacing=8,
        )
