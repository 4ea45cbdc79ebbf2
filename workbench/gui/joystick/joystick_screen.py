"""The joystick screen: two sticks, what they ask for, and what the drone makes of it."""

from PyQt6.QtCore import QEvent, Qt
from PyQt6.QtGui import QHideEvent, QShowEvent
from PyQt6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from workbench.control.mode import FlightMode
from workbench.gui.joystick.game_pad import PadButton
from workbench.gui.joystick.handling_panel import HandlingPanel
from workbench.gui.joystick.keyboard_sticks import KeyWatcher
from workbench.gui.joystick.pilot import ON_THE_GROUND, Device, Pilot
from workbench.gui.joystick.piloting import Bite
from workbench.gui.joystick.response_view import ResponseView, answered
from workbench.gui.joystick.stick_pad import LEFT_STICK, RIGHT_STICK, StickPad
from workbench.gui.page import fit_page
from workbench.gui.preferences import Preferences
from workbench.gui.screen import Screen
from workbench.gui.style import dressed, set_class
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.link.server_messages import ControlState, Hand
from workbench.live.view import LiveView

READY = "Ready: move a stick to fly, let go to stop and hold."
TAKING_OFF = "Taking off: the sticks count once it hovers."

MODE_HELP = "Forward is where the nose points."
KEYS_HELP = "Keys: W A S D and the arrows, held down; not while a field or a slider has the focus."
NO_PAD = "Game pad: none is plugged in; it is found as soon as it is."


def say_state(view: LiveView, barred: str, device: Device) -> str:
    """Return whether the sticks count, as a sentence."""
    if barred:
        return barred
    if view.snapshot is not None and view.snapshot.mode is FlightMode.TAKING_OFF:
        return TAKING_OFF
    return READY if device is Device.NONE else f"You fly, by {device.value}."


def say_control(view: LiveView) -> str:
    """Return who flies, as a sentence."""
    control = view.network.control
    if is_client(control):
        assert control is not None
        name = control.name or f"Client {control.peer}"
        return f"{name} flies over the network. A stick that you move takes over."
    if view.network.server is None:
        return "No server runs, so nobody else can fly."
    if control is not None and control.hand is Hand.OPERATOR:
        return "You have control. Clients wait until you give it back."
    return "Nobody has control. A stick that you move takes it."


def say_bites(bites: tuple[Bite, ...], preferences: Preferences) -> str:
    """Return which limits of the flight hold a wish back, "" where none does."""
    said = []
    for bite in bites:
        unit = unit_for(bite.unit, preferences)
        said.append(
            f"{bite.what} is held to {unit.text(bite.limit, 1)} by {bite.parameter}, not "
            f"{unit.text(bite.asked, 1)}"
        )
    return "Limit: " + "; ".join(said) + "." if said else ""


def is_client(control: ControlState | None) -> bool:
    """Return whether a client flies."""
    return control is not None and control.hand is Hand.CLIENT


def is_operator(control: ControlState | None) -> bool:
    """Return whether the operator has taken control, so that clients wait."""
    return control is not None and control.hand is Hand.OPERATOR


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


def say_pad(missing: str, name: str) -> str:
    """Return a line on the game pad.

    Args:
        missing: why there can be none, "" else.
        name: of the pad, "" without one.
    """
    if missing:
        return missing
    if not name:
        return NO_PAD
    buttons = ", ".join(f"{each.place}: {each.words}" for each in PadButton)
    return f"Game pad: {name}. {buttons}."


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
