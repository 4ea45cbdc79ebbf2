"""The dialog that asks for the arguments of a model's file."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QLineEdit, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.labels import set_tip
from workbench.gui.layout import label, scroll_area, vbox
from workbench.gui.notices import Notices
from workbench.live.choice import Choice, with_arguments
from workbench.plant.formats.xacro import XacroArgument
from workbench.scenario.scenario import Scenario

VALUE_NEEDED_TEXT = "needs a value"


class ArgumentsDialog(QDialog):
    """A line for each argument; the flight, and the key that stops it, keep working meanwhile.

    Args:
        file: name of the file that needs them.
        arguments: its arguments; those without a default need a value.
        given: called with the values that differ from the defaults, by name.
        parent: the Qt parent.

    Attributes:
        lines: lines by the argument's name.
        buttons: its buttons; Open is disabled until nothing is missing.
    """

    def __init__(
        self,
        file: str,
        arguments: Sequence[XacroArgument],
        given: Callable[[Mapping[str, str]], None],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        file = plain_name(file)
        self.setWindowTitle(f"Arguments of {file}")
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._arguments, self._given = tuple(arguments), given
        self.lines: dict[str, QLineEdit] = {}
        said = label(
            f"{file} takes arguments. Give a value to each that is marked with ✱.", wraps=True
        )
        form = QWidget()
        self._form = QFormLayout(form)
        for each in self._arguments:
            self._add(each)
        box = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(box.Open | box.Cancel)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        vbox(said, (scroll_area(form), 1), self.buttons, of=self)
        self.resize(460, min(520, 160 + 36 * len(self._arguments)))
        self._look()

    def accept(self) -> None:
        """Pass the values on, and close."""
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
        line.setPlaceholderText(VALUE_NEEDED_TEXT if needed else "")
        line.setAccessibleName(f"{argument.name}, {VALUE_NEEDED_TEXT}" if needed else argument.name)
        line.textChanged.connect(self._look)
        self.lines[argument.name] = line
        shown = plain_name(argument.name)
        name = label(f"{shown} ✱") if needed else label(shown, "muted")
        self._form.addRow(name, line)

    def _look(self) -> None:
        """Enable Open when every argument that needs a value has one."""
        missing = [
            each.name
            for each in self._arguments
            if each.default is None and not self.lines[each.name].text().strip()
        ]
        button = self.buttons.button(QDialogButtonBox.StandardButton.Open)
        assert button is not None
        button.setEnabled(not missing)
        set_tip(button, f"These need a value: {', '.join(missing)}" if missing else "")


def ask_for_arguments(
    what: Choice | Scenario,
    needed: Sequence[XacroArgument],
    fly: Callable[[Choice | Scenario], None],
    notices: Notices,
    parent: QWidget,
) -> None:
    """Ask for missing arguments of a drone's file; the present flight continues.

    Args:
        what: the flight that was wanted.
        needed: arguments of the drone's file.
        fly: starts the flight, once they are given.
        notices: takes the notice that they were not.
        parent: the Qt parent.
    """
    model = what.model if isinstance(what, Choice) else what.vehicle.model
    name = Path(model).name or "The drone's description"
    dialog = ArgumentsDialog(name, needed, lambda values: fly(with_arguments(what, values)), parent)
    names = ", ".join(each.name for each in needed if each.default is None)
    dialog.rejected.connect(
        lambda: notices.warn(
            f"{name} was not opened: it needs values for {names}.",
            "Open it again to give them, or open another.",
        )
    )
    dialog.show()
