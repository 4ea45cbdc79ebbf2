"""The number field of the app, and parsing of typed numbers.

It holds a number in SI and shows it in a unit. A point or a comma separates the decimals.
"""

import math
import re

from PyQt6.QtCore import QLocale, QPoint, QSignalBlocker, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QValidator, QWheelEvent
from PyQt6.QtWidgets import QDoubleSpinBox, QToolTip, QWidget

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError
from workbench.common.quantity import DisplayUnit
from workbench.gui.labels import set_tip, tip_text
from workbench.gui.style import set_class
from workbench.gui.units import TEXT_VALUE_TOLERANCE, entered_number_text
from workbench.gui.wheel import zoom_notches

_PLAIN_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)


def read_number(text: str) -> float:
    """Return the number that a text contains, independent of the locale.

    Both a point and a comma separate decimals: 0,5 means a half. So neither can separate thousands,
    and a text with two of them is refused.

    Raises:
        WorkbenchError: if it is not a number, or is too large for a float.
    """
    typed = text.strip()
    if not typed:
        raise WorkbenchError("The field is empty: type a number, as 1.2 or 1e-3.")
    plain = typed.replace("\N{MINUS SIGN}", "-")
    said = f"'{typed[:MAX_ECHO_CHARS]}'"
    if plain.count(".") + plain.count(",") > 1:
        raise WorkbenchError(
            f"{said} has more than one point or comma: separate the decimals by one of them, "
            "and leave out separators of thousands, as in 1000.5."
        )
    plain = plain.replace(",", ".")
    if not _PLAIN_NUMBER.fullmatch(plain):
        raise WorkbenchError(f"{said} is not a number: write it as 1.2, 1,2 or 1e-3.")
    number = float(plain)
    if math.isinf(number):
        raise WorkbenchError(f"{said} is too large.")
    return number


def read_whole_number(text: str) -> int:
    """Return the whole number that a text contains.

    Raises:
        WorkbenchError: if it is not a number, or not a whole one.
    """
    number = read_number(text)
    if not number.is_integer():
        raise WorkbenchError(f"'{text.strip()[:MAX_ECHO_CHARS]}' is not a whole number.")
    return int(number)


SPIN_BOX_DECIMALS = 12
"""Number of decimals that the spin box keeps; fewer are shown."""
REFUSED_FIELD_CLASS = "bad"
"""Class of a field with a refused text."""


class NumberField(QDoubleSpinBox):
    """A number that is typed or stepped; every number field of the app uses it.

    Qt's own spin box drops invalid characters while typing, so that 1,2 becomes 12. Here every
    character stays. Text that is not a number, or out of range, stays as typed, is marked, and is
    explained by a message; the value does not change. Escape restores the value.

    Args:
        label: name of the number, for accessibility.
        decimals: number of shown decimals.
        step: step of an arrow, in the shown unit.
        parent: the Qt parent; this object is deleted with it.
        whole: whether it is a whole number.

    Attributes:
        fault: why the text is refused, as a sentence; "" if it is not.
    """

    edited = pyqtSignal(float)
    """The new value in SI; the user has changed it."""
    refused = pyqtSignal(str)
    """Why the typed text is refused, as a sentence; "" once the text changes."""

    def __init__(
        self,
        label: str = "",
        decimals: int = 2,
        step: float = 1.0,
        parent: QWidget | None = None,
        *,
        whole: bool = False,
    ) -> None:
        super().__init__(parent)
        self._label = label
        self._unit = DisplayUnit("")
        self._si = 0.0
        self._least = 0.0
        self._whole = whole
        self._shown_decimals = decimals
        self.fault, self._tip, self._description = "", "", ""
        self._refused_text: str | None = None
        self._is_edited = False  # Qt's own flag is cleared before Enter reads the text
        self.setLocale(QLocale.c())
        self.setDecimals(SPIN_BOX_DECIMALS)
        self.setSingleStep(step)
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.valueChanged.connect(self._tell)
        line = self.lineEdit()
        assert line is not None
        line.textEdited.connect(self._look)
        self.editingFinished.connect(self._finish)

    @property
    def si(self) -> float:
        """The value in SI."""
        same = round(self._unit.shown(self._si), SPIN_BOX_DECIMALS) == self.value()
        return self._si if same else self._unit.read(self.value())

    @property
    def is_typed_in(self) -> bool:
        """Whether the user is typing another value."""
        line = self.lineEdit()
        return self.hasFocus() and line is not None and line.isModified()

    def set_range(
        self, unit: DisplayUnit, minimum: float, maximum: float, least: float = 0.0
    ) -> None:
        """Show the value in a unit, within limits in SI; emits no signal.

        Args:
            unit: the shown unit.
            minimum: smallest value, in SI.
            maximum: largest value, in SI.
            least: least magnitude, in SI.
        """
        kept = self.si
        self._unit, self._least = unit, least
        low, high = unit.shown(minimum), unit.shown(maximum)
        with QSignalBlocker(self):
            self.setRange(low, high)
            self.setSuffix(unit.suffix)
            self.setValue(unit.shown(kept))
        self._finish()
        name = f"{self._label}, {self._limits()}"
        if name != self.accessibleName():
            self.setAccessibleName(name)
            set_tip(self, name)

    def show_decimals(self, decimals: int) -> None:
        """Set the number of shown decimals."""
        self._shown_decimals = decimals

    def show_si(self, value: float) -> None:
        """Show a value without a signal; a refused text stays until the value changes."""
        shown = self._unit.shown(value)
        if self.fault and round(shown, SPIN_BOX_DECIMALS) == self.value():
            return
        self._si = value
        self._accept()
        with QSignalBlocker(self):
            self.setValue(shown)
        self._finish()

    def setToolTip(self, text: str | None) -> None:
        """Set the tooltip, which is shown while the text is valid."""
        self._tip = text or ""
        if not self.fault:
            super().setToolTip(text)

    def restore(self) -> None:
        """Replace the typed text by the value."""
        self._accept()
        self._finish()
        line = self.lineEdit()
        assert line is not None
        line.setText(f"{self.textFromValue(self.value())}{self.suffix()}")

    def textFromValue(self, value: float) -> str:
        if self._refused_text is not None:
            return self._refused_text
        return self.number_text(value)

    def number_text(self, value: float) -> str:
        """Return a number as shown, without its unit."""
        return entered_number_text(self._unit.read(value), self._unit, self._shown_decimals)

    def validate(self, text: str | None, place: int) -> tuple[QValidator.State, str, int]:
        fault = self._fault_of(text or "")
        state = QValidator.State.Intermediate if fault else QValidator.State.Acceptable
        return state, text or "", place

    def valueFromText(self, text: str | None) -> float:
        if not self._is_edited:
            return self.value()  # showing a value must not lose its other decimals
        return read_number(self._without_unit(text or ""))

    def fixup(self, text: str | None) -> str:
        """Refuse the text when it is entered or the field loses the focus; Qt's name."""
        self._refuse(text or "")
        return text or ""

    def stepBy(self, steps: int) -> None:
        self._accept()
        aim = self.value() + steps * self.singleStep()
        if abs(aim) < self._unit.shown(self._least) - TEXT_VALUE_TOLERANCE:
            steps += 1 if steps > 0 else -1  # skips values too near to 0
        super().stepBy(steps)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is not None and event.key() == Qt.Key.Key_Escape:
            line = self.lineEdit()
            if self.fault or (line is not None and line.isModified()):
                self.restore()
                event.accept()
                return
        super().keyPressEvent(event)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Step by Ctrl and the wheel if the field has the focus; otherwise the page scrolls."""
        if event is not None and not self.hasFocus():
            event.ignore()
        elif notches := zoom_notches(event):
            self.stepBy(1 if notches > 0.0 else -1)

    def tell(self, said: str) -> None:
        """Show why the typed text is refused; "" for no reason."""
        super().setToolTip(tip_text(said) or self._tip)
        if said and self.isVisible():
            place = self.mapToGlobal(QPoint(0, self.height()))
            QToolTip.showText(place, tip_text(said), self)
        elif not said:
            QToolTip.hideText()

    def _tell(self, value: float) -> None:
        self._accept()
        self._finish()
        self._si = self.si
        self.edited.emit(self._si)

    def _finish(self) -> None:
        """Note that the text is that of the value, unless it is refused."""
        self._is_edited = bool(self.fault)

    def _look(self, text: str) -> None:
        """Remove the mark as soon as the text is valid."""
        self._refused_text = None
        if self.fault and not self._fault_of(text):
            self._accept()
        self._is_edited = True

    def _refuse(self, text: str) -> None:
        self._refused_text = self._without_unit(text)
        fault = self._fault_of(text)
        if fault == self.fault:
            return
        if not self.fault:
            self._description = self.accessibleDescription()
        self.fault = fault
        self.setAccessibleDescription(fault)
        self._mark()
        self.tell(fault)
        self.refused.emit(fault)

    def _accept(self) -> None:
        self._refused_text = None
        if self.fault:
            self.fault = ""
            self.setAccessibleDescription(self._description)
            self._mark()
            self.tell("")
            self.refused.emit("")

    def _mark(self) -> None:
        names = [
            name
            for name in str(self.property("class") or "").split()
            if name != REFUSED_FIELD_CLASS
        ]
        set_class(self, " ".join([*names, REFUSED_FIELD_CLASS] if self.fault else names))

    def _fault_of(self, text: str) -> str:
        """Return what is wrong with a text, as a sentence; "" if it is valid."""
        plain = self._without_unit(text)
        try:
            number = float(read_whole_number(plain)) if self._whole else read_number(plain)
        except WorkbenchError as error:
            return str(error)
        if plain == self.number_text(self.value()):
            return ""  # a limit that its decimals do not show exactly
        near = self._unit.shown(self._least)
        if not self.minimum() <= number <= self.maximum() or abs(number) < near:
            return f"{plain}{self.suffix()} is out of range: keep it within {self._limits()}."
        return ""

    def _limits(self) -> str:
        low, high = self.minimum(), self.maximum()
        limits = f"{low:.6g} to {high:.6g}{self.suffix()}"
        near = self._unit.shown(self._least)
        return f"{limits}, and {near:.3g}{self.suffix()} or more from 0" if near else limits

    def _without_unit(self, text: str) -> str:
        plain, symbol = text.strip(), self.suffix().strip()
        while symbol and plain.endswith(symbol):  # Qt adds another if a part is deleted
            plain = plain.removesuffix(symbol).strip()
        return plain
