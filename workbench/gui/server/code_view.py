"""An address as a QR code on the screen, for a phone to read."""

from PyQt6.QtCore import QRect, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPixmap
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.link.qr import png_code


class CodeView(QWidget):
    """Shows a QR code, black on white in every theme, in whole pixels a module."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._text = ""
        self._code = QPixmap()
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """Return a size that a phone reads from an arm's length."""
        return QSize(132, 132)

    def show_text(self, text: str) -> None:
        """Show a text as a code; nothing for ""."""
        if text != self._text:
            self._text = text
            self._code = QPixmap()
            if text:
                self._code.loadFromData(png_code(text, scale=1))
            self.setAccessibleName(f"QR code of {text}" if text else "")
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the code as large as whole pixels allow, in the middle."""
        if self._code.isNull():
            return
        ratio = self.devicePixelRatioF()
        room = round(min(self.width(), self.height()) * ratio)
        side = max(1, room // self._code.width()) * self._code.width() / ratio
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, on=False)
        left, top = (self.width() - side) / 2, (self.height() - side) / 2
        area = QRect(round(left), round(top), round(side), round(side))
        painter.fillRect(area, Qt.GlobalColor.white)
        painter.drawPixmap(area, self._code)
