"""A stick on the screen, which the mouse moves, with labels of its directions."""

from collections.abc import Sequence

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.joystick.piloting import StickPosition, within_circle
from workbench.gui.theme import Look

KNOB_SHARE = 0.2
"""Radius of the knob, as a share of the circle's."""
MAX_STICK_PAD_PX = 480
"""Largest width and height [px]."""


class StickPad(QWidget):
    """Shows a stick, and lets the mouse move it.

    Args:
        name: name of the stick.
        effects: effects of its directions: up, away from the pilot; down, left, right.
        look: source of colours.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        stick: the shown position.
    """

    dragged = pyqtSignal(object)
    """The `StickPosition` while the mouse holds it, None on release."""

    def __init__(
        self, name: str, effects: Sequence[str], look: Look, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._name, self._effects, self._look = name, tuple(effects), look
        look.changed.connect(self.update)
        self.stick: StickPosition = (0.0, 0.0)
        self._keys: tuple[str, ...] = ("",) * 4
        self._counts, self._dead_band = True, 0.0
        self._held = False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(170, 170)
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def sizeHint(self) -> QSize:
        """Return a size that suits a thumb."""
        return QSize(240, 240)

    def show_stick(self, stick: StickPosition, counts: bool) -> None:
        """Show the stick's position, and whether it has an effect."""
        if (stick, counts) != (self.stick, self._counts):
            self.stick, self._counts = stick, counts
            self.update()

    def show_keys(self, keys: Sequence[str]) -> None:
        """Show the keys for up, down, left and right."""
        self._keys = tuple(keys)
        up, down, left, right = self._effects
        self.setAccessibleName(
            f"{self._name}: up {up}, down {down}, left {left}, right {right}; "
            f"keys {' '.join(keys)}; minus 1 to 1"
        )
        self.update()

    def show_dead_band(self, dead_band: float) -> None:
        """Show the dead band around the centre."""
        if dead_band != self._dead_band:
            self._dead_band = dead_band
            self.update()

    def place(self, stick: StickPosition) -> QPointF:
        """Return the position of the knob's centre for a stick."""
        way = self._radius * (1.0 - KNOB_SHARE)
        return self._middle + QPointF(stick[0] * way, -stick[1] * way)

    def let_go(self) -> None:
        """Return to the centre, whatever the mouse does."""
        if self._held:
            self._held = False
            self.setCursor(Qt.CursorShape.OpenHandCursor)
            self.dragged.emit(None)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Grab the stick."""
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
        """Release the stick."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self.let_go()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint circle, cross, dead band and words, and above them the knob."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_ground(painter)
        middle, knob = self._middle, self._knob()
        colour = self._look.colour("accent" if self._counts else "muted")
        if any(self.stick):
            painter.setPen(QPen(colour, 3.0))
            painter.drawLine(middle, knob.center())
        painter.setPen(QPen(self._look.colour("card"), 2.0))
        painter.setBrush(colour)
        painter.drawEllipse(knob)
        if not self._counts:  # a bar across: not by colour alone
            painter.setPen(QPen(self._look.colour("card"), 3.0))
            way = QPointF(0.55 * knob.width() / 2, 0.0)
            painter.drawLine(knob.center() - way, knob.center() + way)

    @property
    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    @property
    def _radius(self) -> float:
        return min(self.width(), self.height(), MAX_STICK_PAD_PX) / 2 - 3.0

    def _knob(self) -> QRectF:
        radius = self._radius * KNOB_SHARE
        place = self.place(self.stick)
        return QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius)

    def _drag(self, to: QPointF) -> None:
        way = self._radius * (1.0 - KNOB_SHARE)
        off = to - self._middle
        self.dragged.emit(within_circle(off.x() / way, -off.y() / way))

    def _paint_ground(self, painter: QPainter) -> None:
        middle, radius = self._middle, self._radius
        painter.setPen(QPen(self._look.colour("line"), 2.0))
        painter.setBrush(self._look.colour("ground"))
        painter.drawEllipse(middle, radius, radius)
        way = radius * (1.0 - KNOB_SHARE)
        painter.setPen(QPen(self._look.colour("line"), 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(middle, way / 2, way / 2)
        painter.drawLine(middle - QPointF(way / 2, 0), middle + QPointF(way / 2, 0))
        painter.drawLine(middle - QPointF(0, way / 2), middle + QPointF(0, way / 2))
        dead = self._dead_band * way
        painter.setBrush(self._look.colour("line"))
        painter.drawRect(QRectF(middle.x() - dead, middle.y() - dead, 2 * dead, 2 * dead))
        self._paint_words(painter)

    def _paint_words(self, painter: QPainter) -> None:
        """Paint the effect of each direction, and its key, along the rim."""
        middle, radius = self._middle, self._radius
        line = painter.fontMetrics().lineSpacing()
        painter.setPen(self._look.colour("muted"))
        box = QRectF(
            middle.x() - radius + 8, middle.y() - radius + 8, 2 * radius - 16, 2 * radius - 16
        )
        flags, whole = Qt.AlignmentFlag, Qt.TextFlag.TextDontClip.value
        up, down, left, right = zip(self._effects, self._keys, strict=True)
        painter.drawText(box, flags.AlignHCenter | flags.AlignTop, f"{up[1]}\n{up[0]}")
        painter.drawText(box, flags.AlignHCenter | flags.AlignBottom, "\n".join(down))
        for (text, key), side in ((left, flags.AlignLeft), (right, flags.AlignRight)):
            lines = [key, *text.split()]
            area = QRectF(
                box.left(), middle.y() - line * len(lines) / 2, box.width(), line * len(lines)
            )
            painter.drawText(area, (side | flags.AlignVCenter).value | whole, "\n".join(lines))
