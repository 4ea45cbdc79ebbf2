"""A stick on the screen: dragged by the mouse, it stays in its circle and springs back."""

from dataclasses import dataclass

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QPixmap
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.joystick.piloting import MIDDLE, Stick, within_circle
from workbench.gui.theme import Look

KNOB = 0.2
"""Radius of the knob in radii of the circle."""
LARGEST = 480
"""Width and height [px]."""


@dataclass(frozen=True)
class Words:
    """What a stick does in each direction, and the key that does the same.

    Attributes:
        name: of the stick.
        up: what away from the pilot does; so the next three.
        down: towards.
        left: to the left.
        right: to the right.
        keys: of up, down, left and right.
    """

    name: str
    up: str
    down: str
    left: str
    right: str
    keys: tuple[str, str, str, str]


LEFT_STICK = Words("Left stick", "climb", "sink", "turn left", "turn right", ("W", "S", "A", "D"))
RIGHT_STICK = Words("Right stick", "forward", "back", "left", "right", ("↑", "↓", "←", "→"))


class StickPad(QWidget):
    """Shows a stick, and lets the mouse hold it.

    Args:
        words: what it does.
        look: colours.
        parent: the Qt parent; this object is deleted with it.
    """

    dragged = pyqtSignal(object)
    """The `Stick` where the mouse holds it, None when it lets go."""

    def __init__(self, words: Words, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._words, self._look = words, look
        self._stick, self._counts, self._dead_band = MIDDLE, True, 0.0
        self._held = False
        self._ground = QPixmap()
        self.setAccessibleName(
            f"{words.name}: up {words.up}, down {words.down}, left {words.left}, "
            f"right {words.right}; keys {' '.join(words.keys)}; minus 1 to 1"
        )
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(170, 170)
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        look.changed.connect(self._repaint)

    def sizeHint(self) -> QSize:
        """Return what suits a thumb."""
        return QSize(240, 240)

    @property
    def stick(self) -> Stick:
        """Where it is shown."""
        return self._stick

    def show_stick(self, stick: Stick, counts: bool) -> None:
        """Show where the stick is, and whether that has an effect."""
        if (stick, counts) != (self._stick, self._counts):
            before = self._knob()
            self._stick, self._counts = stick, counts
            self.update(before.united(self._knob()).toAlignedRect().adjusted(-4, -4, 4, 4))

    def show_dead_band(self, dead_band: float) -> None:
        """Show around the middle what asks for nothing."""
        if dead_band != self._dead_band:
            self._dead_band = dead_band
            self._repaint()

    def place(self, stick: Stick) -> QPointF:
        """Return where the knob's middle is for a stick."""
        way = self._radius * (1.0 - KNOB)
        return self._middle + QPointF(stick.x * way, -stick.y * way)

    def let_go(self) -> None:
        """Spring back, whatever the mouse does."""
        if self._held:
            self._held = False
            self.setCursor(Qt.CursorShape.OpenHandCursor)
            self.dragged.emit(None)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Take hold of the stick."""
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            super().mousePressEvent(event)
            return
        self._held = True
        self.setCursor(Qt.CursorShape.ClosedHandCursor)
        self._drag(event.position())

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Move the stick."""
        if event is not None and self._held:
            self._drag(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Let go of the stick."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self.let_go()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint circle and knob."""
        ratio = self.devicePixelRatioF()
        if self._ground.size() != (self.size().toSizeF() * ratio).toSize():
            self._paint_ground(ratio)
        look, middle, knob = self._look, self._middle, self._knob()
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._ground)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colour = look.colour("accent" if self._counts else "muted")
        if not self._stick.is_neutral:
            painter.setPen(QPen(colour, 3.0))
            painter.drawLine(middle, knob.center())
        painter.setPen(QPen(look.colour("card"), 2.0))
        painter.setBrush(colour)
        painter.drawEllipse(knob)
        if not self._counts:  # a bar across: not by its colour alone
            painter.setPen(QPen(look.colour("card"), 3.0))
            way = QPointF(0.55 * knob.width() / 2, 0.0)
            painter.drawLine(knob.center() - way, knob.center() + way)

    @property
    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    @property
    def _radius(self) -> float:
        return min(self.width(), self.height(), LARGEST) / 2 - 3.0

    def _knob(self) -> QRectF:
        radius = self._radius * KNOB
        place = self.place(self._stick)
        return QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius)

    def _drag(self, to: QPointF) -> None:
        way = self._radius * (1.0 - KNOB)
        off = to - self._middle
        self.dragged.emit(within_circle(off.x() / way, -off.y() / way))

    def _repaint(self) -> None:
        self._ground = QPixmap()
        self.update()

    def _paint_ground(self, ratio: float) -> None:
        """Paint what does not move: circle, cross, dead band and words."""
        self._ground = QPixmap((self.size().toSizeF() * ratio).toSize())
        self._ground.setDevicePixelRatio(ratio)
        self._ground.fill(Qt.GlobalColor.transparent)
        look, middle, radius = self._look, self._middle, self._radius
        painter = QPainter(self._ground)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(self.font())
        painter.setPen(QPen(look.colour("line"), 2.0))
        painter.setBrush(look.colour("ground"))
        painter.drawEllipse(middle, radius, radius)
        way = radius * (1.0 - KNOB)
        painter.setPen(QPen(look.colour("line"), 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(middle, way / 2, way / 2)
        painter.drawLine(middle - QPointF(way / 2, 0), middle + QPointF(way / 2, 0))
        painter.drawLine(middle - QPointF(0, way / 2), middle + QPointF(0, way / 2))
        dead = self._dead_band * way
        painter.setBrush(look.colour("line"))
        painter.drawRect(QRectF(middle.x() - dead, middle.y() - dead, 2 * dead, 2 * dead))
        self._paint_words(painter)
        painter.end()

    def _paint_words(self, painter: QPainter) -> None:
        """Paint what each direction does, and its key, along the rim."""
        words, middle, radius = self._words, self._middle, self._radius
        line = painter.fontMetrics().lineSpacing()
        painter.setPen(self._look.colour("muted"))
        box = QRectF(
            middle.x() - radius + 8, middle.y() - radius + 8, 2 * radius - 16, 2 * radius - 16
        )
        flags, whole = Qt.AlignmentFlag, Qt.TextFlag.TextDontClip.value
        up, down, left, right = words.keys
        painter.drawText(box, flags.AlignHCenter | flags.AlignTop, f"{up}\n{words.up}")
        painter.drawText(box, flags.AlignHCenter | flags.AlignBottom, f"{words.down}\n{down}")
        for text, key, side in (
            (words.left, left, flags.AlignLeft),
            (words.right, right, flags.AlignRight),
        ):
            lines = [key, *text.split()]
            area = QRectF(
                box.left(), middle.y() - line * len(lines) / 2, box.width(), line * len(lines)
            )
            painter.drawText(area, (side | flags.AlignVCenter).value | whole, "\n".join(lines))
