"""Says why there is nothing to see, and what to do about it."""

from PyQt6.QtCore import QRectF, Qt
from PyQt6.QtGui import QPainter
from PyQt6.QtWidgets import QWidget

from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.sign import Sign, paint_sign
from workbench.gui.theme import Look


class Hint(Instrument):
    """A word and a sentence in the place of an instrument that has nothing to show."""

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(look, name, parent)
        self.word = ""
        self.sentence = ""

    def say(self, word: str, sentence: str) -> None:
        """Show a word, as off, and what can be done."""
        if (word, sentence) != (self.word, self.sentence):
            self.word, self.sentence = word, sentence
            self.renew()

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"{self.word}. {self.sentence}"

    def paint_still(self, painter: QPainter) -> None:
        """Paint both in the middle."""
        size = self.text_size
        area = self.area.adjusted(size / 2, 0.0, -size / 2, 0.0)
        wraps = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignHCenter
        painter.setFont(self.face())
        sentence = painter.boundingRect(area, int(wraps | Qt.AlignmentFlag.AlignTop), self.sentence)
        top = area.top() + max(0.0, (area.height() - sentence.height() - 1.9 * size) / 2)
        painter.setFont(self.face(1.15, bold=True))
        metrics = painter.fontMetrics()
        width = 1.3 * size + metrics.horizontalAdvance(self.word)
        left = area.center().x() - width / 2
        sign = QRectF(left, top + 0.32 * size, 0.95 * size, 0.95 * size)
        paint_sign(painter, sign, Sign.OFF, self.colour("muted"), self.colour("card"))
        painter.setPen(self.colour("muted"))
        line = QRectF(left + 1.3 * size, top, area.width(), 1.6 * size)
        painter.drawText(
            line, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.word
        )
        painter.setFont(self.face())
        below = QRectF(area.left(), top + 1.9 * size, area.width(), area.bottom() - top)
        painter.drawText(below, wraps | Qt.AlignmentFlag.AlignTop, self.sentence)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Nothing moves."""
