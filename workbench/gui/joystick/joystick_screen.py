"""The joystick screen: two sticks, their command, and the drone's response."""

from collections.abc import Iterable

from PyQt6.QtCore import QEvent, Qt
from PyQt6.QtGui import QHideEvent, QShowEvent

from workbench.gui.help import help_card
from workbench.gui.joystick.game_pad import PadButton
from workbench.gui.joystick.handling_panel import HandlingPanel
from workbench.gui.joystick.keyboard_sticks import KEY_DIRECTIONS
from workbench.gui.joystick.pad_dialog import PadDialog
from workbench.gui.joystick.pilot import StickPilot
from workbench.gui.joystick.response_view import ResponseView, axis_responses
from workbench.gui.joystick.servo_stick import ServoStick
from workbench.gui.joystick.state_bar import StateBar
from workbench.gui.joystick.stick_pad import StickPad
from workbench.gui.key_map import KeyMap
from workbench.gui.layout import (
    CardPair,
    button,
    fit_page,
    hbox,
    label,
    vbox,
)
from workbench.gui.preferences import Preferences
from workbench.gui.screens import Screen
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

MODE_HELP = "Forward is where the nose points."
KEYS_HELP = "Keys: {left} and {right}, held down; not while a field or a slider has the focus."
ARROWS = {"Up": "↑", "Down": "↓", "Left": "←", "Right": "→"}
LEFT_STICK_ROWS = tuple(KEY_DIRECTIONS)[:4]
RIGHT_STICK_ROWS = tuple(KEY_DIRECTIONS)[4:]
"""Rows of the table of keys: up, down, left and right of a stick."""
LEFT_STICK_EFFECTS = ("climb", "sink", "turn left", "turn right")
RIGHT_STICK_EFFECTS = ("forward", "back", "left", "right")
"""What a stick does in these directions."""
MIN_REPORTED_SLOWING_M_S = 0.1
"""Smaller reductions of the speed are not reported as gentle [m/s]."""
PAD_TAKE_OVER_HINT = "press Start on it, with its sticks released, to take over"
FLYING_PAD_GONE_TEXT = f"The game pad that flew is gone, another one waits: {PAD_TAKE_OVER_HINT}."
NO_PAD_TEXT = "Game pad: none is plugged in; it is found as soon as you plug it in."


def shown_stick_keys(keys: KeyMap, rows: Iterable[str]) -> list[str]:
    """Return the keys of a stick, as shown: up, down, left, right."""
    return [ARROWS.get(keys.key(name), keys.key(name)) for name in rows]


def flying_keys_text(pilot: StickPilot, preferences: Preferences, keys: KeyMap) -> str:
    """Return which keys fly, and how gently near an obstacle."""
    left, right = (
        " ".join(shown_stick_keys(keys, rows)) for rows in (LEFT_STICK_ROWS, RIGHT_STICK_ROWS)
    )
    said = KEYS_HELP.format(left=left, right=right)
    most, plain = pilot.gentle_handling.speed, pilot.handling.speed
    if most > plain - MIN_REPORTED_SLOWING_M_S:
        return said
    metres = unit_for("m", preferences).text(max(0.0, pilot.clearance))
    speed = unit_for("m/s", preferences).text(most)
    return f"{said} An obstacle is {metres} away: keys and mouse command {speed} at most."


def game_pad_text(missing: str, name: str, waiting: int = 0, refused: str = "") -> str:
    """Return a line about the game pads.

    Args:
        missing: why there are none, else "".
        name: name of the pad that flies, "" without one.
        waiting: number of other plugged-in pads.
        refused: why one of them may not take over.
    """
    if missing:
        return missing
    if refused:
        return refused
    if not name:
        return FLYING_PAD_GONE_TEXT if waiting else NO_PAD_TEXT
    buttons = ", ".join(f"{each.place}: {each.words}" for each in PadButton)
    if waiting:
        return f"{name} flies, {waiting} waits: {PAD_TAKE_OVER_HINT}. {buttons}."
    return f"Game pad: {name}. {buttons}."


class JoystickScreen(Screen):
    """Fly by mouse, keyboard or game pad.

    Args:
        workspace: services that all screens share.

    Attributes:
        pilot: reads the sticks and flies.
        left_pad: the stick for climb and yaw.
        right_pad: the stick for horizontal flight.
        response: commanded and flown values.
        handling: sensitivity of the sticks.
        servos: the setpoints of servos.
        state_bar: whether the sticks have an effect, and who has control.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        look, preferences = workspace.look, workspace.preferences
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.pilot = StickPilot(workspace.flight, preferences, workspace.keys, self)
        self.state_bar = StateBar(self.pilot, workspace)
        self.left_pad = StickPad("Left stick", LEFT_STICK_EFFECTS, look, self)
        self.right_pad = StickPad("Right stick", RIGHT_STICK_EFFECTS, look, self)
        self.response = ResponseView(look, preferences)
        self.handling = HandlingPanel(preferences, look)
        self.servos = ServoStick(workspace)
        self._keys_line = label("", "muted", wraps=True)
        self._pad_line = label("", "muted", wraps=True)
        help = "What the axes of each pad do, and which pad flies."
        self.pads_button = button("Game pads…", self._map_pads, "quiet compact", help)
        self._lay_out()
        self.left_pad.dragged.connect(lambda stick: self.pilot.hold_stick("left", stick))
        self.right_pad.dragged.connect(lambda stick: self.pilot.hold_stick("right", stick))
        self.pilot.changed.connect(self._show_sticks)
        workspace.keys.changed.connect(self._show_keys)
        self._show_keys("all")
        self._show_sticks()

    def begin(self, view: LiveView) -> None:
        """Note that a flight has begun."""
        self.pilot.begin(view)
        self.servos.begin(view)
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show the command and the response, and who has control."""
        if view.snapshot is not None and self.workspace.flight.live is not None:
            self.response.show_rows(
                axis_responses(view.snapshot, self.pilot.handling, self.pilot.limits)
            )
        self.state_bar.show_view(view)
        self.servos.show_view(view)
        self._show_keys()

    def release(self) -> None:
        """Release both sticks."""
        self.left_pad.let_go()
        self.right_pad.let_go()
        self.pilot.release()

    def close_screen(self) -> None:
        """Close the game pads."""
        self.release()
        self.pilot.close()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Start reading the sticks."""
        super().showEvent(event)
        self.pilot.listen_to_pads(self.isActiveWindow())
        self.pilot.start()
        self.pilot.keyboard.watch(self)
        self.setFocus(Qt.FocusReason.OtherFocusReason)
        self.show_view(self.workspace.flight.view)

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Stop reading the sticks."""
        super().hideEvent(event)
        self.pilot.keyboard.stop()
        self.release()
        self.pilot.stop()

    def event(self, event: QEvent | None) -> bool:
        """Release the sticks when another window becomes active."""
        if event is not None and event.type() is QEvent.Type.WindowDeactivate:
            self.pilot.listen_to_pads(False)
            self.release()
        elif event is not None and event.type() is QEvent.Type.WindowActivate:
            self.pilot.listen_to_pads(True)
        return super().event(event)

    def _map_pads(self) -> None:
        """Open the dialog of the pads; the main window is then inactive, so no pad flies."""
        self.release()
        PadDialog(self.pilot, self).show()  # not modal: STOP stays available

    def _show_keys(self, changed: str = "") -> None:
        """Show which keys fly."""
        keys = self.workspace.keys
        self._keys_line.setText(flying_keys_text(self.pilot, self.workspace.preferences, keys))
        if changed:
            self.left_pad.show_keys(shown_stick_keys(keys, LEFT_STICK_ROWS))
            self.right_pad.show_keys(shown_stick_keys(keys, RIGHT_STICK_ROWS))

    def _show_sticks(self) -> None:
        """Show the sticks' positions."""
        pilot = self.pilot
        counts = not pilot.barred
        self.left_pad.show_stick(pilot.sticks[:2], counts)
        self.right_pad.show_stick(pilot.sticks[2:], counts)
        for pad in (self.left_pad, self.right_pad):
            pad.show_dead_band(pilot.handling.dead_band)
        self.handling.curve.show_handling(pilot.handling)
        self.handling.curve.show_sticks(pilot.sticks)
        said = game_pad_text(
            pilot.pads.missing, pilot.pad_name, pilot.pads_waiting, pilot.hand_over
        )
        self._pad_line.setText(said)
        self.pads_button.setEnabled(bool(pilot.pads.readings))
        self.state_bar.show_view(self.workspace.flight.view)

    def _lay_out(self) -> None:
        sticks = hbox((self.left_pad, 1), (self.right_pad, 1), spacing=16)
        flying = help_card("Sticks", (sticks, 1), self.servos, label(MODE_HELP, "muted"))
        heading = label("Command and answer", "heading")
        answer = help_card("Command and answer", heading, (self.response, 1))
        hints = vbox(self._keys_line, self._pad_line, spacing=2)
        page = vbox(
            self.state_bar,
            (CardPair(flying, answer, (3, 2), 12), 1),
            help_card("Feel of the sticks", (self.handling, 1)),
            hbox((hints, 1), self.pads_button),
            margins=(16, 12, 16, 12),
            spacing=12,
        )
        fit_page(self, page)
