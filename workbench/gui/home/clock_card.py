"""Wall time, simulated time, and how the flight keeps up."""

import math
import time

from PyQt6.QtCore import QRectF, Qt
from PyQt6.QtGui import QPainter, QPen

from workbench.gui.home.card import PADDING, Card
from workbench.gui.instruments.sign import Sign, paint_sign
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


def simulated_text(seconds: float, decimals: int) -> str:
    """Return a simulated time [s] as minutes and seconds, and hours from one on: 1:02.5."""
    if not math.isfinite(seconds):
        return "–"
    ticks = round(seconds * 10**decimals)
    whole, part = divmod(ticks, 10**decimals)
    minutes, seconds_left = divmod(whole, 60)
    text = f"{seconds_left:02d}.{part:0{decimals}d}"
    return f"{minutes // 60}:{minutes % 60:02d}:{text}" if minutes >= 60 else f"{minutes}:{text}"


class ClockCard(Card):
    """The large clock; its upper line has the times, the lower one says what they are."""

    name = "clock"
    title = "Clock"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.wall = ""
        self.simulated = "–"
        self.state, self.state_sign = "nothing flies yet", Sign.OFF

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"local time {self.wall}, simulated time {self.simulated}, {self.state}"

    def show_wall(self) -> None:
        """Show the present time of day."""
        wall = time.strftime("%H:%M:%S")
        if wall != self.wall:
            self.wall = wall
            self.update(self._left_half.toAlignedRect())

    def show_silence(self, seconds: float) -> None:
        """Show that nothing was heard of the flight for a time [s]."""
        self._show_state(f"no news for {seconds:.0f} s", Sign.WARNING)

    def show_phase(self, view: LiveView) -> None:
        """Show where the flight is."""
        match view.phase:
            case Phase.STARTING:
                self._show_state(view.said or "starting", Sign.OFF)
            case Phase.PAUSED:
                self._show_state("paused", Sign.WARNING)
            case Phase.BROKEN:
                self._show_state("broken: last values", Sign.BAD)
            case Phase.ENDED:
                self._show_state("ended: last values", Sign.BAD)
            case Phase.FLYING if view.pace is None:
                self._show_state("flying", Sign.GOOD)
            case Phase.FLYING if view.pace.too_slow:
                self._show_state(f"too slow: {view.pace.text}", Sign.WARNING)
            case Phase.FLYING:
                self._show_state(f"{view.pace.text} real time", Sign.GOOD)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the simulated time; to the millisecond where it stands."""
        self.show_phase(view)
        text = simulated_text(now.time, 1 if view.phase is Phase.FLYING else 3)
        if text != self.simulated:
            self.simulated = text
            self.update(self._upper(self._right_half).toAlignedRect())

    def paint_still(self, painter: QPainter) -> None:
        """Paint the frame, and what is what."""
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("card"))
        corner = 0.5 * self.text_size
        painter.drawRoundedRect(self.area.adjusted(0.5, 0.5, -0.5, -0.5), corner, corner)
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        painter.drawText(self._lower(self._left_half), _LEFT, "Local time")

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint both times, and how the flight does."""
        if self._left_half.intersects(rect):
            painter.setFont(self.face(2.45, bold=True))
            painter.setPen(self.colour("ink"))
            painter.drawText(self._upper(self._left_half), _LEFT, self.wall)
        upper, lower = self._upper(self._right_half), self._lower(self._right_half)
        if upper.intersects(rect):
            painter.setFont(self.face(1.65))
            painter.setPen(self.colour("ink"))
            painter.drawText(upper, _LEFT, self.simulated)
            used = painter.fontMetrics().horizontalAdvance(self.simulated)
            painter.setFont(self.face())
            painter.setPen(self.colour("muted"))
            label = upper.adjusted(used + 0.6 * self.text_size, 0.25 * self.text_size, 0.0, 0.0)
            painter.drawText(label, _LEFT, "simulated")
        if lower.intersects(rect):
            self._paint_state(painter, lower)

    def _paint_state(self, painter: QPainter, line: QRectF) -> None:
        side = 0.85 * self.text_size
        painter.setFont(self.face())
        sign = QRectF(line.left(), line.center().y() - side / 2, side, side)
        colour = self.state_sign.value
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        paint_sign(painter, sign, self.state_sign, self.colour(colour), self.colour("card"))
        calm = self.state_sign in (Sign.GOOD, Sign.OFF)
        painter.setPen(self.colour("muted" if calm else colour))
        text = painter.fontMetrics().elidedText(
            self.state, Qt.TextElideMode.ElideRight, int(line.width() - 1.5 * side)
        )
        painter.drawText(line.adjusted(1.5 * side, 0.0, 0.0, 0.0), _LEFT, text)

    def _show_state(self, state: str, sign: Sign) -> None:
        if (state, sign) != (self.state, self.state_sign):
            self.state, self.state_sign = state, sign
            self.update(self._lower(self._right_half).toAlignedRect())

    @property
    def _inside(self) -> QRectF:
        pad = 1.1 * PADDING * self.text_size
        high = min(self.height() - pad, 5.0 * self.text_size)
        inside = QRectF(pad, 0.0, self.width() - 2 * pad, high)
        inside.moveTop((self.height() - high) / 2)
        return inside

    @property
    def _left_half(self) -> QRectF:
        half = self._inside
        half.setWidth(0.5 * half.width())
        return half

    @property
    def _right_half(self) -> QRectF:
        half = self._inside
        half.setLeft(half.left() + 0.5 * half.width())
        return half

    def _upper(self, half: QRectF) -> QRectF:
        return half.adjusted(0.0, 0.0, 0.0, -0.36 * half.height())

    def _lower(self, half: QRectF) -> QRectF:
        return half.adjusted(0.0, 0.66 * half.height(), 0.0, 0.0)
