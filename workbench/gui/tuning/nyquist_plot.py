"""The Nyquist curve of a loop, both axes to one scale, with the disk that it must not enter."""

import math
from collections.abc import Sequence

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QColor, QMouseEvent, QShowEvent
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.content import Axis, Content, Guide, Line, Point
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.drawn_loop import DrawnLoop, counting
from workbench.gui.tuning.limit_table import find_limit
from workbench.gui.units import Unit
from workbench.gui.workspace import Workspace

MIDDLE, HALF = (-0.8, 0.0), 2.4
"""Middle and half the height of the picture, as `workbench judge` draws it."""
SPANS = (0.02, 200.0)
"""Smallest and largest half height."""
WIDEST = 60.0
"""A disk that reaches farther is drawn as if it reached so far: a straight edge."""
CROSS = 0.03
"""Half the size of the mark at -1, of the height."""
NEAR = 0.08
"""A curve this near to the mouse is read, of the height."""
DISK = find_limit("disk_margin")
TURN = np.linspace(0.0, 2.0 * np.pi, 181)


class Plane(Canvas):
    """A canvas that tells where the mouse is in the complex plane."""

    pointed = pyqtSignal(object)
    """A complex number, None where the mouse has left."""

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Tell the place."""
        if event is None:
            return
        place = self._scene_point(event.position())
        inside = self.view.sceneBoundingRect().contains(place)
        at = self.view.mapSceneToView(place)
        self.pointed.emit(complex(at.x(), at.y()) if inside else None)


class NyquistPlot(QWidget):
    """Draws open loops in the complex plane. Wheel: zoom about the mouse. Double click: all.

    Args:
        workspace: colours.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        canvas: where it is drawn.
    """

    pointed = pyqtSignal(object)
    """Frequency of the curve under the mouse [rad/s], None for none."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = workspace.look
        self._loops: tuple[DrawnLoop, ...] = ()
        self._cursor: float | None = None
        self._middle, self._half = MIDDLE, HALF
        self.canvas = Plane(workspace.look)
        self.setAccessibleName("Nyquist curve of the loop, with the disk of the disk margin")
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.canvas)
        self.canvas.pointed.connect(self._point)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.reset_wanted.connect(self.reset)
        self.canvas.resized.connect(self._draw)

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw these."""
        self._loops = tuple(loops)
        self._draw()

    def show_window(self, left: float, right: float) -> None:
        """Do nothing: the plane has no axis of frequency."""

    def set_cursor(self, frequency: float | None) -> None:
        """Mark a frequency [rad/s] on all curves, or none."""
        if frequency != self._cursor:
            self._cursor = frequency
            self._draw()

    def reset(self) -> None:
        """Show what surrounds -1."""
        self._middle, self._half = MIDDLE, HALF
        self._draw()

    def _turn(self, x: float, share: float, factor: float, _: bool) -> None:
        half = min(max(self._half * factor, SPANS[0]), SPANS[1])
        factor = half / self._half
        y = self._middle[1] + (2.0 * share - 1.0) * self._half
        self._middle = (
            x + (self._middle[0] - x) * factor,
            y + (self._middle[1] - y) * factor,
        )
        self._half = half
        self._draw()

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        bottom = self._middle[1] - self._half
        ends = [bottom + 2.0 * self._half * share for share in (low, high)]
        tall = max(ends[1] - ends[0], (right - left) / self._aspect)
        self._middle = 0.5 * (left + right), 0.5 * (ends[0] + ends[1])
        self._half = min(max(0.5 * tall, SPANS[0]), SPANS[1])
        self._draw()

    def _point(self, place: complex | None) -> None:
        """Tell the frequency of the curve nearest to the mouse."""
        found: tuple[float, float | None] = (NEAR * 2.0 * self._half, None)
        for loop in self._loops if place is not None else ():
            way = np.abs(loop.open_loop - place)
            if np.isfinite(way).any():
                nearest = int(np.nanargmin(way))
                if way[nearest] < found[0]:
                    found = float(way[nearest]), float(loop.frequency[nearest])
        self.pointed.emit(found[1])

    @property
    def _aspect(self) -> float:
        view = self.canvas.view
        return max(view.width(), 1.0) / max(view.height(), 1.0)

    def _draw(self) -> None:
        if not self.isVisible():
            return
        (x, y), half = self._middle, self._half
        wide = half * self._aspect
        plain = Unit("")
        self.canvas.show_content(
            Content(
                left=x - wide,
                right=x + wide,
                x_label="Re",
                x_unit="",
                axes=(Axis(plain, y - half, y + half, "Im"),),
                lines=tuple(self._lines()),
                points=tuple(self._points()),
                guides=(Guide((-math.inf, math.inf), (0.0, 0.0)),),
                caption=self._caption,
                hint="" if self._loops else "Not known yet: the analyst is asked",
            )
        )

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw what was set while nobody saw it."""
        self._draw()

    @property
    def _disk_margin(self) -> float:
        """Of the loop that counts; 0 where it is unstable."""
        loop = counting(self._loops)
        return loop.margins.disk_margin if loop is not None and loop.margins is not None else 0.0

    @property
    def _caption(self) -> str:
        if counting(self._loops) is None:
            return ""
        margin = self._disk_margin
        return f"disk {DISK.text(margin)}" if margin else "unstable"

    def _lines(self) -> list[Line]:
        look = self._look
        lines = [Line(np.cos(TURN), np.sin(TURN), 0, look.colour("muted"), CurveStyle.DASHED)]
        if self._disk_margin:
            lines.append(Line(*disk(self._disk_margin), 0, look.colour("bad")))
        for loop in self._loops:
            colour, response = look.curve(loop.colour), loop.open_loop
            mirrored = Line(response.real, -response.imag, 0, colour, CurveStyle.FAINT)
            lines += [mirrored, Line(response.real, response.imag, 0, colour, loop.style)]
        lines.append(_cross(complex(-1.0, 0.0), CROSS * 2.0 * self._half, look.colour("bad")))
        return lines

    def _points(self) -> list[Point]:
        """Return where the curves are at the cursor."""
        if self._cursor is None:
            return []
        found = [(loop.at(self._cursor, loop.open_loop), loop.colour) for loop in self._loops]
        return [Point(at.real, at.imag, 0, self._look.curve(colour)) for at, colour in found]


def _cross(at: complex, size: float, colour: QColor) -> Line:
    """Return a cross at a place, half as large as a size."""
    x = np.array([at.real - size, at.real + size, np.nan, at.real, at.real])
    y = np.array([at.imag, at.imag, np.nan, at.imag - size, at.imag + size])
    return Line(x, y, 0, colour)


def disk(margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the edge of the disk that a loop with a disk margin alpha (skew 0) stays out of.

    Its diameter lies on the real axis, from -(2 + alpha) / (2 - alpha) to its inverse.
    """
    share = min(0.5 * margin, 1.0 - 1.0 / WIDEST)
    near, far = (1.0 - share) / (1.0 + share), (1.0 + share) / (1.0 - share)
    radius = 0.5 * (far - near)
    return -0.5 * (near + far) + radius * np.cos(TURN), radius * np.sin(TURN)
