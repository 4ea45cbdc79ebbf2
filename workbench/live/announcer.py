"""Events on board, as sentences and as payloads of topics."""

import struct
import time
from collections.abc import Callable, Iterator, Sequence

from workbench.control.mode import FlightMode, Reason
from workbench.link.backplane import Published
from workbench.link.drone_topics import DRONE_STATE_SIGNAL, EVENTS_SIGNAL, PARAMETERS_SIGNAL
from workbench.link.topics import Topic
from workbench.scenario.faults import TURBULENCES, failing_parts
from workbench.scenario.scenario import Action

INFORMATION_SEVERITY = 0
WARNING_SEVERITY = 1
FAILURE_SEVERITY = 2
"""Severity of an event."""
RESERVE_PARAMETER = "battery_reserve"
"""Name of the parameter for the charge at which the drone lands by itself."""
LIMITATION_REMEDIES = {
    Reason.DEAD_RECKONING: "Land, or repair the GPS",
    Reason.POSITION_LOST: "It lands where it is: repair the GPS, then reset",
    Reason.IMU_FAILED: "The rotors are off: repair the IMU, then reset",
    Reason.HEADING_DRIFTS: "Land, or repair the magnetometer",
}
"""What to do about a limitation of the estimate."""
REASONS_WITH_OWN_TEXT = (Reason.BATTERY_LOW, Reason.BATTERY_EMPTY, Reason.AUTOPILOT_ENDED)
"""Reasons that have a sentence elsewhere."""
LOW_CHARGE_MARGIN = 0.1
"""A battery is low below the reserve plus this charge."""


class Announcer:
    """Makes events from changes in the flight.

    Args:
        topics: topics of the flight.
        reserve: returns the battery's charge, 0 .. 1, at which the drone lands by itself.
    """

    def __init__(self, topics: Sequence[Topic], reserve: Callable[[], float]) -> None:
        found = {topic.id: topic for topic in topics}
        self._events, self._parameters = found[EVENTS_SIGNAL.id], found[PARAMETERS_SIGNAL.id]
        self._reserve = reserve
        self.begin()

    def begin(self) -> None:
        """Start again with a new flight."""
        self._mode: FlightMode | None = None
        self._was_low = False
        self._low: tuple[str, ...] = ()
        self._reason = Reason.NONE

    @property
    def lasting(self) -> tuple[str, ...]:
        """What the present warnings say whose cause lasts."""
        reason = () if self._reason in (Reason.NONE, *REASONS_WITH_OWN_TEXT) else (self._reason,)
        return (*(each.label for each in reason), *self._low)

    def event(self, time_s: float, said: str, severity: int) -> Published:
        """Return a sentence as it is published at a simulated time [s]."""
        return _published(time_s, EVENTS_SIGNAL.id, self._events.pack((severity, said)))

    def parameter(self, time_s: float, name: str, value: float) -> Published:
        """Return a parameter's new value as it is published at a simulated time [s]."""
        return _published(time_s, PARAMETERS_SIGNAL.id, self._parameters.pack((name, value)))

    def changes(self, published: Published) -> Iterator[tuple[str, int]]:
        """Yield a sentence and its severity for each change of the flight mode or the battery."""
        for number, payload in published.payloads:
            if number == DRONE_STATE_SIGNAL.id:
                mode, charge = struct.unpack_from("<i16xf", payload)
                yield from self._state(FlightMode(mode), charge)

    def reasons(self, now: Reason) -> Iterator[tuple[str, int]]:
        """Yield a sentence and its severity for each new failure, and for each end of one.

        `changes` reports the battery's reasons with its charge, and `FlightLoop` reports the end of
        the autopilot with its cause.
        """
        before, self._reason = self._reason, now
        if now is before or now in REASONS_WITH_OWN_TEXT:
            return
        if now is not Reason.NONE:
            yield f"{now.label}. {LIMITATION_REMEDIES[now]}", WARNING_SEVERITY
        elif before in (Reason.DEAD_RECKONING, Reason.HEADING_DRIFTS):
            yield "the estimate has all of its sensors again", INFORMATION_SEVERITY

    def _state(self, mode: FlightMode, charge: float) -> Iterator[tuple[str, int]]:
        before, self._mode = self._mode, mode
        changed = before is not None and mode is not before
        if changed:
            yield f"flight mode: {mode.label}", INFORMATION_SEVERITY
        reserve = self._reserve()
        if changed and mode is FlightMode.LANDING and charge <= reserve:
            said = f"battery empty: the drone lands with the last {charge_percent(reserve)}"
            self._low = (said,)
            yield f"{said}. Let it land, then reset", WARNING_SEVERITY
        elif changed and mode is FlightMode.OFF and charge <= 0.0:
            self._low = ("battery empty: the rotors are off",)
            yield f"{self._low[0]}. Reset to fly again", WARNING_SEVERITY
        elif not self._was_low and reserve < charge <= reserve + LOW_CHARGE_MARGIN:
            said = (
                f"battery low: {charge_percent(charge)}; the drone lands at "
                f"{charge_percent(reserve)}"
            )
            self._low = (said,)
            yield f"{said}. Land (F8)", WARNING_SEVERITY
        self._was_low = charge <= reserve + LOW_CHARGE_MARGIN
        if not self._was_low:
            self._low = ()


def charge_percent(charge: float) -> str:
    """Return a charge 0 .. 1 in percent, as text."""
    return f"{100.0 * charge:.0f}\N{NO-BREAK SPACE}%"


def _published(time_s: float, number: int, payload: bytes) -> Published:
    return Published(round(time_s * 1e9), time.time_ns(), ((number, payload),))


def disturbance_texts(action: Action) -> Iterator[str]:
    """Yield a sentence for each disturbance of an action; none for one that ends it."""
    push, gust = action.push, action.gust
    if push is not None and any(push.force):
        yield f"a push of {_vector_text(push.force)} N for {push.duration:g} s"
    if push is not None and any(push.torque):
        yield f"a torque of {_vector_text(push.torque)} N·m for {push.duration:g} s"
    if gust is not None and any(gust.velocity):
        yield f"a gust of {_vector_text(gust.velocity)} m/s for {gust.duration:g} s"
    wind = [action.set.get(f"wind_{axis}", 0.0) for axis in "xyz"]
    if any(wind):
        yield f"a wind of {_vector_text(wind)} m/s"
    if "turbulence" in action.set:
        speed = action.set["turbulence"]
        named = (name for name, made_by in TURBULENCES.items() if made_by == speed)
        yield f"turbulence: {next(named, f'{speed:g} m/s at 20 ft')}"
    for part in failing_parts():
        if part.parameter in action.set:
            yield part.fault(action.set[part.parameter]) or f"{part.name} repaired"


def _vector_text(parts: Sequence[float]) -> str:
    return f"({', '.join(f'{part:.4g}' for part in parts)})"
