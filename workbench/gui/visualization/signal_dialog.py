"""The dialog for a signal that is derived by an expression."""

import re
from collections.abc import Callable

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QLayout, QLineEdit, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.labels import Label
from workbench.gui.layout import buddy
from workbench.gui.style import set_class
from workbench.gui.visualization.derived_signals import OWN_TOPIC, DerivedSignal
from workbench.logs.expressions import EXPRESSION_FUNCTIONS

SIGNAL_DIALOG_WIDTH_PX = 520
"""Width of the texts in a dialog [pixels]."""


class SignalDialog(QDialog):
    """Asks for a signal derived by an expression, and shows errors while it is typed.

    Args:
        signal: signal to change; empty for a new one.
        check: raises a WorkbenchError if a signal is invalid.
        parent: the Qt parent.
    """

    given = pyqtSignal(object)
    """The requested `DerivedSignal`."""

    def __init__(
        self,
        signal: DerivedSignal,
        check: Callable[[DerivedSignal], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Derived signal")
        self._check = check
        self.name = QLineEdit(signal.name.partition(".")[2])
        self.name.setPlaceholderText("ground_speed")
        self.expression = QLineEdit(signal.expression)
        self.expression.setPlaceholderText("sqrt(v_x**2 + v_y**2)")
        self.unit = QLineEdit(signal.unit if signal.name else "")
        self.unit.setPlaceholderText("m/s")
        self.said = Label()
        self.said.setWordWrap(True)
        form = QFormLayout(self)
        form.setSizeConstraint(QLayout.SizeConstraint.SetFixedSize)  # as high as the message
        for label, field in (
            ("&Name", self.name),
            ("&Expression", self.expression),
            ("&Unit, in SI", self.unit),
        ):
            field.textChanged.connect(self._look)
            form.addRow(buddy(label, field, kind=""), field)
        known = ", ".join(
            f"{name} ({each.help})" if each.help.count(" ") > 2 else name
            for name, each in EXPRESSION_FUNCTIONS.items()
        )
        help = Label(f"Signals by their names, + - * / // % **, comparisons, pi, {known}.")
        help.setWordWrap(True)
        help.setFixedWidth(SIGNAL_DIALOG_WIDTH_PX)
        self.said.setFixedWidth(SIGNAL_DIALOG_WIDTH_PX)
        set_class(help, "muted")
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        for widget in (self.said, help, self.buttons):
            form.addRow(widget)
        self.accepted.connect(lambda: self.given.emit(self.signal))
        self.finished.connect(self.deleteLater)
        self._look()

    @property
    def signal(self) -> DerivedSignal:
        """The requested signal."""
        name = f"{OWN_TOPIC}.{self.name.text().strip()}"
        return DerivedSignal(name, self.unit.text().strip() or "1", self.expression.text().strip())

    def _look(self) -> None:
        """Show errors."""
        why = ""
        if not re.fullmatch(r"[A-Za-z_]\w*", self.name.text().strip()):
            why = "Give it a name of letters, digits and _."
        else:
            try:
                self._check(self.signal)
            except WorkbenchError as error:
                why = str(error)
        self.said.setText(why)
        button = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        if button is not None:
            button.setEnabled(not why)
