"""Asks for the arguments of a xacro file that cannot be read without them."""

from collections.abc import Callable, Mapping, Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QLabel,
    QLineEdit,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.style import dressed
from workbench.plant.formats.xacro_arguments import XacroArgument

NEEDED = "needs a value"


class ArgumentsDialog(QDialog):
    """A line for each argument; the flight, and the key that stops it, go on behind it.

    Args:
        file: what it is for, as a name.
        arguments: that it takes; those without a default need a value.
        given: hears the values of those that are not as by default, by name.
        parent: above which it opens.

    Attributes:
        lines: by the argument's name.
        buttons: of which Open waits until nothing is missing.
    """

    def __init__(
        self,
        file: str,
        arguments: Sequence[XacroArgument],
        given: Callable[[Mapping[str, str]], None],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Arguments of {file}")
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._arguments, self._given = tuple(arguments), given
        self.lines: dict[str, QLineEdit] = {}
        said = QLabel(f"{file} takes arguments. Give a value to each that is marked with ✱.")
        said.setWordWrap(True)
        form = QWidget()
        self._form = QFormLayout(form)
        for each in self._arguments:
            self._add(each)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidget(form)
        box = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(box.Open | box.Cancel)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(said)
        layout.addWidget(area, 1)
        layout.addWidget(self.buttons)
        self.resize(460, min(520, 160 + 36 * len(self._arguments)))
        self._look()

    def accept(self) -> None:
        """Give the values, and close."""
        self._given(
            {
                each.name: self.lines[each.name].text().strip()
                for each in self._arguments
                if self.lines[each.name].text().strip() != each.default
            }
        )
        super().accept()

    def _add(self, argument: XacroArgument) -> None:
        line = QLineEdit(argument.default or "")
        needed = argument.default is None
        line.setPlaceholderText(NEEDED if needed else "")
        line.setAccessibleName(f"{argument.name}, {NEEDED}" if needed else argument.name)
        line.textChanged.connect(self._look)
        self.lines[argument.name] = line
        label = QLabel(f"{argument.name} ✱" if needed else argument.name)
        self._form.addRow(label if needed else dressed(label, "muted"), line)

    def _look(self) -> None:
        """Let it be opened once every argument that needs a value has one."""
        missing = [
            each.name
            for each in self._arguments
            if each.default is None and not self.lines[each.name].text().strip()
        ]
        button = self.buttons.button(QDialogButtonBox.StandardButton.Open)
        assert button is not None
        button.setEnabled(not missing)
        button.setToolTip(f"These need a value: {', '.join(missing)}" if missing else "")
