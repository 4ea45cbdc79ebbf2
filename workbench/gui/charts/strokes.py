"""Curves as polygons and pens of Qt."""

import math
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF
from PyQt6.QtGui import QColor, QPainter, QPen, QPolygonF

from workbench.gui.charts.curve_style import CurveStyle
from workbench.gui.charts.layout import Layout
from workbench.gui.charts.scene import Line, Scene

FAINT_SHARE = 0.45
"""Of its colour that a faint curve keeps."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A curve that only has to be painted.

    Attributes:
        pen: one pixel wide, which is what Qt paints fast.
        polygons: a part without gap each.
        number: at its end.
        end: pixel of its end, None without any point.
    """

    pen: QPen
    polygons: tuple[QPolygonF, ...]
    number: int
    end: QPointF | None

    def paint(self, painter: QPainter) -> None:
        """Paint the curve."""
        painter.setPen(self.pen)
        for polygon in self.polygons:
            painter.drawPolyline(polygon)


class StrokeMaker:
    """Makes strokes on a ground; its pens are made once.

    Args:
        ground: behind the curves, as #rrggbb.
    """

    def __init__(self, ground: str) -> None:
        self.ground = ground
        self._pens: dict[tuple[str, CurveStyle], QPen] = {}

    def make(self, scene: Scene, layout: Layout, line: Line) -> Stroke:
        """Return a line of a scene as it is painted."""
        points = layout.points(scene, scene.axes[line.axis], line.time, line.values)
        polygons = tuple(map(polygon_of, _parts(points)))
        has_end = bool(polygons) and not math.isnan(points[-1, 1])
        end = QPointF(points[-1, 0], points[-1, 1]) if has_end else None
        return Stroke(self._pen(line.colour, line.style), polygons, line.number, end)

    def _pen(self, colour: str, style: CurveStyle) -> QPen:
        key = colour, style
        if key not in self._pens:
            self._pens[key] = make_pen(QColor(colour), style, QColor(self.ground))
        return self._pens[key]


def make_pen(colour: QColor, style: CurveStyle, ground: QColor) -> QPen:
    """Return the pen of a curve; a faint colour is mixed, as blending is slow."""
    if style is CurveStyle.FAINT:
        colour = mixed(colour, ground, FAINT_SHARE)
    pen = QPen(colour, 1)
    pen.setCosmetic(True)
    if style is CurveStyle.DASHED:
        pen.setDashPattern([6.0, 4.0])
    return pen


def mixed(colour: QColor, ground: QColor, share: float) -> QColor:
    """Return a colour of which a share is kept over a ground."""
    parts = zip(colour.getRgb()[:3], ground.getRgb()[:3], strict=True)
    return QColor(*(round(share * (a or 0) + (1.0 - share) * (b or 0)) for a, b in parts))


def polygon_of(points: np.ndarray) -> QPolygonF:
    """Return points (n, 2) as Qt has them, written in one go."""
    polygon = QPolygonF()
    polygon.fill(QPointF(), len(points))
    memory = polygon.data()
    if len(points) and memory is not None:
        memory.setsize(16 * len(points))
        np.asarray(memory).view(np.float64).reshape(-1, 2)[:] = points
    return polygon


def _parts(points: np.ndarray) -> list[np.ndarray]:
    """Return the runs of points without a gap; a lonely one becomes a dot."""
    if not math.isnan(points[:, 1].sum()):
        return [points] if len(points) else []
    finite = np.isfinite(points[:, 1])
    ends = np.flatnonzero(np.diff(np.concatenate([[False], finite, [False]]).astype(np.int8)))
    runs = [points[first:last] for first, last in zip(ends[::2], ends[1::2], strict=True)]
    return [np.vstack([run, run + (1.0, 0.0)]) if len(run) == 1 else run for run in runs]
