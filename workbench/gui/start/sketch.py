"""A drawing of a drone, a scenario or a flight from above, in plain numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QPixmap, QPolygonF

from workbench.gui.recent_files import FileKind
from workbench.gui.theme import Look

SketchPoint = tuple[float, float]
SKETCH_MARGIN_PX = 8.0
PLACEHOLDER_OPACITY = 0.3


@dataclass(frozen=True)
class Sketch:
    """A drawing; x is to the right, y up, both in the same unit.

    Attributes:
        areas: filled outlines, as obstacles.
        circles: x, y and radius, as rotors.
        lines: straight lines, as arms.
        path: a curve, as a flown path.
        said: what it is, in a few words.
        fault: why the file cannot be read, as a sentence; "" if it can.
        least_span: least shown width and height.
    """

    areas: tuple[tuple[SketchPoint, ...], ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    lines: tuple[tuple[SketchPoint, ...], ...] = ()
    path: tuple[SketchPoint, ...] = ()
    said: str = ""
    fault: str = ""
    least_span: float = 1e-6

    @property
    def points(self) -> list[SketchPoint]:
        """All points that must be visible."""
        rims = [
            (x + side * radius, y + side * radius)
            for x, y, radius in self.circles
            for side in (-1.0, 1.0)
        ]
        parts = (*self.areas, *self.lines, self.path)
        return [*rims, *(point for part in parts for point in part)]


_CORNERS = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
PLACEHOLDER_SKETCHES = {
    FileKind.MODEL: Sketch(
        circles=tuple((x, y, 0.8) for x, y in _CORNERS),
        lines=tuple(((0.0, 0.0), corner) for corner in _CORNERS),
    ),
    FileKind.SCENARIO: Sketch(
        areas=(((0.5, 1.2), (0.8, 1.2), (0.8, 1.5), (0.5, 1.5)),),
        path=((0.0, 0.0), (2.0, 0.0), (2.0, 1.5)),
    ),
    FileKind.LOG: Sketch(path=((0.0, 0.0), (1.0, 0.8), (2.0, 0.4), (3.0, 1.2))),
}
"""Drawing of a file of each kind until its own is drawn."""


def sketch_pixmap(
    sketch: Sketch, look: Look, width: int, height: int, ratio: float, *, fades: bool = False
) -> QPixmap:
    """Return a drawing as a picture.

    Args:
        sketch: the drawing.
        look: source of colours.
        width: width of the picture [px].
        height: height of the picture [px].
        ratio: screen pixels per layout pixel.
        fades: whether it is pale, as a placeholder.
    """
    pixmap = QPixmap(round(width * ratio), round(height * ratio))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(look.colour("field"))
    points = sketch.points
    if not points:
        return pixmap
    xs, ys = zip(*points, strict=True)
    span_x = max(max(xs) - min(xs), sketch.least_span)
    span_y = max(max(ys) - min(ys), sketch.least_span)
    room = QRectF(0, 0, width, height).adjusted(*2 * (SKETCH_MARGIN_PX,), *2 * (-SKETCH_MARGIN_PX,))
    scale = min(room.width() / span_x, room.height() / span_y)
    middle = (max(xs) + min(xs)) / 2.0, (max(ys) + min(ys)) / 2.0

    def place(point: Sequence[float]) -> QPointF:
        right, up = point[0] - middle[0], point[1] - middle[1]
        return room.center() + QPointF(scale * right, -scale * up)

    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setOpacity(PLACEHOLDER_OPACITY if fades else 1.0)
    painter.setPen(QPen(look.colour("muted"), 1.0))
    painter.setBrush(look.colour("line"))
    for area in sketch.areas:
        painter.drawPolygon(QPolygonF([place(point) for point in area]))
    painter.setPen(QPen(look.colour("ink"), 3.0, cap=Qt.PenCapStyle.RoundCap))
    for line in sketch.lines:
        painter.drawPolyline(QPolygonF([place(point) for point in line]))
    painter.setPen(QPen(look.colour("accent"), 1.5))
    painter.setBrush(_faint(look.colour("accent")))
    for x, y, radius in sketch.circles:
        painter.drawEllipse(place((x, y)), scale * radius, scale * radius)
    if sketch.path:
        painter.setPen(QPen(look.colour("accent"), 2.0, join=Qt.PenJoinStyle.RoundJoin))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(QPolygonF([place(point) for point in sketch.path]))
        painter.setBrush(look.colour("accent"))
        painter.drawEllipse(place(sketch.path[0]), 4.0, 4.0)
    painter.end()
    return pixmap


def _faint(colour: QColor) -> QColor:
    faint = QColor(colour)
    faint.setAlphaF(0.18)
    return faint
