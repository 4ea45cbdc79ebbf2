"""What the top bar says of a flight, in words and shapes; Qt has no part in it."""

from dataclasses import dataclass

from workbench.control.mode import FlightMode
from workbench.link.server_messages import Hand, Stage
from workbench.live.announcer import LOW_CHARGE, RESERVE
from workbench.live.messages import Phase
from workbench.live.view import LiveView

PLAIN, GOOD, WARNING, BAD, MUTED = "", "good", "warning", "bad", "muted"


@dataclass(frozen=True)
class Said:
    """A few words with a shape.

    Attributes:
        text: the words.
        icon: the shape, see `icons`.
        tone: the class of their colour.
        full: the same as a sentence, for those who hear it.
    """

    text: str
    icon: str
    tone: str = PLAIN
    full: str = ""


_PHASES = {
    Phase.STARTING: Said("starting", "pace", MUTED),
    Phase.BROKEN: Said("broken", "failure", BAD),
    Phase.ENDED: Said("ended", "failure", BAD),
}
_MODES = {
    FlightMode.OFF: "ground",
    FlightMode.ARMED: "arm",
    FlightMode.TAKING_OFF: "take_off",
    FlightMode.HOVERING: "hold",
    FlightMode.ASCENDING: "take_off",
    FlightMode.DESCENDING: "land",
    FlightMode.CRUISING: "resume",
    FlightMode.LANDING: "land",
}


def mode_said(view: LiveView) -> Said:
    """Return what the drone does."""
    if view.phase in _PHASES or view.snapshot is None:
        said = _PHASES.get(view.phase, _PHASES[Phase.STARTING])
        return Said(said.text, said.icon, said.tone, f"{said.text}: {view.said}")
    mode = view.snapshot.mode
    if view.phase is Phase.PAUSED:
        return Said(f"paused, {mode.label}", "pause", WARNING, f"paused while {mode.label}")
    return Said(mode.label, _MODES[mode], PLAIN, f"flight mode: {mode.label}")


def time_said(view: LiveView) -> Said:
    """Return the simulated time."""
    if view.snapshot is None:
        return Said(view.said or "–", "clock", MUTED, view.said)
    time = view.snapshot.time
    minutes, seconds = divmod(int(time * 10.0) / 10.0, 60.0)
    return Said(f"{int(minutes)}:{seconds:04.1f}", "clock", PLAIN, "simulated time")


def battery_said(view: LiveView) -> Said:
    """Return how full the battery is."""
    if view.snapshot is None:
        return Said("–", "battery", MUTED, "battery: not known yet")
    charge = view.snapshot.charge
    reserve = view.values.get(RESERVE, 0.0)
    text = f"{100.0 * charge:.0f} %"
    if charge <= reserve:
        full = f"battery {text} left: the drone lands by itself"
        return Said(f"{text} left", "battery", BAD, full)
    if charge <= reserve + LOW_CHARGE:
        return Said(f"{text} low", "battery", WARNING, f"battery {text}, low")
    return Said(text, "battery", PLAIN, f"battery {text}")


def reached_said(view: LiveView) -> Said:
    """Return the real-time factor that is reached."""
    if view.pace is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return Said("–", "pace", MUTED, "speed reached: not known")
    if view.phase is Phase.PAUSED:
        return Said("paused", "pause", MUTED, "the flight is paused")
    tone = WARNING if view.pace.too_slow else PLAIN
    return Said(f"reached {view.pace.text}", "pace", tone, str(view.pace))


def link_said(view: LiveView) -> Said:
    """Return who watches and who flies."""
    server, control = view.network.server, view.network.control
    if server is None:
        return Said("no server", "link", MUTED, "no server runs: start one on the Server screen")
    clients = len(server.clients)
    count = "1 client" if clients == 1 else f"{clients} clients"
    full = f"server at {server.address}, {count}"
    if control is None or control.hand is Hand.NOBODY:
        return Said(f"{count}, nobody flies", "link", PLAIN, full)
    who = "you fly" if control.hand is Hand.OPERATOR else f"{control.name or 'a client'} flies"
    if control.stage is not Stage.LIVE:
        text = f"{control.name or 'client'} silent: {control.stage.value}"
        return Said(text, "warning", WARNING, f"{full}: {control.reason}")
    return Said(f"{count}, {who}", "link", PLAIN, f"{full}; {control.reason}")


def warnings_said(view: LiveView) -> tuple[Said, ...]:
    """Return what needs a look now, what is nearest to harm first."""
    if view.snapshot is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return ()
    found = []
    near = view.snapshot.clearance
    if near is not None and near.warning:
        text = f"obstacle {max(near.distance, 0.0):.1f} m"
        found.append(Said(text, "warning", BAD, f"an obstacle is {near.distance:.1f} m away"))
    if view.pace is not None and view.pace.too_slow and view.phase is Phase.FLYING:
        found.append(Said("machine too slow", "warning", WARNING, str(view.pace)))
    return tuple(found)
