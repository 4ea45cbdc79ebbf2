"""Buttons for the actions that the remedy of a notice names."""

from collections.abc import Mapping

from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QPushButton, QWidget

from workbench.gui.layout import NO_MARGINS, button, hbox

REMEDY_ACTIONS = (
    ("reset", "reset"),
    ("open a scenario", "open_scenario"),
    ("hide the 3-d view", "view_3d"),
    ("land (", "land"),
    ("in settings", "show_settings"),
)
"""Words of a remedy, and the action that carries it out."""
_REMEDY_LABELS = {"view_3d": "Hide 3-D view"}
"""Labels of actions that a remedy only switches off; others have the action's own."""


class RemedyButtons(QWidget):
    """A button for each action that a remedy names.

    Args:
        actions: actions that a remedy may name.

    Attributes:
        buttons: the present buttons.
    """

    def __init__(self, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self._actions = actions
        self.buttons: tuple[QPushButton, ...] = ()
        self._box = hbox(of=self, margins=NO_MARGINS, spacing=6)

    def show_remedy(self, remedy: str) -> None:
        """Make a button for each action that the remedy names."""
        words = remedy.lower()
        names = [name for said, name in REMEDY_ACTIONS if said in words and self._helps(name)]
        if names == [each.objectName() for each in self.buttons]:
            return
        for each in self.buttons:
            self._box.removeWidget(each)
            each.hide()
            each.deleteLater()
        self.buttons = tuple(map(self._make, names))

    def _helps(self, name: str) -> bool:
        """Whether an action can carry a remedy out: what is switched off cannot be hidden."""
        action = self._actions.get(name)
        return action is not None and (not action.isCheckable() or action.isChecked())

    def _make(self, name: str) -> QPushButton:
        action = self._actions[name]
        label = _REMEDY_LABELS.get(name, action.iconText())
        made = button(label, action.trigger, help=action.toolTip())
        made.setObjectName(name)
        if action.isCheckable():
            action.toggled.connect(made.setVisible)
        self._box.addWidget(made)
        return made
