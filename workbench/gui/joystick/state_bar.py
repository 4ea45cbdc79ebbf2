"""The lines that say whether the sticks act and who has control, with buttons to change it."""

import math

from PyQt6.QtWidgets import QFrame

from workbench.control.mode import FlightMode
from workbench.gui.actions import find_action
from workbench.gui.flight_control import (
    ON_GROUND_TEXT,
    FlightControl,
    are_hooks_open,
    possible_actions,
)
from workbench.gui.help import set_card_help
from workbench.gui.joystick.pilot import StickDevice, StickPilot
from workbench.gui.joystick.piloting import FlightLimits, StickCommand
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, hbox, label, named, vbox
from workbench.gui.preferences import Preferences
from workbench.gui.style import set_class
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.link.messages import ControlOwner, ControlState
from workbench.live.orders import NetworkOrder
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action

STICKS_READY_TEXT = "Ready: move a stick to fly, release it to stop and hold."
LIMIT_TOLERANCE_FACTOR = 1.001
"""Tolerance factor, so that a stick exactly at the limit does not count as beyond it."""
TAKING_OFF_TEXT = "Taking off: the sticks count once it hovers."


def stick_state_text(view: LiveView, barred: str, device: StickDevice) -> str:
    """Return whether the sticks have an effect, as a sentence."""
    if barred:
        return barred
    if view.snapshot is not None and view.snapshot.mode is FlightMode.TAKING_OFF:
        return TAKING_OFF_TEXT
    return STICKS_READY_TEXT if device is StickDevice.NONE else f"You fly, by {device.value}."


def control_holder_text(view: LiveView) -> str:
    """Return who has control, as a sentence."""
    control = view.network.control
    if is_client(control):
        assert control is not None
        name = control.name or f"Client {control.peer}"
        return f"{name} flies over the network. A stick that you move takes over."
    if view.network.server is None:
        return "No server runs, so nobody else can fly."
    if control is not None and control.hand is ControlOwner.OPERATOR:
        return "You have control. Clients wait until you give it back."
    return "Nobody has control. A stick that you move takes it."


def exceeded_limits_text(limits: FlightLimits, wish: StickCommand, preferences: Preferences) -> str:
    """Return which limits of the flight reduce a command, "" for none."""
    level = math.hypot(wish.forward, wish.left)
    rows = (
        ("level speed", "max_speed", level, limits.level, "m/s"),
        ("climb", "max_climb_rate", abs(wish.climb), limits.climb, "m/s"),
        ("turning", "max_yaw_rate", abs(wish.yaw_rate), limits.turn, "rad/s"),
    )
    texts = []
    for what, parameter, asked, limit, si in rows:
        if asked > LIMIT_TOLERANCE_FACTOR * limit:
            unit = unit_for(si, preferences)
            texts.append(
                f"{what} is held to {unit.text(limit)} by {parameter}, not {unit.text(asked)}"
            )
    return "Limit: " + "; ".join(texts) + "." if texts else ""


def is_client(control: ControlState | None) -> bool:
    """Return whether a client has control."""
    return control is not None and control.hand is ControlOwner.CLIENT


def is_operator(control: ControlState | None) -> bool:
    """Return whether the operator has taken control, so that clients must wait."""
    return control is not None and control.hand is ControlOwner.OPERATOR


class StateBar(QFrame):
    """Two lines of text and four buttons, each shown only when useful.

    Args:
        pilot: pilot of the sticks.
        workspace: services that all screens share.
    """

    def __init__(self, pilot: StickPilot, workspace: Workspace) -> None:
        super().__init__()
        self._pilot, self._workspace = pilot, workspace
        self.setProperty("class", "card")
        set_card_help(self, "Who flies")
        self.state = label(kind="value", wraps=True)
        self.control = label(kind="muted", wraps=True)
        flight = workspace.flight
        self.take_off = button("Take off", lambda: flight.do(Action(request="take_off")), "primary")
        self.take_over = button("Take over", lambda: flight.do(NetworkOrder.TAKE_OVER), "primary")
        self.give_back = button("Give back", pilot.give_back)
        self.hooks = button(
            "Drop load", FlightControl(flight, workspace.preferences, self).toggle_hooks
        )
        for each, help in (
            (self.take_off, "take off"),
            (self.take_over, "take control from the client that flies"),
            (self.give_back, "let clients request control again"),
            (self.hooks, find_action("open_hooks").help),
        ):
            named(each, f"{each.text()}: {help}").hide()
        words = vbox(self.state, self.control, spacing=2)
        hbox(
            (words, 1),
            self.take_off,
            self.take_over,
            self.give_back,
            self.hooks,
            of=self,
            margins=(16, 10, 16, 10),
            spacing=8,
        )

    def show_view(self, view: LiveView) -> None:
        """Show the state."""
        pilot, control = self._pilot, view.network.control
        self.state.setText(stick_state_text(view, pilot.barred, pilot.device))
        bites = exceeded_limits_text(pilot.limits, pilot.wish, self._workspace.preferences)
        self.control.setText(bites or control_holder_text(view))
        set_class(self.control, "warning" if bites else "muted")
        self.take_off.setVisible(pilot.barred == ON_GROUND_TEXT)
        self.take_over.setVisible(is_client(control))
        has_server = view.network.server is not None
        self.give_back.setVisible(has_server and is_operator(control))
        self._show_hooks(view)

    def _show_hooks(self, view: LiveView) -> None:
        """Show what the hooks' button does, if the vehicle carries loads on hooks."""
        row = find_action("open_hooks")
        self.hooks.setVisible(row.name in possible_actions(view))
        self.hooks.setText("Take load" if are_hooks_open(view) else "Drop load")
        set_tip(self.hooks, self._workspace.keys.with_key(row.name, row.help))
