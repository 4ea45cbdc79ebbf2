"""The drone's response beside its command, as a row of bars for each axis of the sticks."""

from dataclasses import dataclass

from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.joystick.piloting import FlightLimits, Handling, heading_velocity
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import unit_for
from workbench.session.snapshot import Snapshot

REFERENCE_YAW_RATE_INDEX = 3
REFERENCE_FOLLOW_INDEX = 7
"""Index in `Snapshot.reference`; the velocity precedes it."""
RESPONSE_BAR_PX = 8.0
"""Thickness of a bar [px]."""
MAX_RESPONSE_ROW_PX = 72.0
"""Largest height of a row [px]."""


@dataclass(frozen=True)
class AxisResponse:
    """One axis of a flight; a velocity [m/s] or a yaw rate [rad/s].

    Attributes:
        name: name of the axis; its first direction is positive.
        unit: m/s or rad/s.
        asked: command of the pilot; None while the drone flies to a place by itself.
        flown: present value.
        scale: full length of a bar: full stick, or the flown value if it is larger.
        limit: limit of the flight.
    """

    name: str
    unit: str
    asked: float | None
    flown: float
    scale: float
    limit: float


def axis_responses(
    snapshot: Snapshot, handling: Handling, limits: FlightLimits
) -> tuple[AxisResponse, ...]:
    """Return the four axes of a flight; right is positive, as on a stick."""
    yaw = snapshot.roll_pitch_yaw[2]
    asked, follow = snapshot.reference, snapshot.reference[REFERENCE_FOLLOW_INDEX] > 0.0
    wanted = heading_velocity(asked[:3], yaw)
    flown = heading_velocity(snapshot.v_WB, yaw)
    speed, turn = handling.speed, handling.yaw_rate
    rows = (
        ("Forward", "m/s", wanted[0], flown[0], speed, limits.level),
        ("Right", "m/s", -wanted[1], -flown[1], speed, limits.level),
        ("Climb", "m/s", wanted[2], flown[2], speed, limits.climb),
        (
            "Turn right",
            "rad/s",
            -asked[REFERENCE_YAW_RATE_INDEX],
            -snapshot.w_WB[2],
            turn,
            limits.turn,
        ),
    )
    return tuple(
        AxisResponse(name, unit, None if follow else want, fly, scale, limit)
        for name, unit, want, fly, scale, limit in rows
    )


class ResponseView(QWidget):
    """Paints rows of `AxisResponse`.

    Args:
        look: source of colours.
        preferences: source of units.
    """

    def __init__(self, look: Look, preferences: Preferences) -> None:
        super().__init__()
        self._look, self._preferences = look, preferences
        self._rows: tuple[AxisResponse, ...] = ()
        self._texts: tuple[tuple[str, str], ...] = ()
        self.setAccessibleName("Commanded and flown: forward, right and climb, turn right")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return the size of four rows."""
        line = self.fontMetrics().height()
        return QSize(28 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 28)

    def minimumSizeHint(self) -> QSize:
        """Return the least size without clipping."""
        line = self.fontMetrics().height()
        return QSize(34 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 20)

    def show_rows(self, rows: tuple[AxisResponse, ...]) -> None:
        """Show the present."""
        if rows != self._rows:
            self._rows = rows
            self._texts = tuple(
                (self._text(row.asked, row), self._text(row.flown, row)) for row in rows
            )
            self.update()

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
        height = min((self.height() - line) / max(1, len(self._rows)), MAX_RESPONSE_ROW_PX)
        for index, (row, (asked, flown)) in enumerate(zip(self._rows, self._texts, strict=True)):
            top = line + index * height + max(2.0, (height - line - RESPONSE_BAR_PX - 8.0) / 2)
            text = QRectF(0.0, top, width, line)
            painter.setPen(self._look.colour("ink"))
            painter.drawText(text, flags.AlignLeft, row.name)
            painter.drawText(text, flags.AlignRight, flown)
            painter.setPen(self._look.colour("command"))
            painter.drawText(text.adjusted(0, 0, -column, 0), flags.AlignRight, asked)
            self._paint_bar(painter, row, QRectF(0.0, top + line + 4.0, width, RESPONSE_BAR_PX))

    def _paint_bar(self, painter: QPainter, row: AxisResponse, box: QRectF) -> None:
        """Paint the flown value as a bar, the command as a mark, and the limit as a line."""
        look = self._look
        scale = 1.05 * max(row.scale, abs(row.flown), abs(row.asked or 0.0))
        middle, way = box.center().x(), box.width() / 2
        painter.fillRect(box, look.colour("line"))
        end = middle + way * row.flown / scale
        painter.fillRect(
            QRectF(min(middle, end), box.top(), abs(end - middle), RESPONSE_BAR_PX),
            look.colour("accent"),
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
            painter.fillRect(
                QRectF(at - 1.5, box.top() - 4.0, 3.0, RESPONSE_BAR_PX + 8.0), look.colour("ink")
            )

    def _text(self, value: float | None, row: AxisResponse) -> str:
        unit = unit_for(row.unit, self._preferences)
        return "to a place" if value is None else unit.text(value)
