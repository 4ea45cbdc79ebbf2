"""The state of the flight as short texts with icons: mode, time, battery, link and warnings."""

from dataclasses import dataclass

from workbench.common.plain_text import plain_name
from workbench.gui.flight_control import are_hooks_open
from workbench.gui.icons import MODE_ICONS
from workbench.gui.units import LENGTH_UNIT, SHARE_UNIT, simulated_text
from workbench.link.messages import ControlOwner, LinkLossStage
from workbench.live.announcer import LOW_CHARGE_MARGIN, RESERVE_PARAMETER
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action

PLAIN_TONE, WARNING_TONE, BAD_TONE, MUTED_TONE = "", "warning", "bad", "muted"
LOST_EXCHANGE_SHARE = 0.01
"""Share of lost answers of an autopilot above which a warning is shown."""


@dataclass(frozen=True)
class StatusText:
    """A short text with an icon.

    Attributes:
        text: the text.
        icon: name of the icon, see `icons`.
        tone: class of its colour.
        full: the same as a sentence, for screen readers.
    """

    text: str
    icon: str
    tone: str = PLAIN_TONE
    full: str = ""


_ORDER_TEXTS = (
    ("go_to", "go to a place"),
    ("velocity", "velocity"),
    ("yaw_rate", "yaw rate"),
    ("setpoint", "attitude"),
    ("gust", "gust"),
    ("push", "push"),
    ("injection", "injection"),
    ("controller", "controller"),
)
"""Fields of a script's action, the most important first, and what they order."""
MAX_SHOWN_PARAMETER_CHARS = 20
"""Number of shown characters of a parameter's name."""
_PHASE_STATUS = {
    Phase.STARTING: StatusText("starting", "pace", MUTED_TONE),
    Phase.BROKEN: StatusText("broken", "failure", BAD_TONE),
    Phase.ENDED: StatusText("ended", "failure", BAD_TONE),
}


def mode_status(view: LiveView) -> StatusText:
    """Return the flight mode."""
    if view.phase in _PHASE_STATUS or view.snapshot is None:
        said = _PHASE_STATUS.get(view.phase, _PHASE_STATUS[Phase.STARTING])
        return StatusText(said.text, said.icon, said.tone, f"{said.text}: {view.said}")
    mode = view.snapshot.mode
    if view.autopilot is not None and view.autopilot.ended:
        return StatusText(f"{mode.label}, held", "failure", BAD_TONE, view.autopilot.ended)
    if view.phase is Phase.PAUSED:
        return StatusText(
            f"paused, {mode.label}", "pause", WARNING_TONE, f"paused while {mode.label}"
        )
    return StatusText(mode.label, MODE_ICONS[mode], PLAIN_TONE, f"flight mode: {mode.label}")


def time_status(view: LiveView) -> StatusText:
    """Return the simulated time."""
    if view.snapshot is None or view.phase is Phase.STARTING:
        return StatusText(view.said or "–", "clock", MUTED_TONE, view.said)
    text = simulated_text(view.snapshot.time, paused=view.phase is not Phase.FLYING)
    return StatusText(text, "clock", PLAIN_TONE, "simulated time")


def battery_status_text(view: LiveView) -> StatusText:
    """Return the battery's charge."""
    if view.snapshot is None:
        return StatusText("–", "battery", MUTED_TONE, "battery: not known yet")
    charge = view.snapshot.charge
    reserve = view.values.get(RESERVE_PARAMETER, 0.0)
    text = SHARE_UNIT.text(charge)
    if charge <= reserve:
        full = f"battery {text} left: the drone lands by itself"
        return StatusText(f"{text} left", "battery", BAD_TONE, full)
    if charge <= reserve + LOW_CHARGE_MARGIN:
        return StatusText(f"{text} low", "battery", WARNING_TONE, f"battery {text}, low")
    return StatusText(text, "battery", PLAIN_TONE, f"battery {text}")


def real_time_status(view: LiveView) -> StatusText:
    """Return the achieved real-time factor."""
    if view.pace is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return StatusText("–", "pace", MUTED_TONE, "speed reached: not known")
    if view.phase is Phase.PAUSED:
        return StatusText("paused", "pause", MUTED_TONE, "the flight is paused")
    tone = WARNING_TONE if view.pace.too_slow else PLAIN_TONE
    return StatusText(f"reached {view.pace.text}", "pace", tone, str(view.pace))


def link_status(view: LiveView) -> StatusText:
    """Return who is connected and who has control."""
    server, control = view.network.server, view.network.control
    if server is None:
        return StatusText(
            "no server", "link", MUTED_TONE, "no server runs: start one on the Server screen"
        )
    clients = len(server.clients)
    count = "1 client" if clients == 1 else f"{clients} clients"
    full = f"server at {server.address}, {count}"
    if control is None or control.hand is ControlOwner.NOBODY:
        return StatusText(f"{count}, nobody flies", "link", PLAIN_TONE, full)
    who = (
        "you fly"
        if control.hand is ControlOwner.OPERATOR
        else f"{control.name or 'a client'} flies"
    )
    if control.stage is not LinkLossStage.LIVE:
        text = f"{control.name or 'client'} silent: {control.stage.value}"
        return StatusText(text, "warning", WARNING_TONE, f"{full}: {control.reason}")
    return StatusText(f"{count}, {who}", "link", PLAIN_TONE, f"{full}; {control.reason}")


def script_status(view: LiveView) -> StatusText | None:
    """Return when the scenario's script gives its next order, None if it gives no more."""
    if view.next_action is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return None
    at = simulated_text(view.next_action.at)
    order = _order_text(view.next_action)
    full = f"next order of the scenario's script: {order} at {at}; Hold, Land and STOP end it"
    return StatusText(f"script: {at} {order}", "clock", PLAIN_TONE, full)


def _order_text(action: Action) -> str:
    """Return what an action of a script does, in few words."""
    if action.request is not None:
        return action.request.replace("_", " ")
    for name, text in _ORDER_TEXTS:
        if getattr(action, name) is not None:
            return text
    if len(action.set) == 1:
        return f"set {plain_name(next(iter(action.set)), MAX_SHOWN_PARAMETER_CHARS)}"
    if action.set:
        return "set parameters"
    return "end of the script" if action.end_script else "no order"


def autopilot_status(view: LiveView) -> StatusText | None:
    """Return the state of the exchange with a program that runs the law, None without one."""
    if view.autopilot is None or view.controller is None or not view.autopilot.exchange:
        return None
    name = view.controller.name
    if view.autopilot.ended:
        return StatusText(f"{name} ended", "failure", BAD_TONE, view.autopilot.ended)
    sent, lost = (round(view.autopilot.exchange[what]) for what in ("packets", "lost"))
    full = f"{name} did not answer {lost} of {sent} packets in time; the motors were held then"
    return StatusText(
        f"{name}: {lost} lost",
        "link",
        WARNING_TONE if lost > LOST_EXCHANGE_SHARE * sent else PLAIN_TONE,
        full,
    )


def load_status(view: LiveView) -> StatusText | None:
    """Return whether the loads hang on their hooks, None for a vehicle without loads on cables."""
    if view.vehicle is None or view.vehicle.unloaded is None or view.snapshot is None:
        return None
    if are_hooks_open(view):
        return StatusText(
            "hooks open", "hook", PLAIN_TONE, "the hooks are open: no load hangs on them"
        )
    kept = view.vehicle.unloaded.cables
    if all(cable.slack for cable in view.snapshot.cables if cable.name not in kept):
        return StatusText(
            "load hooked, slack", "hook", MUTED_TONE, "hooked, and its cables are slack"
        )
    return StatusText("load hooked", "hook", PLAIN_TONE, "hooked, and a cable is taut")


def warnings_status(view: LiveView) -> tuple[StatusText, ...]:
    """Return the present warnings, the most severe first."""
    if view.snapshot is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return ()
    found = []
    near = view.snapshot.clearance
    if near is not None and near.warning:
        distance = LENGTH_UNIT.text(max(near.distance, 0.0))
        found.append(
            StatusText(
                f"obstacle {distance}", "warning", BAD_TONE, f"an obstacle is {distance} away"
            )
        )
    if view.pace is not None and view.pace.too_slow and view.phase is Phase.FLYING:
        found.append(StatusText("machine too slow", "warning", WARNING_TONE, str(view.pace)))
    return tuple(found)
