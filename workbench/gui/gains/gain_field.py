"""The number of one gain, to be typed."""

import math

from PyQt6.QtCore import QEvent, QLocale, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QKeySequence, QWheelEvent
from PyQt6.QtWidgets import QAbstractSpinBox, QDoubleSpinBox, QWidget

from workbench.gui.gains.gain_step import StepSize, key_step, moves, size_of

WIDEST = 1e12
"""Whatever is typed is taken, so that a sentence can say what is wrong with it."""
CLOSE = 1e-4
"""A text that is as near as this stands for the exact value."""
DIGITS = 5
"""Significant ones of a value that the usual decimals do not show."""


class GainField(QDoubleSpinBox):
    """A number as it is shown, with its unit; the model says what it is.

    Args:
        parent: whose life it shares.
    """

    typed = pyqtSignal(float)
    """What the user has typed, once it is complete."""
    stepped = pyqtSignal(int, object)
    """Direction, -1 or 1, and a `StepSize`."""
    grasped = pyqtSignal()
    """Steps that follow, until `released`, are one movement."""
    released = pyqtSignal()
    """It is over."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown_decimals = 2
        self._exact = 0.0
        self.setLocale(QLocale.c())
        self.setRange(-WIDEST, WIDEST)
        self.setDecimals(9)
        self.setKeyboardTracking(False)
        self.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.setProperty("class", "bare")
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.valueChanged.connect(self._tell)

    def show_decimals(self, decimals: int) -> None:
        """Show so many decimals."""
        self._shown_decimals = decimals

    def show_value(self, value: float) -> None:
        """Show a value; nobody is told."""
        self._exact = value
        blocked = self.blockSignals(True)
        if self.value() == value:
            self.setValue(value + 1.0)  # so that a text that was not taken goes, too
        self.setValue(value)
        self.blockSignals(blocked)

    def textFromValue(self, value: float) -> str:
        text = f"{value:.{self._shown_decimals}f}"
        if not math.isclose(float(text), value, rel_tol=CLOSE, abs_tol=1e-12):
            text = f"{value:.{DIGITS}g}"
        return "0" + text[2:] if text.startswith("-0") and float(text) == 0.0 else text

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
            self.grasped.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        super().keyReleaseEvent(event)
        if event is not None and not event.isAutoRepeat() and moves(event.key()):
            self.released.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        if event is None:
            return
        turned = event.angleDelta().y() or event.angleDelta().x()
        if not self.hasFocus() or not turned:
            event.ignore()
            return
        self.stepped.emit(1 if turned > 0 else -1, size_of(event.modifiers()))
        event.accept()

    def _tell(self, value: float) -> None:
        """Tell what was typed; a text that stands for the exact value is that value."""
        same = self.textFromValue(value) == self.textFromValue(self._exact)
        self.typed.emit(self._exact if same else value)

    def stepBy(self, steps: int) -> None:
        self.stepped.emit(1 if steps > 0 else -1, StepSize.FINE)


def _redoes(event: QKeyEvent) -> bool:
    return event.matches(QKeySequence.StandardKey.Redo)
