"""Where things are in a chart, and what a user does there with the mouse."""

from collections.abc import Callable

import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

from workbench.gui.charts.chart import Chart


class Mouse:
    """Points at times and shares of the height of a chart, as a user does."""

    def __init__(self, chart: Chart) -> None:
        self._canvas = chart.canvas
        self._widget = chart.canvas.viewport()

    def place(self, time: float, share: float = 0.5) -> QPoint:
        """The pixel of a time, in a share of the height from below."""
        QApplication.processEvents()  # a layout may be new
        content, view = self._canvas.content, self._canvas.view
        low, high = view.viewRange()[1]
        at = QPointF(time - content.origin, low + share * (high - low))
        return self._canvas.mapFromScene(view.mapViewToScene(at))

    def move(self, time: float) -> None:
        """Point at a time."""
        QTest.mouseMove(self._widget, QPoint(5, 5))
        QTest.mouseMove(self._widget, self.place(time))

    def leave(self) -> None:
        """Point at what is no curve."""
        QTest.mouseMove(self._widget, QPoint(5, 5))

    def drag(self, first: tuple[float, float], last: tuple[float, float]) -> None:
        """Draw a box from a time and share of the height to another."""
        start, end = self.place(*first), self.place(*last)
        QTest.mousePress(self._widget, Qt.MouseButton.LeftButton, pos=start)
        for share in (0.3, 0.6, 1.0):
            way = end - start
            at = start + QPoint(round(share * way.x()), round(share * way.y()))
            QTest.mouseMove(self._widget, at, 20)
        QTest.mouseRelease(self._widget, Qt.MouseButton.LeftButton, pos=end)

    def click_twice(self, time: float) -> None:
        """Click twice at a time."""
        QTest.mouseDClick(self._widget, Qt.MouseButton.LeftButton, pos=self.place(time))

    def wheel(self, time: float, steps: int, control: bool = False) -> None:
        """Turn the wheel at a time."""
        at = QPointF(self.place(time))
        held = Qt.KeyboardModifier.ControlModifier if control else Qt.KeyboardModifier.NoModifier
        event = QWheelEvent(
            *(at, self._widget.mapToGlobal(at), QPoint(), QPoint(0, 120 * steps)),
            *(Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False),
        )
        QApplication.sendEvent(self._widget, event)


@pytest.fixture
def mouse_on() -> Callable[[Chart], Mouse]:
    """The mouse over a chart."""
    return Mouse
