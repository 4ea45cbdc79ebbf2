"""Attitude and heading: artificial horizon, compass tape, and numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QLinearGradient, QPainter, QPen, QPixmap, QPolygonF
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.cards import Card, beside, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.heading import heading_of, mark_text, point_of
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.readout import Line
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

LADDER_STEP = 10
"""Spacing of the pitch ladder's numbered lines [degrees]."""
VIEW = math.radians(32.0)
"""Angle from the centre to the rim [rad]."""
FINEST_TILT = math.radians(0.05)
"""Smaller changes are not shown [rad]."""
ROLL_MARKS = (-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60)
"""Marks of the roll scale [degrees]."""
LADDER_MINOR = 5
"""Spacing of the ladder's lines, every other one short [degrees]."""
SEEN = 120.0
"""Visible part of the tape [degrees]."""
TAPE_STEP = 0.1
"""Smaller changes are not shown [degrees]."""
LABELS = ("Roll", "Pitch", "Yaw", "Heading")


@dataclass(frozen=True)
class Attitude:
    """The tilt of a body whose axes point forward, left and up.

    Both have the signs that pilots use. `roll_pitch_yaw` has the same bank, but the opposite sign
    for the nose: a rotation about the left axis lowers it.

    Attributes:
        nose_up: elevation of the forward axis above the horizon [rad], -pi/2 .. pi/2.
        bank: bank angle, right side down is positive [rad], -pi .. pi.
    """

    nose_up: float
    bank: float

    def rounded(self, step: float) -> "Attitude":
        """Return it rounded to steps [rad], so that invisible changes are ignored."""
        return Attitude(step * round(self.nose_up / step), step * round(self.bank / step))

    @property
    def sky(self) -> tuple[float, float]:
        """Direction of the sky on the screen, right and down, a unit vector.

        With the right side down, the sky leans to the left.
        """
        return -math.sin(self.bank), -math.cos(self.bank)


def attitude_of(q_WB: Sequence[float]) -> Attitude | None:
    """Return the attitude of an orientation, None if it is not finite.

    Args:
        q_WB: unit quaternion w, x, y, z of the body B in the world W, whose z is up.
    """
    if not all(map(math.isfinite, q_WB)):
        return None
    w, x, y, z = q_WB
    forward = 2.0 * (x * z - w * y)  # world z in the body's axes: third row of the rotation matrix
    left = 2.0 * (y * z + w * x)
    up = 1.0 - 2.0 * (x * x + y * y)
    return Attitude(math.asin(max(-1.0, min(1.0, forward))), math.atan2(left, up))


@dataclass(frozen=True)
class Horizon:
    """Maps the sky to a round window.

    Attributes:
        attitude: attitude of the body.
        radius: radius of the window [px].
        view: angle from the centre of the window to its rim [rad].
    """

    attitude: Attitude
    radius: float
    view: float

    def height(self, elevation: float) -> float:
        """Return the distance of an elevation [rad] from the centre, towards the sky [px]."""
        return (elevation - self.attitude.nose_up) / self.view * self.radius

    @property
    def line(self) -> float:
        """Distance of the horizon [px]; a rim of sky or earth is always visible."""
        most = 0.88 * self.radius
        return max(-most, min(most, self.height(0.0)))

    def place(self, height: float, aside: float = 0.0) -> tuple[float, float]:
        """Return a position in the window relative to its centre, right and down [px].

        Args:
            height: distance towards the sky.
            aside: distance along the horizon, to the viewer's right.
        """
        right, down = self.attitude.sky
        return height * right - aside * down, height * down + aside * right

    def ladder(self, least: int = LADDER_STEP) -> tuple[int, ...]:
        """Return the elevations of the ladder lines that are well within the window [degrees]."""
        middle = math.degrees(self.attitude.nose_up)
        reach = 0.62 * math.degrees(self.view)
        first = math.ceil(max(-90.0, middle - reach) / least)
        last = math.floor(min(90.0, middle + reach) / least)
        return tuple(k * least for k in range(first, last + 1) if k)


class AttitudeIndicator(Instrument):
    """Shows bank and pitch as a window to the horizon, in which the drone is fixed.

    The scale on the rim is fixed to the drone; the pointer points to the zenith.

    Attributes:
        attitude: the shown attitude, None before the first.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Attitude indicator", parent)
        self.attitude: Attitude | None = None
        self._drone: QPixmap | None = None

    @property
    def spoken(self) -> str:
        """The attitude as a sentence."""
        if self.attitude is None:
            return "no attitude yet"
        nose, bank = math.degrees(self.attitude.nose_up), math.degrees(self.attitude.bank)
        return (
            f"nose {abs(nose):.0f} degrees {'up' if nose >= 0.0 else 'down'}, "
            f"{'right' if bank >= 0.0 else 'left'} side {abs(bank):.0f} degrees down"
        )

    def show_attitude(self, attitude: Attitude | None) -> None:
        """Show an attitude, None if unknown."""
        rounded = attitude.rounded(FINEST_TILT) if attitude is not None else None
        if (self.attitude is None) != (rounded is None):
            self.attitude = rounded
            self.renew()
        elif rounded != self.attitude:
            self.attitude = rounded
            self.update(self._disc().toAlignedRect())

    def renew(self) -> None:
        """Repaint, including the drone."""
        self._drone = None
        super().renew()

    def paint_still(self, painter: QPainter) -> None:
        """Paint the sky, and the roll scale around it."""
        disc = self._disc()
        known = self.attitude is not None
        painter.setPen(Qt.PenStyle.NoPen if known else QPen(self.colour("line"), 1.5))
        painter.setBrush(self.colour("sky" if known else "field"))
        painter.drawEllipse(disc)
        radius = disc.width() / 2
        for mark in ROLL_MARKS:
            long = mark % 30 == 0
            painter.setPen(QPen(self.colour("ink" if long else "muted"), 2.0 if long else 1.2))
            angle = math.radians(mark)
            inner, outer = radius + 2.0, radius + (0.10 if long else 0.065) * radius
            x, y = math.sin(angle), -math.cos(angle)
            middle = disc.center()
            painter.drawLine(
                middle + QPointF(inner * x, inner * y), middle + QPointF(outer * x, outer * y)
            )

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint earth, ladder, pointer and drone."""
        disc = self._disc()
        radius = disc.width() / 2
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.attitude is None:
            return
        horizon = Horizon(self.attitude, radius, VIEW)
        painter.translate(disc.center())
        self._paint_earth(painter, horizon)
        self._paint_ladder(painter, horizon)
        self._paint_pointer(painter, horizon)
        if self._drone is None:
            self._drone = self._painted_drone(radius)
        side = self._drone.width() / self._drone.devicePixelRatio()
        painter.drawPixmap(QPointF(-side / 2, -side / 2), self._drone)

    def _disc(self) -> QRectF:
        """Return the window's bounding square."""
        side = min(self.width(), self.height())
        radius = (side / 2 - 2.0) / 1.1
        disc = QRectF(0.0, 0.0, 2 * radius, 2 * radius)
        disc.moveCenter(self.area.center())
        return disc

    def _paint_earth(self, painter: QPainter, horizon: Horizon) -> None:
        radius = horizon.radius
        window = QRectF(-radius, -radius, 2 * radius, 2 * radius)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour("earth"))
        # The earth is the part below the horizon; Qt measures angles counter-clockwise from the
        # right.
        half = math.degrees(math.acos(horizon.line / radius))
        down = math.degrees(horizon.attitude.bank) - 90.0
        start, span = down - 180.0 + half, 2.0 * (180.0 - half)
        painter.drawChord(window, round(16 * start), round(16 * span))
        aside = math.sqrt(radius**2 - horizon.line**2)
        painter.setPen(QPen(self._light, max(1.5, radius / 55)))
        painter.drawLine(
            QPointF(*horizon.place(horizon.line, -aside)),
            QPointF(*horizon.place(horizon.line, aside)),
        )

    def _paint_ladder(self, painter: QPainter, horizon: Horizon) -> None:
        radius = horizon.radius
        thin = QPen(self._light, max(1.0, radius / 80))
        painter.setPen(thin)
        painter.setFont(self.face(0.85))
        for degrees in horizon.ladder(LADDER_MINOR):
            height = horizon.height(math.radians(degrees))
            if degrees % 10:
                half = 0.10 * radius
            else:
                half = 0.26 * radius
                self._paint_degrees(painter, horizon, height, half, degrees)
            painter.drawLine(
                QPointF(*horizon.place(height, -half)), QPointF(*horizon.place(height, half))
            )

    def _paint_degrees(
        self, painter: QPainter, horizon: Horizon, height: float, half: float, degrees: int
    ) -> None:
        """Paint the number of a ladder line at its left, upright for legibility."""
        size = 1.3 * self.text_size
        place = QRectF(0.0, 0.0, 2.0 * size, size)
        place.moveCenter(QPointF(*horizon.place(height, -half - 0.85 * size)))
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, str(abs(degrees)))

    def _paint_pointer(self, painter: QPainter, horizon: Horizon) -> None:
        """Paint the triangle that points to the zenith."""
        radius = horizon.radius
        tip, base, half = 0.98 * radius, 0.86 * radius, 0.065 * radius
        corners = [horizon.place(tip), horizon.place(base, half), horizon.place(base, -half)]
        painter.setPen(QPen(self._dark, 1.0))
        painter.setBrush(self._light)
        painter.drawPolygon(QPolygonF([QPointF(*corner) for corner in corners]))

    def _painted_drone(self, radius: float) -> QPixmap:
        """Return the drone on a transparent background."""
        ratio = self.devicePixelRatioF()
        side = 2 * math.ceil(0.55 * radius + 3.0)
        drone = QPixmap(round(side * ratio), round(side * ratio))
        drone.setDevicePixelRatio(ratio)
        drone.fill(Qt.GlobalColor.transparent)
        painter = QPainter(drone)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(side / 2, side / 2)
        self._paint_drone(painter, radius)
        painter.end()
        return drone

    def _paint_drone(self, painter: QPainter, radius: float) -> None:
        """Paint the drone from behind: two arms and a body, light with a dark outline."""
        inner, outer, drop = 0.16 * radius, 0.48 * radius, 0.09 * radius
        arms = [
            QPolygonF(
                [
                    QPointF(side * outer, 0.0),
                    QPointF(side * inner, 0.0),
                    QPointF(side * inner, drop),
                ]
            )
            for side in (-1.0, 1.0)
        ]
        width = max(2.0, radius / 32)
        dot = max(2.0, radius / 32)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for pen in (QPen(self._dark, width + 2.5), QPen(self._light, width)):
            painter.setPen(pen)
            for arm in arms:
                painter.drawPolyline(arm)
            extra = (pen.widthF() - width) / 2
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(pen.color())
            painter.drawEllipse(QPointF(0.0, 0.0), dot + extra, dot + extra)
            painter.setBrush(Qt.BrushStyle.NoBrush)

    @property
    def _light(self) -> QColor:
        """Colour of lines on sky and earth, which are darker in both looks."""
        return self.colour("ink" if self.look.is_dark else "card")

    @property
    def _dark(self) -> QColor:
        """Colour of outlines that separate them from both."""
        return self.colour("ground" if self.look.is_dark else "ink")


class HeadingTape(Instrument):
    """Shows the heading, in degrees clockwise from north.

    Attributes:
        heading: the shown heading [degrees], NaN before the first.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Heading", parent)
        self.heading = math.nan
        self._tape: QPixmap | None = None
        self._cover = QPixmap()

    @property
    def spoken(self) -> str:
        """The heading as a sentence."""
        if math.isnan(self.heading):
            return "no heading yet"
        return f"heading {self.heading:.0f} degrees, {point_of(self.heading)}"

    def show_yaw(self, yaw: float) -> None:
        """Show the heading of a yaw [rad]; none if it is not finite."""
        known = math.isfinite(yaw)
        heading = TAPE_STEP * round(heading_of(yaw) / TAPE_STEP) % 360.0 if known else math.nan
        if heading != self.heading and (known or not math.isnan(self.heading)):
            self.heading = heading
            self.update()

    def renew(self) -> None:
        """Repaint, including the tape."""
        self._tape = None
        super().renew()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the visible part of the tape, and the pointer."""
        if math.isnan(self.heading):
            return
        if self._tape is None:
            self._tape, self._cover = self._painted_tape(), self._painted_cover()
        ratio = self._tape.devicePixelRatio()
        left = self.heading / 360.0 * self._turn * ratio
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        source = QRectF(left, 0.0, self.width() * ratio, self.height() * ratio)
        painter.drawPixmap(self.area, self._tape, source)
        painter.drawPixmap(QPointF(0.0, 0.0), self._cover)

    def _painted_cover(self) -> QPixmap:
        """Return the layer above the tape: fading ends, and the pointer."""
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
        """Length of a full turn [px]."""
        return self.width() * 360.0 / SEEN

    def _painted_tape(self) -> QPixmap:
        """Return a full turn of the tape, plus half of the visible part on either side."""
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
    """Return the heading of a yaw [rad] with leading zeros, as 007.5."""
    if not math.isfinite(yaw):
        return "–"
    return f"{round(heading_of(yaw), 1) % 360.0:05.1f}"


class AttitudeCard(Card):
    """The horizon ahead of the drone's nose.

    The angles are those of the workbench's frames: W is east-north-up and B forward-left-up, so a
    positive roll lowers the right side, a positive pitch the nose, and yaw is 0 to the east. The
    heading is that of a compass, clockwise from north.
    """

    name = "attitude"
    title = "Attitude"

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, units, parent)
        self.indicator = AttitudeIndicator(look, self)
        self.tape = HeadingTape(look, self)
        self.table = self.make_table("Angles", widest="\N{MINUS SIGN}888.8")
        self.parts = [self.indicator, self.tape, self.table]
        self.set_note("+ right side down, + nose down")

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return a line for each angle; a heading is always in degrees."""
        return *((label, units.angle.symbol) for label in LABELS[:3]), (LABELS[3], "°")

    def place_parts(self, body: QRectF) -> None:
        """Place the tape below dial and numbers."""
        size = self.text_size
        upper = body.adjusted(0.0, 0.0, 0.0, -2.9 * size)
        picture, numbers = beside(upper, 1.2 * size, 7.0 * size)
        put(self.indicator, picture)
        put(self.table, numbers)
        tape = QRectF(body)
        tape.setTop(body.bottom() - 2.6 * size)
        put(self.tape, tape)

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Update the horizon and the tape."""
        self.indicator.show_attitude(attitude_of(now.q_WB))
        self.tape.show_yaw(now.roll_pitch_yaw[2])

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the angles."""
        for index, angle in enumerate(now.roll_pitch_yaw):
            self.table.show_row(index, self.units.angle.text(angle))
        self.table.show_row(3, heading_text(now.roll_pitch_yaw[2]))
