"""The number of one gain, to be typed."""

from PyQt6.QtCore import QEvent, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QKeySequence, QWheelEvent
from PyQt6.QtWidgets import QAbstractSpinBox, QWidget

from workbench.gui.gains.gain_scale import StepSize, key_step, moves, size_of
from workbench.gui.number_field import NumberField
from workbench.gui.units import Unit

WIDEST = 1e12
"""Any number is taken, so that the table of parameters can say what is wrong with it."""


class GainField(NumberField):
    """A number as it is shown, with its unit; the model says what it is.

    Args:
        parent: owner.
    """

    stepped = pyqtSignal(int, object)
    """Direction, -1 or 1, and a `StepSize`."""
    edit_begun = pyqtSignal()
    """Steps that follow, until `edit_ended`, are one change."""
    edit_ended = pyqtSignal()
    """It is over."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent=parent)
        self.set_range(Unit(""), -WIDEST, WIDEST)
        self.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.setProperty("class", "bare")
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def show_value(self, value: float) -> None:
        """Show a value; nobody is told, and a text that was not taken goes."""
        self.restore()
        self.show_si(value)
        self.restore()

    def tell(self, said: str) -> None:
        """Leave the sentence to the line that the field stands in."""

    def event(self, event: QEvent | None) -> bool:
        # The editor's own undo would swallow the key of the gains' undo.
        if (
            isinstance(event, QKeyEvent)
            and event.type() == QEvent.Type.ShortcutOverride
            and (event.matches(QKeySequence.StandardKey.Undo) or _redoes(event))
        ):
            event.ignore()
            return False
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is None:
            return
        step = key_step(event.key(), event.modifiers())
        if step is None or event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            super().keyPressEvent(event)
            if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Escape):
                event.ignore()  # the form has a use for them, too
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        super().keyReleaseEvent(event)
        if event is not None and not event.isAutoRepeat() and moves(event.key()):
            self.edit_ended.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        if event is None:
            return
        turned = event.angleDelta().y() or event.angleDelta().x()
        if not self.hasFocus() or not turned:
            event.ignore()
            return
        self.stepped.emit(1 if turned > 0 else -1, size_of(event.modifiers()))
        event.accept()

    def stepBy(self, steps: int) -> None:
        self.stepped.emit(1 if steps > 0 else -1, StepSize.FINE)


def _redoes(event: QKeyEvent) -> bool:
    return event.matches(QKeySequence.StandardKey.Redo)
