"""What the flight is doing: its mode as a word and a shape, rotors on or off, wind."""

import math
from collections.abc import Mapping

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QPolygonF

from workbench.control.mode import FlightMode, Reason
from workbench.gui.home.card import Card
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.heading import direction_of, point_of
from workbench.gui.instruments.sign import Sign
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

UP = ((0.5, 0.08), (0.95, 0.62), (0.05, 0.62))
DOWN = ((0.5, 0.92), (0.95, 0.38), (0.05, 0.38))
ALONG = ((0.92, 0.5), (0.38, 0.95), (0.38, 0.05))
DIAMOND = ((0.5, 0.05), (0.95, 0.5), (0.5, 0.95), (0.05, 0.5))
"""Corners in a square of side 1, from its top left."""

PHASES: Mapping[Phase, tuple[str, Sign]] = {
    Phase.PAUSED: ("paused", Sign.WARNING),
    Phase.BROKEN: ("broken: reset to fly again", Sign.BAD),
    Phase.ENDED: ("ended: open a scenario", Sign.BAD),
}
"""What is told of a flight that does not go on."""
HELD = ("held: reset to fly again", Sign.BAD)
"""And of one whose autopilot has ended."""
CALM = 0.05
"""Less wind than this is none [m/s]."""


def paint_mode(painter: QPainter, place: QRectF, mode: FlightMode, colour: QColor) -> None:
    """Paint the shape of a mode.

    Off is an empty circle, armed one with a dot; hovering a diamond; climbing a triangle up, with
    the ground under it at a take-off; so downwards; cruising a triangle to the right.

    Args:
        painter: with antialiasing.
        place: a square.
        mode: to paint.
        colour: of it.
    """
    thick = QPen(colour, max(1.5, place.width() / 11.0))
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    match mode:
        case FlightMode.OFF | FlightMode.ARMED:
            inset = 0.14 * place.width()
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(thick)
            painter.drawEllipse(place.adjusted(inset, inset, -inset, -inset))
            if mode is FlightMode.ARMED:
                painter.setBrush(colour)
                painter.drawEllipse(place.center(), inset, inset)
        case FlightMode.HOVERING:
            _paint_corners(painter, place, DIAMOND)
        case FlightMode.CRUISING:
            _paint_corners(painter, place, ALONG)
        case FlightMode.TAKING_OFF | FlightMode.ASCENDING:
            _paint_corners(painter, place, UP)
        case FlightMode.LANDING | FlightMode.DESCENDING:
            _paint_corners(painter, place.translated(0.0, -0.1 * place.height()), DOWN)
    if mode in (FlightMode.TAKING_OFF, FlightMode.LANDING):
        painter.setPen(thick)
        y = place.top() + 0.93 * place.height()
        painter.drawLine(QPointF(place.left(), y), QPointF(place.right(), y))


def _paint_corners(
    painter: QPainter, place: QRectF, corners: tuple[tuple[float, float], ...]
) -> None:
    painter.drawPolygon(
        QPolygonF(
            [
                QPointF(place.left() + x * place.width(), place.top() + y * place.height())
                for x, y in corners
            ]
        )
    )


def wind_text(wind: tuple[float, float, float], units: ShownUnits) -> str:
    """Return a wind in words: how fast, and where it comes from.

    Args:
        wind: velocity of the air in W [m/s].
        units: in which it is said.
    """
    if not all(map(math.isfinite, wind)):
        return "wind –"
    east, north, up = wind
    level = math.hypot(east, north)
    parts = []
    if level >= CALM:
        source = direction_of(-east, -north)
        said = units.speed.unit.text(level, 1)
        parts.append(f"wind {said} from {source:03.0f}° ({point_of(source)})")
    if abs(up) >= CALM:
        said = units.speed.unit.text(abs(up), 1)
        parts.append(f"{'up' if up > 0.0 else 'down'} {said}")
    return ", ".join(parts) or "no wind"


class ConditionCard(Card):
    """The flight mode, large."""

    name = "condition"
    title = "Flight condition"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.mode = FlightMode.OFF
        self.facts = ""

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"{self.mode.label}, {self.facts}"

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show mode, rotors and wind."""
        ended = now.reason is Reason.AUTOPILOT_ENDED
        rotors = "rotors off" if ended or now.mode is FlightMode.OFF else "rotors on"
        self.set_note(*PHASES.get(view.phase, HELD if ended else ("", None)))
        facts = f"{rotors} · {wind_text(now.wind, self.units)}"
        if now.reason.label:
            facts = f"{now.reason.label} · {facts}"
        if (now.mode, facts) != (self.mode, self.facts):
            self.mode, self.facts = now.mode, facts
            self.update(self.body.toAlignedRect())

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint mode and facts."""
        super().paint_moving(painter, rect)
        if not self.facts:
            self._paint_nothing(painter)
            return
        body, size = self.body, self.text_size
        high = min(body.height(), 3.8 * size)
        top = body.top() + (body.height() - high) / 2
        side = 1.7 * size
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        shape = QRectF(body.left() + 0.1 * size, top + 0.2 * size, side, side)
        paint_mode(painter, shape, self.mode, self.colour("accent"))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setFont(self.face(1.6, bold=True))
        painter.setPen(self.colour("ink"))
        word = QRectF(body.left() + 2.4 * size, top, body.width(), 2.1 * size)
        painter.drawText(word, left, self.mode.label.capitalize())
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        line = QRectF(body.left(), top + 2.2 * size, body.width(), 1.5 * size)
        painter.drawText(line, left, self.facts)

    def _paint_nothing(self, painter: QPainter) -> None:
        """Paint that there is no flight yet."""
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(self.body, left, "Nothing flies yet: open a scenario.")
