"""Paints a picture as large as there is room for, and tells which pixel is under the mouse."""

from PyQt6.QtCore import QEvent, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QImage, QMouseEvent, QPainter, QPaintEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.theme import Look


class PictureView(QWidget):
    """Shows a picture.

    Args:
        look: colours.
        name: of the picture.
        parent: the Qt parent; this object is deleted with it.
    """

    pointed = pyqtSignal(object)
    """Column and row of the pixel under the mouse, None where there is none."""

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._image = QImage()
        self._hint = ""
        self.setMouseTracking(True)
        self.setMinimumSize(160, 120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(name)
        look.changed.connect(self.update)

    @property
    def image(self) -> QImage:
        """What is shown."""
        return self._image

    def show_image(self, image: QImage) -> None:
        """Show a picture."""
        self._image, self._hint = image, ""
        self.update()

    def show_hint(self, hint: str) -> None:
        """Say why there is no picture."""
        self._image, self._hint = QImage(), hint
        self.update()

    def box(self) -> QRectF:
        """Return where the picture is."""
        if self._image.isNull():
            return QRectF()
        scale = min(self.width() / self._image.width(), self.height() / self._image.height())
        width, height = scale * self._image.width(), scale * self._image.height()
        return QRectF(0.5 * (self.width() - width), 0.5 * (self.height() - height), width, height)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._look.colour("ground"))
        if self._image.isNull():
            painter.setPen(self._look.colour("muted"))
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(QRectF(self.rect()).adjusted(16, 8, -16, -8), int(flags), self._hint)
        else:
            painter.drawImage(self.box(), self._image)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Tell the pixel."""
        box = self.box()
        if event is None or not box.contains(event.position()):
            self.pointed.emit(None)
            return
        place = event.position() - box.topLeft()
        column = min(int(place.x() / box.width() * self._image.width()), self._image.width() - 1)
        row = min(int(place.y() / box.height() * self._image.height()), self._image.height() - 1)
        self.pointed.emit((column, row))

    def leaveEvent(self, event: QEvent | None) -> None:
        """The mouse is elsewhere."""
        self.pointed.emit(None)
