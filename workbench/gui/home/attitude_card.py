"""Attitude and heading: artificial horizon, compass tape, and the same as numbers."""

import math

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QColor, QLinearGradient, QPainter, QPen, QPixmap, QPolygonF
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.card import Card, beside, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.attitude_indicator import AttitudeIndicator, attitude_of
from workbench.gui.instruments.heading import heading_of, mark_text, point_of
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.readout import Line, Readout
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

SEEN = 120.0
"""Degrees that the tape shows at once."""
FINEST = 0.1
"""Less than this is no change [degrees]."""

LABELS = ("Roll", "Pitch", "Yaw", "Heading")


class HeadingTape(Instrument):
    """Shows the heading, in degrees clockwise from north."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Heading", parent)
        self._heading = math.nan
        self._tape: QPixmap | None = None
        self._cover = QPixmap()

    @property
    def heading(self) -> float:
        """What is shown [degrees], no number before the first."""
        return self._heading

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        if math.isnan(self._heading):
            return "no heading yet"
        return f"heading {self._heading:.0f} degrees, {point_of(self._heading)}"

    def show_yaw(self, yaw: float) -> None:
        """Show the heading of a yaw [rad]; of what is no number, none."""
        known = math.isfinite(yaw)
        heading = FINEST * round(heading_of(yaw) / FINEST) % 360.0 if known else math.nan
        if heading != self._heading and (known or not math.isnan(self._heading)):
            self._heading = heading
            self.update()

    def sizeHint(self) -> QSize:
        """Return a size at which all is readable."""
        return QSize(240, round(2.6 * self.text_size))

    def renew(self) -> None:
        """Paint the tape again, too."""
        self._tape = None
        super().renew()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the part of the tape that is seen, and the pointer before it."""
        if math.isnan(self._heading):
            return
        if self._tape is None:
            self._tape, self._cover = self._painted_tape(), self._painted_cover()
        ratio = self._tape.devicePixelRatio()
        left = self._heading / 360.0 * self._turn * ratio
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        source = QRectF(left, 0.0, self.width() * ratio, self.height() * ratio)
        painter.drawPixmap(self.area, self._tape, source)
        painter.drawPixmap(QPointF(0.0, 0.0), self._cover)

    def _painted_cover(self) -> QPixmap:
        """Return what stands before the tape: its ends fade into the card; the pointer."""
        ratio = self.devicePixelRatioF()
        cover = QPixmap(round(self.width() * ratio), round(self.height() * ratio))
        cover.setDevicePixelRatio(ratio)
        cover.fill(Qt.GlobalColor.transparent)
        painter = QPainter(cover)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        width, shade = 2.2 * self.text_size, QColor(self.colour("card"))
        clear = QColor(shade)
        clear.setAlpha(0)
        for inner, outer in ((width, 0.0), (self.width() - width, float(self.width()))):
            gradient = QLinearGradient(outer, 0.0, inner, 0.0)
            gradient.setColorAt(0.45, shade)
            gradient.setColorAt(1.0, clear)
            painter.fillRect(QRectF(min(inner, outer), 0.0, width, self.height()), gradient)
        middle, size = self.width() / 2, 0.42 * self.text_size
        corners = (
            QPointF(middle, self.height() - 1.6 * size),
            QPointF(middle - size, self.height()),
            QPointF(middle + size, self.height()),
        )
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour("accent"))
        painter.drawPolygon(QPolygonF(corners))
        painter.end()
        return cover

    @property
    def _turn(self) -> float:
        """Length of a whole turn [px]."""
        return self.width() * 360.0 / SEEN

    def _painted_tape(self) -> QPixmap:
        """Return a whole turn, and half of what is seen on either side of it."""
        ratio = self.devicePixelRatioF()
        width = self._turn + self.width()
        tape = QPixmap(round(width * ratio) + 2, round(self.height() * ratio))
        tape.setDevicePixelRatio(ratio)
        tape.fill(self.colour("card"))
        painter = QPainter(tape)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        size = self.text_size
        top = self.height() - 0.75 * size
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.drawLine(QPointF(0.0, top), QPointF(width, top))
        edge = int(SEEN / 2)
        for degrees in range(-edge - 5, 360 + edge + 6, 5):
            x = self.width() / 2 + degrees / 360.0 * self._turn
            numbered = degrees % 45 == 0 or degrees % 30 == 0
            length = (0.55 if degrees % 10 == 0 else 0.3) * size
            painter.setPen(QPen(self.colour("ink" if numbered else "muted"), 1.2))
            painter.drawLine(QPointF(x, top), QPointF(x, top - length))
            if numbered:
                point = degrees % 45 == 0
                painter.setFont(self.face(1.0 if point else 0.9, bold=point))
                painter.drawText(
                    QRectF(x - 2 * size, top - 0.6 * size - 1.25 * size, 4 * size, 1.25 * size),
                    Qt.AlignmentFlag.AlignCenter,
                    mark_text(degrees),
                )
        painter.end()
        return tape


def heading_text(yaw: float) -> str:
    """Return the heading of a yaw [rad] with all its digits, as 007.5."""
    if not math.isfinite(yaw):
        return "–"
    return f"{round(heading_of(yaw), 1) % 360.0:05.1f}"


class AttitudeCard(Card):
    """The horizon as it is seen ahead.

    The angles are those of the frames in use: W is east-north-up and B forward-left-up, so a
    positive roll lowers the right side, a positive pitch the nose, and yaw is 0 to the east. The
    heading is the compass's, clockwise from north.
    """

    name = "attitude"
    title = "Attitude"

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, units, parent)
        self.indicator = AttitudeIndicator(look, self)
        self.tape = HeadingTape(look, self)
        self.table = Readout(
            look,
            "Angles",
            [Line(label) for label in LABELS],
            widest="\N{MINUS SIGN}888.8",
            parent=self,
        )
        self.parts = [self.indicator, self.tape, self.table]
        self.use_units(units)
        self.set_note("+ right side down, + nose down")

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        for index, label in enumerate(LABELS[:3]):
            self.table.set_line(index, Line(label, units.angle.unit.symbol))
        self.table.set_line(3, Line(LABELS[3], "°"))

    def place_parts(self, body: QRectF) -> None:
        """Put the tape below dial and numbers."""
        size = self.text_size
        upper = body.adjusted(0.0, 0.0, 0.0, -2.9 * size)
        picture, numbers = beside(upper, 1.2 * size, 7.0 * size)
        put(self.indicator, picture)
        put(self.table, numbers)
        tape = QRectF(body)
        tape.setTop(body.bottom() - 2.6 * size)
        put(self.tape, tape)

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Turn the horizon and the tape."""
        self.indicator.show_attitude(attitude_of(now.q_WB))
        self.tape.show_yaw(now.roll_pitch_yaw[2])

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the angles."""
        for index, angle in enumerate(now.roll_pitch_yaw):
            self.table.show_row(index, self.units.angle.text(angle))
        self.table.show_row(3, heading_text(now.roll_pitch_yaw[2]))
