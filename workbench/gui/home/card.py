"""A card of the Home screen: a frame with a title, and instruments in it."""

from PyQt6.QtCore import QRectF, Qt
from PyQt6.QtGui import QPainter, QPen, QResizeEvent
from PyQt6.QtWidgets import QWidget

from workbench.gui.card_help import explain
from workbench.gui.home.sensor_state import Health, SensorState
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.sign import Sign, paint_sign
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

WIDE = 1.2
"""From this ratio of width to height on, they stand beside each other."""
PICTURE = 0.6
"""Most of the width that the picture takes then."""

PADDING = 0.8
"""Inside the frame, relative to plain text."""
TITLE = 1.75
"""Height of the title's line, relative to plain text."""
SIGNS = {
    Health.ABSENT: Sign.OFF,
    Health.OFF: Sign.OFF,
    Health.WAITING: Sign.OFF,
    Health.GOOD: Sign.GOOD,
    Health.OLD: Sign.WARNING,
    Health.FAULTY: Sign.BAD,
}


def beside(
    body: QRectF, gap: float, numbers_height: float, share: float = PICTURE
) -> tuple[QRectF, QRectF]:
    """Return where a card's picture and its numbers stand: side by side, or one above the other.

    Args:
        body: of the card.
        gap: between the two [px].
        numbers_height: that the numbers need where they stand below [px].
        share: most of the width that the picture takes where it stands on the left.
    """
    if body.width() >= WIDE * body.height():
        width = min(body.height(), share * body.width())
        picture = QRectF(body.left(), body.top(), width, body.height())
        numbers = QRectF(body)
        numbers.setLeft(picture.right() + gap)
        return picture, numbers
    picture, numbers = QRectF(body), QRectF(body)
    picture.setBottom(body.bottom() - numbers_height - gap)
    numbers.setTop(body.bottom() - numbers_height)
    return picture, numbers


class Card(Instrument):
    """What belongs together.

    Attributes:
        name: in the plans of the Home screen.
        title: at its top.
        parts: instruments inside.
    """

    ground = "ground"
    name = ""
    title = ""

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, self.title, parent)
        explain(self, self.title)
        self.units = units
        self.parts: list[Instrument] = []
        self._note = ""
        self._sign: Sign | None = None

    @property
    def note(self) -> str:
        """What stands beside the title."""
        return self._note

    @property
    def sign(self) -> Sign | None:
        """The shape before the note, if any."""
        return self._sign

    @property
    def body(self) -> QRectF:
        """The room under the title."""
        pad, size = PADDING * self.text_size, self.text_size
        return self.area.adjusted(pad, 0.5 * pad + TITLE * size, -pad, -0.8 * pad)

    @property
    def spoken(self) -> str:
        """All of it as a sentence, for a screen reader."""
        return "; ".join(part.spoken for part in self.parts if part.isVisibleTo(self))

    def begin(self, view: LiveView) -> None:
        """A flight begins."""

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Show what moves smoothly; called for every view."""

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show what is to be read; called ten times a second."""

    def use_units(self, units: ShownUnits) -> None:
        """Show numbers in other units from now on."""
        self.units = units

    def place_parts(self, body: QRectF) -> None:
        """Place the parts; by default each of them fills the card."""
        for part in self.parts:
            put(part, body)

    def set_note(self, note: str, sign: Sign | None = None) -> None:
        """Show a note beside the title, with a shape where it says how something is."""
        if (note, sign) != (self._note, self._sign):
            self._note, self._sign = note, sign
            self.update(self._title_line.toAlignedRect())

    def set_state(self, state: SensorState) -> None:
        """Show how a sensor does beside the title."""
        self.set_note(state.note, SIGNS[state.health])

    def set_text_size(self, size: float) -> None:
        """Set it for the parts, too."""
        super().set_text_size(size)
        for part in self.parts:
            part.set_text_size(size)
        self.place_parts(self.body)

    def paint_still(self, painter: QPainter) -> None:
        """Paint frame and title."""
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("card"))
        corner = 0.5 * self.text_size
        painter.drawRoundedRect(self.area.adjusted(0.5, 0.5, -0.5, -0.5), corner, corner)
        painter.setFont(self.face(1.0, bold=True))
        painter.setPen(self.colour("muted"))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(self._title_line, left, self.title)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the note."""
        line = self._title_line
        if not self._note or not line.intersects(rect):
            return
        painter.setFont(self.face())
        calm = self._sign in (None, Sign.GOOD, Sign.OFF)
        colour = "muted" if calm or self._sign is None else self._sign.value
        painter.setPen(self.colour(colour))
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(line, right, self._note)
        if self._sign is not None:
            side = 0.85 * self.text_size
            width = painter.fontMetrics().horizontalAdvance(self._note)
            place = QRectF(line.right() - width - 1.4 * side, 0.0, side, side)
            place.moveTop(line.center().y() - side / 2)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            paint_sign(
                painter, place, self._sign, self.colour(self._sign.value), self.colour("card")
            )

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Place the parts again."""
        super().resizeEvent(event)
        self.place_parts(self.body)

    @property
    def _title_line(self) -> QRectF:
        pad = PADDING * self.text_size
        return QRectF(pad, 0.5 * pad, self.width() - 2 * pad, TITLE * self.text_size)


def put(part: QWidget, place: QRectF) -> None:
    """Give a widget its place, in whole pixels."""
    part.setGeometry(place.toRect())
