"""The joystick screen: two sticks, what they ask for, and what the drone makes of it."""

from PyQt6.QtCore import QEvent, Qt
from PyQt6.QtGui import QHideEvent, QShowEvent
from PyQt6.QtWidgets import QFrame, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from workbench.gui.joystick.handling_panel import HandlingPanel
from workbench.gui.joystick.key_watcher import KeyWatcher
from workbench.gui.joystick.pilot import Pilot
from workbench.gui.joystick.response import answered
from workbench.gui.joystick.response_view import ResponseView
from workbench.gui.joystick.state_bar import StateBar
from workbench.gui.joystick.stick_pad import LEFT_STICK, RIGHT_STICK, StickPad
from workbench.gui.joystick.texts import KEYS_HELP, MODE_HELP, say_pad
from workbench.gui.page import fit_page
from workbench.gui.screen import Screen
from workbench.gui.style import dressed
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class JoystickScreen(Screen):
    """Fly by mouse, keyboard or game pad.

    Args:
        workspace: what all screens share.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        pilot: reads the sticks and flies.
        left_pad: climbs and turns.
        right_pad: flies level.
        response: what was asked and what is flown.
        handling: how strongly sticks are felt.
        state_bar: whether sticks count, and who flies.
    """

    title = "Joystick"
    icon = "joystick"

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        look, preferences = workspace.look, workspace.preferences
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.pilot = Pilot(workspace.flight, preferences, self)
        self.state_bar = StateBar(self.pilot, workspace, self)
        self.left_pad = StickPad(LEFT_STICK, look, self)
        self.right_pad = StickPad(RIGHT_STICK, look, self)
        self.response = ResponseView(look, preferences, self)
        self.handling = HandlingPanel(preferences, look, self)
        self._pad_line = dressed(QLabel("", self), "muted")
        self._pad_line.setWordWrap(True)
        self._keys = KeyWatcher(
            self, self._press, self._let_go_key, self.pilot.keyboard.release_all
        )
        self._lay_out()
        self.left_pad.dragged.connect(lambda stick: self.pilot.hold_stick("left", stick))
        self.right_pad.dragged.connect(lambda stick: self.pilot.hold_stick("right", stick))
        self.pilot.changed.connect(self._show_sticks)
        self._show_sticks()

    def begin(self, view: LiveView) -> None:
        """Take note that a flight has begun."""
        self.pilot.begin(view)
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show what was asked and what is flown, and who flies."""
        if view.snapshot is not None and self.workspace.flight.live is not None:
            self.response.show_rows(answered(view.snapshot, self.pilot.handling, self.pilot.limits))
        self.state_bar.show_view(view)

    def release(self) -> None:
        """Let go of both sticks, whatever holds them."""
        self.left_pad.let_go()
        self.right_pad.let_go()
        self.pilot.release()

    def close_screen(self) -> None:
        """Let go of the game pad."""
        self.release()
        self.pilot.close()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Go on duty."""
        super().showEvent(event)
        self.pilot.listen_to_pads(self.isActiveWindow())
        self.pilot.start()
        self._keys.start()
        self.setFocus(Qt.FocusReason.OtherFocusReason)
        self.show_view(self.workspace.flight.view)

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Go off duty."""
        super().hideEvent(event)
        self._keys.stop()
        self.release()
        self.pilot.stop()

    def event(self, event: QEvent | None) -> bool:
        """Let go when another window comes to the front."""
        if event is not None and event.type() is QEvent.Type.WindowDeactivate:
            self.pilot.listen_to_pads(False)
            self.release()
        elif event is not None and event.type() is QEvent.Type.WindowActivate:
            self.pilot.listen_to_pads(True)
        return super().event(event)

    def _press(self, key: object) -> None:
        self.pilot.keyboard.press(key)  # type: ignore[arg-type]
        self.pilot.look()

    def _let_go_key(self, key: object) -> None:
        self.pilot.keyboard.release(key)  # type: ignore[arg-type]
        self.pilot.look()

    def _show_sticks(self) -> None:
        """Show where the sticks are."""
        pilot = self.pilot
        counts = not pilot.barred
        self.left_pad.show_stick(pilot.sticks.left, counts)
        self.right_pad.show_stick(pilot.sticks.right, counts)
        for pad in (self.left_pad, self.right_pad):
            pad.show_dead_band(pilot.handling.curve.dead_band)
        self.handling.curve.show_curve(pilot.handling.curve)
        self.handling.curve.show_sticks(pilot.sticks)
        self._pad_line.setText(say_pad(pilot.pads.missing, pilot.pad_name))
        self.state_bar.show_view(self.workspace.flight.view)

    def _lay_out(self) -> None:
        sticks = QHBoxLayout()
        sticks.setSpacing(16)
        sticks.addWidget(self.left_pad, 1)
        sticks.addWidget(self.right_pad, 1)
        flying = dressed(QFrame(self), "card")
        column = QVBoxLayout(flying)
        column.setContentsMargins(16, 12, 16, 12)
        column.addLayout(sticks, 1)
        column.addWidget(dressed(QLabel(MODE_HELP, self), "muted"))
        answer = dressed(QFrame(self), "card")
        rows = QVBoxLayout(answer)
        rows.setContentsMargins(16, 12, 16, 12)
        rows.addWidget(dressed(QLabel("Command and answer", self), "heading"))
        rows.addWidget(self.response, 1)
        feel = dressed(QFrame(self), "card")
        form = QVBoxLayout(feel)
        form.setContentsMargins(16, 12, 16, 12)
        form.addWidget(self.handling, 1)
        grid = QGridLayout()
        grid.setContentsMargins(16, 12, 16, 12)
        grid.setSpacing(12)
        grid.addWidget(self.state_bar, 0, 0, 1, 2)
        grid.addWidget(flying, 1, 0)
        grid.addWidget(answer, 1, 1)
        grid.addWidget(feel, 2, 0, 1, 2)
        hints = QVBoxLayout()
        hints.setSpacing(2)
        hints.addWidget(dressed(QLabel(KEYS_HELP, self), "muted"))
        hints.addWidget(self._pad_line)
        grid.addLayout(hints, 3, 0, 1, 2)
        grid.setRowStretch(1, 1)
        grid.setColumnStretch(0, 3)
        grid.setColumnStretch(1, 2)
        fit_page(self, grid)
