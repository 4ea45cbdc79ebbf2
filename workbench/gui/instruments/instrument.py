"""The base class of instruments: a cached still part, fonts, colours and symbols; and a hint.

The hint replaces an instrument that has nothing to show.
"""

from abc import abstractmethod
from enum import Enum

from PyQt6.QtCore import QRectF, Qt
from PyQt6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPixmap, QResizeEvent
from PyQt6.QtWidgets import QWidget

from workbench.common.plain_text import plain_name, plain_text
from workbench.gui.icons import paint_picture
from workbench.gui.theme import Look


class Sign(Enum):
    """State symbol; the value is the name of its colour."""

    GOOD = "good"
    """A full circle."""
    WARNING = "warning"
    """A triangle with a stroke."""
    BAD = "bad"
    """A square with a cross."""
    OFF = "muted"
    """An empty circle."""

    def paint(self, painter: QPainter, place: QRectF, colour: QColor) -> None:
        """Paint it into a square area."""
        paint_picture(painter, place, f"sign_{self.name.lower()}", colour)


LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
"""Alignment of text at the sides of a line."""
TEXT_SIZE = 12.0
"""Default height of plain text [px]."""
_TABULAR = QFont.Tag("tnum")


class Instrument(QWidget):
    """A widget with a still part, painted once, and a moving part above it.

    It is opaque, so that nothing behind it is repainted with it.

    Args:
        look: source of colours.
        name: what it shows, for a screen reader.
        parent: the Qt parent.
    """

    ground = "card"
    """Name of its background colour in the look."""

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.look = look
        self.text_size = TEXT_SIZE
        self._still: QPixmap | None = None
        self._faces: dict[tuple[float, bool], QFont] = {}
        self._colours: dict[str, QColor] = {}
        self.setAccessibleName(name)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        look.changed.connect(self._recolour)

    @property
    def spoken(self) -> str:
        """The shown content as a sentence, for a screen reader."""
        return ""

    @property
    def area(self) -> QRectF:
        """Its full area."""
        return QRectF(self.rect())

    def set_text_size(self, size: float) -> None:
        """Set the height of plain text [px]; other sizes scale with it."""
        if size != self.text_size:
            self.text_size = size
            self._faces.clear()
            self.renew()

    def face(self, factor: float = 1.0, bold: bool = False) -> QFont:
        """Return the font of a size relative to plain text, with digits of equal width."""
        key = (factor, bold)
        if key not in self._faces:
            font = QFont(self.font())
            font.setPixelSize(max(7, round(factor * self.text_size)))
            font.setBold(bold)
            font.setFeature(_TABULAR, 1)
            self._faces[key] = font
        return self._faces[key]

    def colour(self, name: str) -> QColor:
        """Return a colour of the look."""
        if name not in self._colours:
            self._colours[name] = self.look.colour(name)
        return self._colours[name]

    def renew(self) -> None:
        """Repaint everything, including the still part."""
        self._still = None
        self.update()

    def paint_still(self, painter: QPainter) -> None:
        """Paint the part that seldom changes; the background is already filled."""

    @abstractmethod
    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the part that changes, where it overlaps a rectangle."""

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Copy the still part, and paint the moving part over it."""
        assert event is not None
        if self.width() < 2 or self.height() < 2:
            return
        painter = QPainter(self)
        rect = QRectF(event.rect())
        still = self._still_part()
        ratio = still.devicePixelRatio()
        source = QRectF(
            rect.x() * ratio, rect.y() * ratio, rect.width() * ratio, rect.height() * ratio
        )
        painter.drawPixmap(rect, still, source)
        self.paint_moving(painter, rect)
        painter.end()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Make the still part again."""
        self.renew()
        super().resizeEvent(event)

    def _recolour(self) -> None:
        """Apply the look's new colours."""
        self._colours.clear()
        self.renew()

    def _still_part(self) -> QPixmap:
        ratio = self.devicePixelRatioF()
        if self._still is None or self._still.devicePixelRatio() != ratio:
            self._still = QPixmap(round(self.width() * ratio), round(self.height() * ratio))
            self._still.setDevicePixelRatio(ratio)
            self._still.fill(self.colour(self.ground))
            painter = QPainter(self._still)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            self.paint_still(painter)
            painter.end()
        return self._still


class Hint(Instrument):
    """A word and a sentence in place of an instrument that has nothing to show."""

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(look, name, parent)
        self.word = ""
        self.sentence = ""

    def say(self, word: str, sentence: str) -> None:
        """Show a word with the symbol of off, and a remedy."""
        word, sentence = plain_name(word), plain_text(sentence)
        if (word, sentence) != (self.word, self.sentence):
            self.word, self.sentence = word, sentence
            self.renew()

    @property
    def spoken(self) -> str:
        """Both as a sentence."""
        return f"{self.word}. {self.sentence}"

    def paint_still(self, painter: QPainter) -> None:
        """Paint both in the centre."""
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
        Sign.OFF.paint(painter, sign, self.colour("muted"))
        painter.setPen(self.colour("muted"))
        line = QRectF(left + 1.3 * size, top, area.width(), 1.6 * size)
        painter.drawText(line, LEFT, self.word)
        painter.setFont(self.face())
        below = QRectF(area.left(), top + 1.9 * size, area.width(), area.bottom() - top)
        painter.drawText(below, wraps | Qt.AlignmentFlag.AlignTop, self.sentence)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Nothing moves."""
