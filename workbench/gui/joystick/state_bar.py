"""Says whether the sticks count and who flies, with the button that mends it."""

from PyQt6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from workbench.gui.joystick.gate import ON_THE_GROUND
from workbench.gui.joystick.pilot import Pilot
from workbench.gui.joystick.standing import (
    is_client,
    is_operator,
    say_bites,
    say_control,
    say_state,
)
from workbench.gui.style import dressed, set_class
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class StateBar(QFrame):
    """Two lines of words and three buttons, each shown where it helps.

    Args:
        pilot: whose sticks they are.
        workspace: what all screens share.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, pilot: Pilot, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._pilot, self._workspace = pilot, workspace
        self.setProperty("class", "card")
        self.state = dressed(QLabel(self), "value")
        self.state.setWordWrap(True)
        self.control = dressed(QLabel(self), "muted")
        self.control.setWordWrap(True)
        self.take_off = self._button("Take off", "take off", "primary")
        self.take_over = self._button(
            "Take over", "take control from the client that flies", "primary"
        )
        self.give_back = self._button("Give back", "let clients ask for control again", "")
        flight = workspace.flight
        self.take_off.clicked.connect(lambda: flight.order(lambda live: live.request("take_off")))
        self.take_over.clicked.connect(lambda: flight.order(lambda live: live.take_over()))
        self.give_back.clicked.connect(pilot.give_back)
        words = QVBoxLayout()
        words.setSpacing(2)
        words.addWidget(self.state)
        words.addWidget(self.control)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(16, 10, 16, 10)
        layout.setSpacing(8)
        layout.addLayout(words, 1)
        for button in (self.take_off, self.take_over, self.give_back):
            layout.addWidget(button)

    def show_view(self, view: LiveView) -> None:
        """Say how it is."""
        pilot, control = self._pilot, view.network.control
        state = say_state(view, pilot.barred, pilot.device)
        _show(self.state, state)
        bites = say_bites(pilot.limits.bites(pilot.wish), self._workspace.preferences)
        _show(self.control, bites or say_control(view))
        set_class(self.control, "warning" if bites else "muted")
        self.take_off.setVisible(pilot.barred == ON_THE_GROUND)
        self.take_over.setVisible(is_client(control))
        has_server = view.network.server is not None
        self.give_back.setVisible(has_server and is_operator(control))

    def _button(self, text: str, help: str, kind: str) -> QPushButton:
        button = QPushButton(text, self)
        button.setProperty("class", kind)
        button.setAccessibleName(f"{text}: {help}")
        button.hide()
        return button


def _show(label: QLabel, text: str) -> None:
    """Show a text, where it is another: a label that is set lays out its window again."""
    if label.text() != text:
        label.setText(text)
