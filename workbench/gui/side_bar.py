"""The side bar: a button for each screen."""

from collections.abc import Mapping

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QFrame, QSizePolicy, QToolButton, QVBoxLayout, QWidget

from workbench.gui.icons import icon
from workbench.gui.screen_table import SCREENS
from workbench.gui.theme import Look

ICON = 26
"""Edge of a picture [pixels of the layout]."""


class SideBar(QFrame):
    """Buttons one below the other; that of the present screen has a bar beside it.

    Args:
        actions: those that show screens, by name.
        look: colours.
        parent: in which it stands.
    """

    def __init__(
        self, actions: Mapping[str, QAction], look: Look, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setObjectName("side_bar")
        self.setAccessibleName("Screens")
        self._look = look
        self._actions = {row.name: actions[f"show_{row.name}"] for row in SCREENS}
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 6, 0, 6)
        layout.setSpacing(2)
        for number, row in enumerate(SCREENS, start=1):
            button = QToolButton(self)
            button.setDefaultAction(self._actions[row.name])
            button.setProperty("class", "side")
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            button.setIconSize(QSize(ICON, ICON))
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setAccessibleName(f"{row.title} screen, Ctrl+{number}")
            layout.addWidget(button)
        layout.addStretch(1)
        look.changed.connect(self.paint_icons)
        self.paint_icons()

    def mark(self, name: str) -> None:
        """Show which screen is seen."""
        for each, action in self._actions.items():
            action.setChecked(each == name)
        self.paint_icons()

    def paint_icons(self) -> None:
        """Draw the pictures in the present colours, that of the present screen in the accent."""
        for row in SCREENS:
            action = self._actions[row.name]
            colour = "accent" if action.isChecked() else "muted"
            action.setIcon(icon(row.icon, self._look.colour(colour)))
