"""Shows what is asked and what is flown: four rows of two numbers and a bar."""

from dataclasses import dataclass

from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.joystick.piloting import FlightLimits, Handling, heading_velocity
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import unit_for
from workbench.session.snapshot import Snapshot

YAW_RATE = 3
FOLLOW = 7
"""Places in `Snapshot.reference`; the velocity stands before them."""

BAR = 8.0
"""Thickness of a bar [px]."""
TALLEST = 72.0
"""Row [px]."""


@dataclass(frozen=True)
class Answered:
    """One axis of a flight; a velocity [m/s] or a yaw rate [rad/s].

    Attributes:
        name: of the axis; positive is what it says first.
        unit: m/s or rad/s.
        asked: by whoever flies; None where the drone flies to a place of its own accord.
        flown: now.
        scale: that fills a bar: full stick, or what is flown beyond it.
        limit: of the flight, that is flown at most.
    """

    name: str
    unit: str
    asked: float | None
    flown: float
    scale: float
    limit: float


def answered(snapshot: Snapshot, handling: Handling, limits: FlightLimits) -> tuple[Answered, ...]:
    """Return the four axes of a flight; to the right is positive, as it is on a stick."""
    yaw = snapshot.roll_pitch_yaw[2]
    asked, follow = snapshot.reference, snapshot.reference[FOLLOW] > 0.0
    wanted = heading_velocity(asked[:3], yaw)
    flown = heading_velocity(snapshot.v_WB, yaw)
    speed, turn = handling.speed, handling.yaw_rate
    rows = (
        ("Forward", "m/s", wanted[0], flown[0], speed, limits.level),
        ("Right", "m/s", -wanted[1], -flown[1], speed, limits.level),
        ("Climb", "m/s", wanted[2], flown[2], speed, limits.climb),
        ("Turn right", "rad/s", -asked[YAW_RATE], -snapshot.w_WB[2], turn, limits.turn),
    )
    return tuple(
        Answered(name, unit, None if follow else want, fly, scale, limit)
        for name, unit, want, fly, scale, limit in rows
    )


class ResponseView(QWidget):
    """Paints rows of `Answered`.

    Args:
        look: colours.
        preferences: units that are shown.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, preferences: Preferences, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look, self._preferences = look, preferences
        self._rows: tuple[Answered, ...] = ()
        self._texts: tuple[tuple[str, str], ...] = ()
        self.setAccessibleName("Asked and flown: forward, right and climb, turn right")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return room for four rows."""
        line = self.fontMetrics().height()
        return QSize(28 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 28)

    def minimumSizeHint(self) -> QSize:
        """Return the least that is not cut."""
        line = self.fontMetrics().height()
        return QSize(34 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 20)

    def show_rows(self, rows: tuple[Answered, ...]) -> None:
        """Show the present."""
        if rows != self._rows:
            self._rows = rows
            self._texts = tuple(
                (self._text(row.asked, row), self._text(row.flown, row)) for row in rows
            )
            self.update()

    @property
    def texts(self) -> tuple[tuple[str, str], ...]:
        """What is written as asked and as flown, row by row."""
        return self._texts

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint all rows."""
        painter = QPainter(self)
        if not self._rows:
            painter.setPen(self._look.colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "No flight yet.")
            return
        line = self.fontMetrics().height()
        flags = Qt.AlignmentFlag
        width = float(self.width())
        column = min(0.36 * width, 13.0 * self.fontMetrics().averageCharWidth())
        painter.setPen(self._look.colour("muted"))
        head = QRectF(0.0, 0.0, width, line)
        painter.drawText(head, flags.AlignRight, "flown")
        painter.drawText(head.adjusted(0, 0, -column, 0), flags.AlignRight, "asked")
        height = min((self.height() - line) / max(1, len(self._rows)), TALLEST)
        for index, (row, (asked, flown)) in enumerate(zip(self._rows, self._texts, strict=True)):
            top = line + index * height + max(2.0, (height - line - BAR - 8.0) / 2)
            text = QRectF(0.0, top, width, line)
            painter.setPen(self._look.colour("ink"))
            painter.drawText(text, flags.AlignLeft, row.name)
            painter.drawText(text, flags.AlignRight, flown)
            painter.setPen(self._look.colour("command"))
            painter.drawText(text.adjusted(0, 0, -column, 0), flags.AlignRight, asked)
            self._paint_bar(painter, row, QRectF(0.0, top + line + 4.0, width, BAR))

    def _paint_bar(self, painter: QPainter, row: Answered, box: QRectF) -> None:
        """Paint what is flown as a bar, what is asked as a mark, and the limit as a fence."""
        look = self._look
        scale = 1.05 * max(row.scale, abs(row.flown), abs(row.asked or 0.0))
        middle, way = box.center().x(), box.width() / 2
        painter.fillRect(box, look.colour("line"))
        end = middle + way * row.flown / scale
        painter.fillRect(
            QRectF(min(middle, end), box.top(), abs(end - middle), BAR), look.colour("accent")
        )
        painter.setPen(QPen(look.colour("muted"), 1.0))
        painter.drawLine(round(middle), round(box.top()) - 1, round(middle), round(box.bottom()))
        if row.limit < scale:
            painter.setPen(QPen(look.colour("warning"), 1.0, Qt.PenStyle.DashLine))
            for side in (-1.0, 1.0):
                fence = round(middle + side * way * row.limit / scale)
                painter.drawLine(fence, round(box.top()) - 3, fence, round(box.bottom()) + 2)
        if row.asked is not None and abs(row.asked) > 0.01 * scale:
            at = middle + way * row.asked / scale
            painter.fillRect(QRectF(at - 1.5, box.top() - 4.0, 3.0, BAR + 8.0), look.colour("ink"))

    def _text(self, value: float | None, row: Answered) -> str:
        unit = unit_for(row.unit, self._preferences)
        decimals = 1 if unit.symbol == "°/s" else 2
        return "to a place" if value is None else unit.text(value, decimals)
