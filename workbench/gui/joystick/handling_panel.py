"""How strongly sticks are felt: a slider for each preference, and the curve that comes of it."""

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen, QPixmap, QPolygonF
from PyQt6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.joystick.piloting import NEUTRAL, StickCurve, Sticks
from workbench.gui.preference_table import find_preference
from workbench.gui.preferences import Preferences
from workbench.gui.style import dressed
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for

POINTS = 81
DOT = 3.5

NAMES = (
    "stick_speed",
    "stick_yaw_rate",
    "stick_sensitivity",
    "stick_expo",
    "stick_dead_band",
)
STEPS = 200
"""Of a slider, from end to end."""
PERCENT = Unit("%", 100.0)


class CurveView(QWidget):
    """Raw against shaped, with a dot for each axis that is pushed.

    Args:
        look: colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._curve, self._sticks = StickCurve(), NEUTRAL
        self._ground = QPixmap()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(130, 120)
        look.changed.connect(self._repaint)

    def sizeHint(self) -> QSize:
        """Return a small square."""
        return QSize(180, 170)

    def show_curve(self, curve: StickCurve) -> None:
        """Show a curve."""
        if curve != self._curve:
            self._curve = curve
            self._repaint()
        self.setAccessibleName(
            "Curve of the sticks: half stick asks for "
            f"{curve.shaped(0.5):.0%}, full stick for {curve.shaped(1.0):.0%}"
        )

    def show_sticks(self, sticks: Sticks) -> None:
        """Show where the sticks are on it."""
        if sticks != self._sticks:
            self._sticks = sticks
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        ratio = self.devicePixelRatioF()
        if self._ground.size() != (self.size().toSizeF() * ratio).toSize():
            self._paint_ground(ratio)
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._ground)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self._look.colour("card"), 1.0))
        painter.setBrush(self._look.colour("accent"))
        left, right = self._sticks.left, self._sticks.right
        for raw in (left.x, left.y, right.x, right.y):
            if raw != 0.0:
                painter.drawEllipse(self._at(raw, self._curve.shaped(raw)), DOT, DOT)

    @property
    def _box(self) -> QRectF:
        """The square from -1 to 1."""
        line = self.fontMetrics().height()
        side = max(20.0, min(self.width() - 4.0, self.height() - line - 6.0))
        return QRectF((self.width() - side) / 2, 2.0, side, side)

    def _at(self, raw: float, shaped: float) -> QPointF:
        box = self._box
        return QPointF(
            box.left() + (raw + 1.0) / 2 * box.width(),
            box.bottom() - (shaped + 1.0) / 2 * box.height(),
        )

    def _repaint(self) -> None:
        self._ground = QPixmap()
        self.update()

    def _paint_ground(self, ratio: float) -> None:
        self._ground = QPixmap((self.size().toSizeF() * ratio).toSize())
        self._ground.setDevicePixelRatio(ratio)
        self._ground.fill(Qt.GlobalColor.transparent)
        look, box = self._look, self._box
        painter = QPainter(self._ground)
        painter.setFont(self.font())
        painter.setPen(QPen(look.colour("line"), 1.0))
        painter.setBrush(look.colour("field"))
        painter.drawRect(box)
        dead = self._curve.dead_band
        painter.fillRect(QRectF(self._at(-dead, 1.0), self._at(dead, -1.0)), look.colour("line"))
        painter.drawLine(self._at(-1.0, 0.0), self._at(1.0, 0.0))
        painter.drawLine(self._at(0.0, -1.0), self._at(0.0, 1.0))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(look.colour("muted"), 1.0, Qt.PenStyle.DotLine))
        painter.drawLine(self._at(-1.0, -1.0), self._at(1.0, 1.0))
        painter.setPen(QPen(look.colour("accent"), 2.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        raws = np.linspace(-1.0, 1.0, POINTS)
        painter.drawPolyline(
            QPolygonF([self._at(raw, self._curve.shaped(raw)) for raw in raws.tolist()])
        )
        painter.setPen(look.colour("muted"))
        under = QRectF(0.0, box.bottom() + 3.0, self.width(), self.fontMetrics().height())
        painter.drawText(under, Qt.AlignmentFlag.AlignHCenter, "pushed → asked for ↑")
        painter.end()


class HandlingPanel(QWidget):
    """Sliders for the preferences of sticks.

    Args:
        preferences: where they are kept.
        look: colours.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        curve: drawn beside.
        sliders: by the name of their preference.
    """

    def __init__(self, preferences: Preferences, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._preferences = preferences
        self.curve = CurveView(look, self)
        self.sliders: dict[str, QSlider] = {}
        self._values: dict[str, QLabel] = {}
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(1, 1)
        for line, name in enumerate(NAMES):
            self._add(grid, line, name)
        defaults = dressed(QPushButton("Defaults", self), "quiet compact")
        defaults.setToolTip("Give all five their defaults.")
        defaults.setAccessibleName("Give the sticks their default handling")
        defaults.clicked.connect(self._reset)
        grid.setRowStretch(len(NAMES) + 1, 1)
        heading = dressed(QLabel("Feel of the sticks", self), "heading")
        top = QHBoxLayout()
        top.addWidget(heading)
        top.addStretch(1)
        top.addWidget(defaults)
        left = QVBoxLayout()
        left.setSpacing(0)
        left.addLayout(top)
        left.addLayout(grid, 1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addLayout(left, 3)
        layout.addWidget(self.curve, 1)
        preferences.changed.connect(self._follow)

    def _add(self, grid: QGridLayout, line: int, name: str) -> None:
        row = find_preference(name)
        slider = QSlider(Qt.Orientation.Horizontal, self)
        slider.setRange(0, STEPS)
        slider.setPageStep(STEPS // 10)
        slider.setToolTip(row.help)
        low, high = self._text(name, row.minimum), self._text(name, row.maximum)
        slider.setAccessibleName(f"{row.label}, {low} to {high}")
        label = QLabel(row.label, self)
        label.setBuddy(slider)
        label.setToolTip(row.help)
        value = QLabel(self)
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        value.setMinimumWidth(9 * self.fontMetrics().averageCharWidth())
        self.sliders[name], self._values[name] = slider, value
        for column, widget in enumerate((label, slider, value)):
            grid.addWidget(widget, line, column)
        self._follow(name)
        slider.valueChanged.connect(lambda place: self._move(name, place))

    def _move(self, name: str, place: int) -> None:
        row = find_preference(name)
        value = row.minimum + place / STEPS * (row.maximum - row.minimum)
        step = 0.1 if row.unit == "m/s" else 0.01
        self._preferences.set(name, min(max(round(value / step) * step, row.minimum), row.maximum))

    def _follow(self, name: str) -> None:
        """Show what is preferred now."""
        if name in ("speed_unit", "angle_unit"):
            for each in NAMES:
                self._values[each].setText(self._text(each, self._preferences.number(each)))
        if name not in self.sliders:
            return
        row, value = find_preference(name), self._preferences.number(name)
        slider = self.sliders[name]
        slider.blockSignals(True)
        slider.setValue(round((value - row.minimum) / (row.maximum - row.minimum) * STEPS))
        slider.blockSignals(False)
        self._values[name].setText(self._text(name, value))

    def _text(self, name: str, value: float) -> str:
        si = find_preference(name).unit
        if si == "1":
            return PERCENT.text(value, 0)
        return unit_for(si, self._preferences).text(value, 1)

    def _reset(self) -> None:
        for name in NAMES:
            self._preferences.reset(name)
