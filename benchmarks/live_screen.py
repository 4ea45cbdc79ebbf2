"""A screen that paints like the app's: four plots of three curves of 2,000 points, all the time."""

import math
import time
from collections.abc import Callable

import numpy as np
from PyQt6.QtCore import QPointF, Qt, QTimer
from PyQt6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF
from PyQt6.QtWidgets import QWidget

PLOTS, CURVES, POINTS = 4, 3, 2000
WIDTH, HEIGHT = 1200, 800
FRAME = 16
"""Between the beginnings of two frames at least [ms]."""
COLOURS = ("#1b6ca8", "#c0392b", "#2e8b57")


class Screen(QWidget):
    """Paints its curves anew, shifted a little, as often as the event loop lets it, up to 60 Hz.

    Args:
        look: called before each frame, as the app reads the newest snapshot there.
    """

    def __init__(self, look: Callable[[], None]) -> None:
        super().__init__()
        self.resize(WIDTH, HEIGHT)
        self.frames: list[float] = []
        self._look = look
        self._wave = np.sin(np.linspace(0.0, 60.0, POINTS))
        self._x = np.linspace(0.0, WIDTH / 2 - 20, POINTS)
        self._polygon = QPolygonF([QPointF()] * POINTS)
        memory = self._polygon.data()
        assert memory is not None
        memory.setsize(POINTS * 16)
        self._points = np.frombuffer(memory, np.float64).reshape(POINTS, 2)
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._next)
        self._timer.start(FRAME)

    def stop(self) -> None:
        """Paint no more."""
        self._timer.stop()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint all plots."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor("white"))
        for plot in range(PLOTS):
            for curve in range(CURVES):
                shift = 7 * len(self.frames) + 300 * curve
                self._points[:, 0] = 10 + plot % 2 * WIDTH / 2 + self._x
                middle = 10 + plot // 2 * HEIGHT / 2 + HEIGHT / 4
                self._points[:, 1] = middle + 50 * (curve + 1) * np.roll(self._wave, shift)
                painter.setPen(QPen(QColor(COLOURS[curve]), 1))
                painter.drawPolyline(self._polygon)
        painter.end()

    def _next(self) -> None:
        self._look()
        self.frames.append(time.perf_counter())
        self.repaint()


def compute(ended: Callable[[], bool]) -> None:
    """Compute in plain Python, as a search or a reader of files does, until told to end."""
    value = 0.0
    while not ended():
        for number in range(1000):
            value += math.sin(number)
