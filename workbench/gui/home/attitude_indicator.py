"""The attitude indicator: bank and pitch as a window to the horizon."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPen
from PyQt6.QtWidgets import QWidget

from workbench.gui.instruments.instrument import DEFAULT_TEXT_HEIGHT_PX
from workbench.gui.poses import rotation_of
from workbench.gui.theme import Look

LADDER_STEP_DEG = 5
"""Spacing of the pitch ladder's lines, every other one short and without a number [degrees]."""
LADDER_REACH, HORIZON_RIM_SHARE = 0.62, 0.88
"""Largest distances of the ladder's lines and of the horizon from the centre, relative to the
rim's."""
HORIZON_VIEW_RAD = math.radians(32.0)
"""Angle from the centre to the rim [rad]."""
TILT_RESOLUTION_RAD = math.radians(0.05)
"""Smaller changes are not shown [rad]."""
ROLL_MARKS_DEG = (-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60)
"""Marks of the roll scale [degrees]."""


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


def attitude_of(q_WB: Sequence[float]) -> Attitude | None:
    """Return the attitude of an orientation, None if it is not finite.

    Args:
        q_WB: unit quaternion w, x, y, z of the body B in the world W, whose z is up.
    """
    if not all(map(math.isfinite, q_WB)):
        return None
    forward, left, up = rotation_of(q_WB)[2].tolist()  # world z in the body's axes
    return Attitude(math.asin(max(-1.0, min(1.0, forward))), math.atan2(left, up))


def ladder_degrees(nose_up: float) -> tuple[int, ...]:
    """Return the elevations of the ladder's lines that are well within the window [degrees].

    Args:
        nose_up: elevation of the forward axis [rad].
    """
    middle, reach = math.degrees(nose_up), LADDER_REACH * math.degrees(HORIZON_VIEW_RAD)
    first = math.ceil(max(-90.0, middle - reach) / LADDER_STEP_DEG)
    last = math.floor(min(90.0, middle + reach) / LADDER_STEP_DEG)
    return tuple(k * LADDER_STEP_DEG for k in range(first, last + 1) if k)


class AttitudeIndicator(QWidget):
    """Shows bank and pitch as a window to the horizon, in which the drone is fixed.

    The scale on the rim is fixed to the drone; the pointer points to the zenith.

    Attributes:
        attitude: the shown attitude, None before the first.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.setAccessibleName("Attitude indicator")
        self.look = look
        self.attitude: Attitude | None = None
        self._text_size = DEFAULT_TEXT_HEIGHT_PX
        look.changed.connect(self.update)

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
        rounded = attitude.rounded(TILT_RESOLUTION_RAD) if attitude is not None else None
        if rounded != self.attitude:
            self.attitude = rounded
            self.update()

    def set_text_size(self, size: float) -> None:
        """Set the height of its text [px]."""
        self._text_size = size
        self.update()

    def colour(self, name: str) -> QColor:
        """Return a colour of the look."""
        return self.look.colour(name)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the sky and the roll scale, and above them earth, ladder, pointer and drone."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(QRectF(self.rect()).center())
        radius = (min(self.width(), self.height()) / 2 - 2.0) / 1.1
        self._paint_sky(painter, radius)
        if self.attitude is None:
            return
        bank = math.degrees(self.attitude.bank)
        painter.rotate(-bank)  # with the right side down, the sky leans to the left
        self._paint_earth(painter, radius, self.attitude.nose_up)
        self._paint_ladder(painter, radius, self.attitude.nose_up)
        painter.setPen(QPen(self._dark, 1.0))
        painter.setBrush(self._light)
        tip, base, half = -0.98 * radius, -0.86 * radius, 0.065 * radius
        painter.drawPolygon(QPointF(0.0, tip), QPointF(half, base), QPointF(-half, base))
        painter.rotate(bank)
        self._paint_drone(painter, radius)

    def _paint_sky(self, painter: QPainter, radius: float) -> None:
        """Paint the sky, and the roll scale around it."""
        known = self.attitude is not None
        painter.setPen(Qt.PenStyle.NoPen if known else QPen(self.colour("line"), 1.5))
        painter.setBrush(self.colour("sky" if known else "field"))
        painter.drawEllipse(QPointF(), radius, radius)
        for mark in ROLL_MARKS_DEG:
            long = mark % 30 == 0
            painter.setPen(QPen(self.colour("ink" if long else "muted"), 2.0 if long else 1.2))
            outer = radius * (1.10 if long else 1.065)
            painter.rotate(mark)
            painter.drawLine(QPointF(0.0, -radius - 2.0), QPointF(0.0, -outer))
            painter.rotate(-mark)

    def _paint_earth(self, painter: QPainter, radius: float, nose_up: float) -> None:
        """Paint the part below the horizon; a rim of sky or earth is always visible."""
        high = -nose_up / HORIZON_VIEW_RAD * radius
        high = max(-HORIZON_RIM_SHARE * radius, min(HORIZON_RIM_SHARE * radius, high))
        half = math.degrees(math.acos(high / radius))  # from the zenith to an end of the horizon
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour("earth"))
        disc = QRectF(-radius, -radius, 2 * radius, 2 * radius)
        painter.drawChord(disc, round(16 * (90.0 + half)), round(16 * (360.0 - 2.0 * half)))
        aside = math.sqrt(radius**2 - high**2)
        painter.setPen(QPen(self._light, max(1.5, radius / 55)))
        painter.drawLine(QPointF(-aside, -high), QPointF(aside, -high))

    def _paint_ladder(self, painter: QPainter, radius: float, nose_up: float) -> None:
        """Paint lines of equal pitch, every other one long and with its number at its left."""
        painter.setPen(QPen(self._light, max(1.0, radius / 80)))
        font = QFont(self.font())
        font.setPixelSize(round(self._text_size))
        painter.setFont(font)
        size = 1.3 * self._text_size
        for degrees in ladder_degrees(nose_up):
            y = (nose_up - math.radians(degrees)) / HORIZON_VIEW_RAD * radius
            half = (0.10 if degrees % 10 else 0.26) * radius
            painter.drawLine(QPointF(-half, y), QPointF(half, y))
            if degrees % 10 == 0:
                place = QRectF(-half - 1.85 * size, y - size / 2, 2.0 * size, size)
                painter.drawText(place, Qt.AlignmentFlag.AlignCenter, str(abs(degrees)))

    def _paint_drone(self, painter: QPainter, radius: float) -> None:
        """Paint the drone from behind: two arms and a body, light with a dark outline."""
        inner, outer, drop = 0.16 * radius, 0.48 * radius, 0.09 * radius
        width = max(2.0, radius / 32)
        for pen in (QPen(self._dark, width + 2.5), QPen(self._light, width)):
            for side in (-1.0, 1.0):
                painter.setPen(pen)
                elbow = QPointF(side * inner, 0.0)
                painter.drawPolyline(QPointF(side * outer, 0.0), elbow, QPointF(side * inner, drop))
            dot = width + (pen.widthF() - width) / 2
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(pen.color())
            painter.drawEllipse(QPointF(), dot, dot)

    @property
    def _light(self) -> QColor:
        """Colour of lines on sky and earth, which are darker in both looks."""
        return self.colour("ink" if self.look.is_dark else "card")

    @property
    def _dark(self) -> QColor:
        """Colour of outlines that separate them from both."""
        return self.colour("ground" if self.look.is_dark else "ink")
