"""What the joystick screen says of the flight: whether the sticks count, and who flies."""

from workbench.control.mode import FlightMode
from workbench.gui.joystick.flight_limits import Bite
from workbench.gui.joystick.pilot import Device
from workbench.gui.preferences import Preferences
from workbench.gui.units import unit_for
from workbench.link.server_messages import ControlState, Hand
from workbench.live.view import LiveView

READY = "Ready: move a stick to fly, let go to stop and hold."
TAKING_OFF = "Taking off: the sticks count once it hovers."


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
