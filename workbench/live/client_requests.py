"""What clients of the network ask of a flight, done between its steps and answered."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from workbench.common.errors import WorkbenchError, sentences
from workbench.control.flight_mode import HOLD_HERE, hears, in_the_air
from workbench.control.mode import FlightMode, Request
from workbench.link import backplane
from workbench.link.authority import HOLD_AFTER, DeniedError, Effect
from workbench.link.messages import (
    FlightDone,
    FlightOperation,
    GetParameters,
    Nack,
    ParameterValues,
    ReleaseControl,
    RequestControl,
    ServerMessage,
    SetParameters,
)
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import REQUESTS, Action
from workbench.session.pilot_numbers import check_height
from workbench.session.session import Session
from workbench.systems.bridge import Bridge
from workbench.systems.pilot import urgency


class ClientRequests:
    """Carries out what clients ask for.

    Args:
        session: that is flown.
        bridge: of the session.
        did: told of every action that came into force, and by whom.

    Attributes:
        broken: why the flight cannot go on, "" while it can.
        ended: why the program that runs the law is gone, "" while it is not.
    """

    def __init__(
        self, session: Session, bridge: Bridge, did: Callable[[Action, str], None]
    ) -> None:
        self._session, self._bridge, self._did = session, bridge, did
        self.broken = self.ended = ""
        self._values: dict[str, float] = {}  # to look all of them up takes milliseconds
        self._seen = -1

    def apply_effects(self) -> None:
        """Do what a change of hands asks for before anything else is done: hold."""
        while effect := self._bridge.authority.effect_due(self._session.time):
            action = effect_action(effect)
            self._session.act(action)
            self._did(action, self._bridge.authority.effect_by)

    def gone(self, peer: int) -> None:
        """Take control from a client whose connection has ended, if it has it."""
        self._bridge.authority.gone(peer)
        self.apply_effects()

    def answer(self, request: backplane.Request) -> backplane.Reply:
        """Do what is asked for, and return what to say."""
        operation = request.operation
        try:
            with sentences("the flight cannot do that"):
                answer = self._carry_out(request)
                self.apply_effects()
        except DeniedError as error:
            answer = Nack(error.code, str(error), operation.id)
        except WorkbenchError as error:
            code = "bad_value" if isinstance(operation, SetParameters) else "not_now"
            answer = Nack(code, str(error), operation.id)
        return backplane.Reply(request.peer, answer)

    def _carry_out(self, request: backplane.Request) -> ServerMessage:
        authority, now = self._bridge.authority, self._session.time
        operation = request.operation
        if self.broken and not isinstance(operation, GetParameters | ReleaseControl):
            raise DeniedError("not_now", f"{self.broken}: the operator is to reset the flight")
        if isinstance(operation, ReleaseControl | FlightOperation | SetParameters):
            authority.check(request.peer, operation.lease, now)
        match operation:
            case RequestControl(id, name):
                self._is_free()
                lease = authority.request(request.peer, name, now)
                return RequestControl(id, lease=lease, expires=HOLD_AFTER)
            case ReleaseControl(id):
                authority.release(now)
                return ReleaseControl(id)
            case GetParameters(id, names):
                return ParameterValues(id, self._get(names))
            case FlightOperation(id, what, height):
                action = Action(request=what, height=height)
                if what == "hold":
                    action = effect_action(Effect.HOLD)
                action = in_landing(action, self._session, self._bridge)
                self._listens(what, action)
                self._act(action, now)
                return FlightDone(id, what, round(now * 1e9))
            case SetParameters(id, values):
                self._get(tuple(values))  # all are there, or none is set
                self._act(
                    Action(set=parameter_table(self._session.controller).checked(values)), now
                )
                return ParameterValues(id, self._get(tuple(values)), round(now * 1e9))

    def _is_free(self) -> None:
        """Refuse control where the drone would not do as it is told.

        Raises:
            DeniedError: if it flies a path of its own.
        """
        if self._session.scenario.figure_eight:
            raise DeniedError(
                "not_now", "the scenario flies its figure of eight, and nobody else can"
            )

    def _listens(self, what: str, action: Action) -> None:
        """Refuse what would be answered as done, and have no effect.

        Args:
            what: a client asks for.
            action: that comes of it.

        Raises:
            DeniedError: if the flight mode does not hear a request now.
        """
        if self.ended and what != "stop":
            raise DeniedError("not_now", self.ended)
        if action.request not in REQUESTS:
            return
        mode, wanted = self._session.snapshot().mode, Request[action.request.upper()]
        waiting = self._session.waiting_request
        if waiting is not Request.HOLD and urgency(waiting) > urgency(wanted):  # see `requested`
            first = waiting.name.lower()
            raise DeniedError("not_now", f"{first} was asked for just now: ask for {what} again")
        if not hears(mode, wanted):
            raise DeniedError(
                "not_now", f"the drone is {mode.label}: {what} has no effect until it is off"
            )

    def _act(self, action: Action, now: float) -> None:
        self._session.act(action)
        authority = self._bridge.authority
        authority.renew(now)
        self._did(action, authority.state(now).name)

    def _get(self, names: tuple[str, ...]) -> Mapping[str, float]:
        """Return live parameters, all if no names are given.

        Raises:
            DeniedError: if this flight has not one of them.
        """
        if self._seen != self._bridge.settings:
            self._values, self._seen = self._session.parameters(), self._bridge.settings
        if not names:
            return self._values
        for name in names:
            if name not in self._values:
                raise DeniedError(
                    "unknown_parameter", f"the flight has no parameter {name:.60}: hello lists them"
                )
        return {name: self._values[name] for name in names}


def in_landing(action: Action, session: Session, bridge: Bridge) -> Action:
    """Return what a pilot's action is in a landing, in the air: some end it.

    A take-off climbs again, if the drone is lower than its height; a hold holds, and so does a
    stick that leaves neutral, or a place to go to. Anything else is returned as it is.
    """
    steered = (*(action.velocity or ()), action.yaw_rate or 0.0)
    is_command = action.velocity is not None or action.yaw_rate is not None
    moved = (is_command and bridge.moves(*steered)) or action.go_to is not None
    snapshot = session.snapshot()
    low = session.vehicle.ground_clearance
    if snapshot.mode is not FlightMode.LANDING or not in_the_air(snapshot.p_WB[2], low):
        return action
    if action.request == "take_off":
        check_height("take_off", action.height, low, session.get("max_height"))
        return replace(action, request="abort_landing")
    if action.request == "hold" or (action.request is None and moved):
        return replace(action, request="abort_landing", height=HOLD_HERE)
    return action


def effect_action(effect: Effect, at: float = 0.0) -> Action:
    """Return what a script does to fly what the ladder, or a change of hands, does."""
    return Action(at, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request=effect.value)
