"""The mouse wheel: it scrolls the page, and zooms or steps only while Ctrl is held."""

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtWidgets import QComboBox

WHEEL_NOTCH = 120.0
"""What Qt reports for one notch [1/8 degree]."""


def zoom_notches(event: QWheelEvent | None) -> float:
    """Return by how many notches the wheel zooms in, and accept the event; 0 without Ctrl.

    An event that does not zoom is ignored, so that the page around the widget scrolls.
    """
    if event is None:
        return 0.0
    turned = event.angleDelta().y() or event.angleDelta().x()
    if not turned or not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
        event.ignore()
        return 0.0
    event.accept()
    return turned / WHEEL_NOTCH


class ComboBox(QComboBox):
    """A box whose choice the wheel does not change: the page scrolls."""

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Let the page scroll."""
        if event is not None:
            event.ignore()
