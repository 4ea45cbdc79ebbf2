"""How long the drone can fly on: the charge as a bar and in words."""

import math

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QBrush, QPainter, QPen
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.card import Card
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.sign import Sign
from workbench.gui.theme import Look
from workbench.live.announcer import LOW_CHARGE
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


def charge_word(charge: float, reserve: float) -> str:
    """Return in words how a charge 0 .. 1 is: empty, at the reserve, low, or good."""
    if math.isnan(charge):
        return "unknown"
    if charge <= 0.0:
        return "empty"
    if charge <= reserve:
        return "reserve: lands"
    return "low" if charge <= reserve + LOW_CHARGE else "good"


class ChargeBar(Instrument):
    """A bar with per cent, and a mark at the charge at which the drone lands by itself."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Battery", parent)
        self._charge, self._reserve = math.nan, 0.15

    @property
    def text(self) -> str:
        """Per cent, in words."""
        if math.isnan(self._charge):
            return "–"
        return f"{100 * self._charge:.0f}\N{NO-BREAK SPACE}%"

    @property
    def word(self) -> str:
        """How it is."""
        return charge_word(self._charge, self._reserve)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"{self.text}, {self.word}; reserve {100 * self._reserve:.0f} %"

    def show_charge(self, charge: float, reserve: float) -> None:
        """Show a charge and the reserve, 0 .. 1."""
        shown = charge if math.isnan(charge) else round(charge, 3)
        if (str(shown), reserve) != (str(self._charge), self._reserve):
            self._charge, self._reserve = shown, reserve
            self.update()

    def sizeHint(self) -> QSize:
        """Return a size at which all is readable."""
        return QSize(200, 30)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the bar, the reserve's mark, and per cent."""
        size = self.text_size
        name = {"good": "good", "low": "warning"}.get(self.word, "bad")
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        body = self._body()
        painter.setPen(QPen(self.colour("muted"), 1.2))
        painter.setBrush(self.colour("field"))
        painter.drawRoundedRect(body, 3.0, 3.0)
        inner = body.adjusted(2.0, 2.0, -2.0, -2.0)
        full = QRectF(inner)
        charge = 0.0 if math.isnan(self._charge) else max(0.0, min(1.0, self._charge))
        full.setWidth(charge * inner.width())
        painter.fillRect(full, self.colour(name))
        if name != "good":  # no colour alone
            painter.fillRect(full, QBrush(self.colour("card"), Qt.BrushStyle.BDiagPattern))
        x = inner.left() + self._reserve * inner.width()
        painter.setPen(QPen(self.colour("ink"), 2.0))
        painter.drawLine(QPointF(x, body.top() - 2.0), QPointF(x, body.bottom() + 2.0))
        painter.setFont(self.face(1.5, bold=True))
        painter.setPen(self.colour("ink"))
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(
            QRectF(self.width() - 5.2 * size, 0.0, 5.2 * size, self.height()), right, self.text
        )

    def _body(self) -> QRectF:
        size = self.text_size
        height = min(1.5 * size, self.height() - 5.0)
        return QRectF(
            1.0, (self.height() - height) / 2, max(10.0, self.width() - 6.0 * size), height
        )


class BatteryCard(Card):
    """The charge, and the reserve at which it lands by itself."""

    name = "battery"
    title = "Battery"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bar = ChargeBar(look, self)
        self.parts = [self.bar]

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the charge."""
        reserve = self._watch.value("battery_reserve")
        self.bar.show_charge(now.charge, reserve)
        word = self.bar.word
        signs = {"good": Sign.GOOD, "low": Sign.WARNING}
        self.set_note(
            f"{word}, reserve {100 * reserve:.0f}\N{NO-BREAK SPACE}%", signs.get(word, Sign.BAD)
        )
