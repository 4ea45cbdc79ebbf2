"""Answer the requests of clients of the server during a flight."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from xml.etree import ElementTree

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.control.flight_mode import HOLD_HEIGHT_M, accepts_request, in_the_air
from workbench.control.mode import FlightMode, ModeRequest
from workbench.link import backplane
from workbench.link.authority import HOLD_AFTER_S, DeniedError, SilenceEffect
from workbench.link.message_json import ServerMessage, write_message
from workbench.link.messages import (
    DescribeVehicle,
    FlightDone,
    FlightOperation,
    GetParameters,
    Nack,
    ParameterValues,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.link.wire import MAX_PAYLOAD_BYTES
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.scenario.scenario import Action
from workbench.scenario.scenario_check import REQUESTS
from workbench.session.action_check import check_take_off_height
from workbench.session.session import Session
from workbench.systems.bridge import Bridge
from workbench.systems.pilot import urgency


class ClientRequests:
    """Executes the requests of clients.

    Args:
        session: the flown session.
        bridge: bridge of the session.
        do: lets an action take effect, and records who requested it.

    Attributes:
        broken: why the flight cannot continue, "" while it can.
        ended: why the program that runs the law has ended, else "".
        resets: whether a client has requested to start the flight again.
    """

    def __init__(self, session: Session, bridge: Bridge, do: Callable[[Action, str], None]) -> None:
        self._session, self._bridge, self._do = session, bridge, do
        self.broken = self.ended = ""
        self.resets = False
        self._values: dict[str, float] = {}  # looking all of them up takes milliseconds
        self._seen = -1

    def apply_effects(self) -> None:
        """Apply the effect of a change of control before anything else: hold."""
        while effect := self._bridge.authority.effect_due(self._session.time):
            self._do(effect_action(effect), self._bridge.authority.effect_by)

    def gone(self, peer: int) -> None:
        """Take control from a client whose connection has ended, if it has control."""
        self._bridge.authority.gone(peer)
        self.apply_effects()

    def answer(self, request: backplane.ClientRequest) -> backplane.Reply:
        """Execute a request, and return the answer."""
        operation = request.operation
        try:
            with drake_error_sentences("the flight cannot do that"):
                answer = self._carry_out(request)
                self.apply_effects()
        except DeniedError as error:
            answer = Nack(error.code, str(error), operation.id)
        except WorkbenchError as error:
            code = "bad_value" if isinstance(operation, SetParameters) else "not_now"
            answer = Nack(code, str(error), operation.id)
        return backplane.Reply(request.peer, answer)

    def _carry_out(self, request: backplane.ClientRequest) -> ServerMessage:
        authority, now = self._bridge.authority, self._session.time
        operation = request.operation
        reading = isinstance(operation, GetParameters | ReleaseControl | DescribeVehicle)
        resets = isinstance(operation, FlightOperation) and operation.what == "reset"
        if self.broken and not (reading or resets):
            raise DeniedError("not_now", f"{self.broken}: the operator must reset the flight")
        if isinstance(operation, ReleaseControl | FlightOperation | SetParameters):
            authority.check(request.peer, operation.lease, now)
        match operation:
            case RequestControl(id, name):
                self._is_free()
                lease = authority.request(request.peer, name, now)
                return RequestControl(id, lease=lease, expires=HOLD_AFTER_S)
            case ReleaseControl(id):
                authority.release(now)
                return ReleaseControl(id)
            case GetParameters(id, names):
                return ParameterValues(id, self._get(names))
            case DescribeVehicle(id):
                return self._describe(id)
            case FlightOperation(id, "reset"):
                self.resets = True
                return FlightDone(id, "reset", 0)
            case FlightOperation(id, what, height):
                # a stop is not refused for a height that only a take-off has
                action = Action(request=what)
                if what == "take_off":
                    action = replace(action, height=height)
                elif what == "hold":
                    action = replace(effect_action(SilenceEffect.HOLD), end_script=None)
                action = pilot_action(action, self._session, self._bridge)
                self._listens(what, action)
                self._do(action, authority.state(now).name)
                authority.renew(now)
                return FlightDone(id, what, round(now * 1e9))
            case SetParameters(id, values):
                self._get(tuple(values))  # all exist, or none is set
                good = self._session.controller.table.checked(values)
                self._do(Action(set=good), authority.state(now).name)
                authority.renew(now)
                return ParameterValues(id, self._get(tuple(values)), round(now * 1e9))

    def _describe(self, number: int) -> DescribeVehicle:
        """Return the description of the vehicle.

        Raises:
            DeniedError: if it does not fit into a message.
        """
        robot = write_urdf(self._session.description.model)
        answer = DescribeVehicle(number, ElementTree.tostring(robot, encoding="unicode"))
        size = len(write_message(answer))
        if size > MAX_PAYLOAD_BYTES:
            raise DeniedError(
                "not_now",
                f"the description has {size} bytes: a message has {MAX_PAYLOAD_BYTES} at most",
            )
        return answer

    def _is_free(self) -> None:
        """Refuse control if the drone would not follow commands.

        Raises:
            DeniedError: if the drone flies its scenario's path.
        """
        if self._session.scenario.figure_eight:
            raise DeniedError(
                "not_now", "the scenario flies its figure of eight, and nobody else can fly"
            )

    def _listens(self, what: str, action: Action) -> None:
        """Refuse a request that would have no effect although it is answered as done.

        Args:
            what: request of a client.
            action: action that it leads to.

        Raises:
            DeniedError: if the flight mode ignores requests now.
        """
        if self.ended and what != "stop":
            raise DeniedError("not_now", self.ended)
        if action.request not in REQUESTS:
            return
        mode, wanted = self._session.snapshot().mode, ModeRequest[action.request.upper()]
        waiting = self._session.waiting_request
        if waiting is not ModeRequest.HOLD and urgency(waiting) > urgency(
            wanted
        ):  # see `requested`
            first = waiting.name.lower()
            raise DeniedError("not_now", f"{first} was requested just now: request {what} again")
        if not accepts_request(mode, wanted):
            raise DeniedError(
                "not_now", f"the drone is {mode.label}: {what} has no effect until it is off"
            )

    def _get(self, names: tuple[str, ...]) -> Mapping[str, float]:
        """Return live parameters, all if no names are given.

        Raises:
            DeniedError: if this flight lacks one of them.
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


def pilot_action(action: Action, session: Session, bridge: Bridge) -> Action:
    """Return the form in which the action of a pilot, operator or client, takes effect.

    An action that ends the script of the scenario says so.

    During a landing, in the air, some actions end it. A take-off climbs again, if the drone is
    below its height. A hold, a stick that leaves neutral, and a place to go to become a hold.
    """
    if action.ends_script and session.next_action is not None:
        action = replace(action, end_script=True)
    steered = (*(action.velocity or ()), action.yaw_rate or 0.0)
    is_command = action.velocity is not None or action.yaw_rate is not None
    moved = (is_command and bridge.moves(*steered)) or action.go_to is not None
    snapshot = session.snapshot()
    low = session.vehicle.ground_clearance
    if snapshot.mode is not FlightMode.LANDING or not in_the_air(snapshot.p_WB[2], low):
        return action
    if action.request == "take_off":
        check_take_off_height(action.height, low, session.get("max_height"))
        return replace(action, request="abort_landing")
    if action.request == "hold" or (action.request is None and moved):
        return replace(action, request="abort_landing", height=HOLD_HEIGHT_M)
    return action


def effect_action(effect: SilenceEffect, at: float = 0.0) -> Action:
    """Return the script's action that repeats an effect of the ladder or of a new pilot.

    A landing ends the scenario's script; a hold until somebody flies does not.
    """
    ends = effect is SilenceEffect.LAND
    return Action(at, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request=effect.value, end_script=ends)
