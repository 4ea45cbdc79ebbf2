"""A flight's network: its server, its clients and their requests, control, and the log."""

import dataclasses
import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError, sentences
from workbench.control.flight_mode import HOLD_HERE, hears, in_the_air
from workbench.control.mode import FlightMode, Request
from workbench.ipc.channel import Channel
from workbench.ipc.child_process import ChildProcess
from workbench.ipc.worker_process import Answer, Refusal
from workbench.link import backplane
from workbench.link.authority import HOLD_AFTER, DeniedError, Effect
from workbench.link.backplane import (
    Command,
    Disconnect,
    Flight,
    Gone,
    Published,
    ServerFailed,
    ServerStatus,
    Stop,
)
from workbench.link.hello import ParameterRow
from workbench.link.messages import (
    ControlState,
    FlightDone,
    FlightOperation,
    GetParameters,
    Hand,
    Nack,
    ParameterValues,
    ReleaseControl,
    RequestControl,
    ServerMessage,
    SetParameters,
    Stage,
)
from workbench.link.server.config import ServerConfig
from workbench.live.announcer import FAILURE, INFORMATION, RESERVE, WARNING, Announcer, disturbed
from workbench.live.log_keeper import LogKeeper
from workbench.live.messages import Do, NetworkView
from workbench.live.stream import Stream
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import REQUESTS, Action
from workbench.session.pilot_numbers import check_height
from workbench.session.script import acting_step
from workbench.session.session import Session
from workbench.systems.bridge import Applied, Bridge
from workbench.systems.pilot import urgency


class ClientRequests:
    """Executes the requests of clients.

    Args:
        session: the flown session.
        bridge: bridge of the session.
        did: called with every action that took effect, and who requested it.

    Attributes:
        broken: why the flight cannot continue, "" while it can.
        ended: why the program that runs the law has ended, else "".
    """

    def __init__(
        self, session: Session, bridge: Bridge, did: Callable[[Action, str], None]
    ) -> None:
        self._session, self._bridge, self._did = session, bridge, did
        self.broken = self.ended = ""
        self._values: dict[str, float] = {}  # looking all of them up takes milliseconds
        self._seen = -1

    def apply_effects(self) -> None:
        """Apply the effect of a change of control before anything else: hold."""
        while effect := self._bridge.authority.effect_due(self._session.time):
            action = effect_action(effect)
            self._session.act(action)
            self._did(action, self._bridge.authority.effect_by)

    def gone(self, peer: int) -> None:
        """Take control from a client whose connection has ended, if it has control."""
        self._bridge.authority.gone(peer)
        self.apply_effects()

    def answer(self, request: backplane.Request) -> backplane.Reply:
        """Execute a request, and return the answer."""
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
            raise DeniedError("not_now", f"{self.broken}: the operator must reset the flight")
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
                self._get(tuple(values))  # all exist, or none is set
                self._act(
                    Action(set=parameter_table(self._session.controller).checked(values)), now
                )
                return ParameterValues(id, self._get(tuple(values)), round(now * 1e9))

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
        mode, wanted = self._session.snapshot().mode, Request[action.request.upper()]
        waiting = self._session.waiting_request
        if waiting is not Request.HOLD and urgency(waiting) > urgency(wanted):  # see `requested`
            first = waiting.name.lower()
            raise DeniedError("not_now", f"{first} was requested just now: request {what} again")
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


def in_landing(action: Action, session: Session, bridge: Bridge) -> Action:
    """Return the form of a pilot's action during a landing, in the air: some actions end it.

    A take-off climbs again, if the drone is below its height. A hold, a stick that leaves neutral,
    and a place to go to become a hold. Any other action is returned unchanged.
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
    """Return the script's action that repeats an effect of the ladder or of a new pilot."""
    return Action(at, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request=effect.value)


STOPPED = "the server was stopped"
STOOD_STILL = "the server stopped reading, and was ended"
PAUSES = (0.1, 0.5, 1.0, 2.0, 4.0)
"""Pauses before restarts of a server that has not listened since the first of them [s]; after the
last one it is not restarted."""
STABLE = 2.0
"""A server that listened for less than this is restarted after `PAUSE_OF_UNSTABLE` [s]."""
PAUSE_OF_UNSTABLE = 1.0
"""Pause that keeps a server that ends at once from taking a processor for itself [s]."""
MOST_TOPICS = 1_000_000
"""Limit of waiting bytes for the server, a second of topics or more; further topics are left
out."""
MOST_ANSWERS = 8_000_000
"""The same limit for answers and control messages, without which clients would wait for ever."""
MOST_RECEIVED = 200
"""Limit of the server's records that are handled at once, so that it cannot stop the flight."""
RETRY = 0.01
"""Pause before unsent data is tried again [s]."""
CLOSING = 2.0
"""Time limit for the server to say goodbye [s]."""
BROADCAST_PERIOD = 1.0
"""Period of broadcasts of who has control [s]."""
LONGEST_TURN = 0.002
"""Limit of the time for clients between two slices of 1/128 s [s of wall]."""
OPERATOR = "operator"
"""Name of the person at the screen, in the log."""
NETWORK_ORDERS = (
    Do.SERVE,
    Do.STOP_SERVING,
    Do.KEEP_LOG,
    Do.STOP_LOG,
    Do.DISCONNECT,
    Do.TAKE_OVER,
    Do.GIVE_BACK,
)
"""Orders to the network and the log."""


class ServerProcess(Channel):
    """A server's process, and the channel to it.

    Args:
        config: configuration of the server.
        flight: description of the flight.

    Raises:
        WorkbenchError: if the process cannot be started.
    """

    def __init__(self, config: ServerConfig, flight: Flight) -> None:
        self._process = ChildProcess("workbench.link.server.process", "server")
        super().__init__(self._process.connection)
        self.offer(config, MOST_ANSWERS)
        self.offer(flight, MOST_ANSWERS)

    @property
    def connection(self) -> Connection:
        """Readable when the server has sent something, or is gone."""
        return self._process.connection

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        if self.has_more:
            return 0.0
        return RETRY if self.unsent else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, unless the server does not keep up: newer ones will follow."""
        self.offer(published, MOST_TOPICS)

    def tell(self, record: object) -> None:
        """Send a message that must not be lost.

        Raises:
            EOFError: if the server has read nothing for so long that it is useless.
        """
        if not self.offer(record, MOST_ANSWERS):
            raise EOFError

    def cause(self) -> str:
        """Return why it ended."""
        return self._process.cause()

    def close(self) -> None:
        """Let the server say goodbye, and end it; this may take seconds."""
        self.offer(Stop.STOP, 2 * MOST_ANSWERS)
        end = time.monotonic() + CLOSING
        while self.unsent and time.monotonic() < end:
            time.sleep(RETRY)
            self.flush()
        super().close()
        self._process.end(max(0.0, end - time.monotonic()))
        self._process.release()


class Ending:
    """Ends a server in a thread, as no flight waits for a server that hangs.

    Args:
        process: the server's process.
        said: why it ends; None if it ended by itself and the cause is still unknown.

    Attributes:
        said: why it ended, once `connection` is readable.
        connection: readable when the server is gone.
    """

    def __init__(self, process: ServerProcess, said: str | None) -> None:
        self.said = said or ""
        self.connection, self._end = Pipe(duplex=False)
        self._process, self._is_known = process, said is not None
        self._thread = threading.Thread(target=self._run, name="ending a server", daemon=True)
        self._thread.start()

    def join(self) -> None:
        """Wait until the server is gone."""
        self._thread.join()
        self.connection.close()

    def _run(self) -> None:
        try:
            if not self._is_known:
                self.said = self._process.cause()
            self._process.close()
        finally:
            self._end.close()


class ServerSupervisor:
    """Starts a server, receives its messages, and notices its end; nothing here blocks.

    A server that ends by itself, even if killed, is restarted at the same address. Meanwhile the
    flight continues: the drone holds, because the connection of its pilot has ended.

    Args:
        flight: returns the description of the flight.
        time: returns the simulated time [s].
        now: returns a monotonic time [s].

    Attributes:
        status: last status from the server, None if none runs.
        said: why it ended by itself, and what happens next; else "".
        answers: unsent answers to the operator's orders.
    """

    def __init__(
        self,
        flight: Callable[[], Flight],
        time: Callable[[], float],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flight, self._time, self._now = flight, time, now
        self.status: ServerStatus | None = None
        self.said = ""
        self.answers: list[Answer | Refusal] = []
        self._process: ServerProcess | None = None
        self._starting: int | None = None
        self._ending: Ending | None = None
        self._stopping: list[int] = []
        self._next: tuple[int, ServerConfig] | None = None
        self._config = ServerConfig()
        self._again_due: float | None = None
        self._restarts = 0  # since a server has listened
        self._since = math.inf
        self._was_ready = self._was_unstable = False

    @property
    def starts_again(self) -> bool:
        """Whether a server that ended by itself is being restarted."""
        return self._again_due is not None or (self._restarts > 0 and self.status is None)

    @property
    def serves(self) -> bool:
        """Whether there is a server without an order to end."""
        return self._process is not None

    @property
    def connections(self) -> list[Connection]:
        """Connections that become readable when a message arrives."""
        return [each.connection for each in (self._process, self._ending) if each]

    def serve(self, number: int, config: ServerConfig) -> None:
        """Start a server once the last one is gone; its address answers an order.

        Raises:
            WorkbenchError: if there is one, or the configuration is invalid.
        """
        if self._process or self._next:
            raise WorkbenchError("the flight is served already: stop its server first")
        config.check()
        self._config, self._again_due, self._restarts = config, None, 0
        if self._ending:  # the new server may need its port
            self._next = number, config
            return
        self._process, self._starting = ServerProcess(config, self._flight()), number

    def stop(self, number: int) -> None:
        """End the server, if there is one, and answer an order when it is gone."""
        if self._next:
            (waiting, _), self._next = self._next, None
            self.answers.append(Refusal(waiting, STOPPED))
        if self.starts_again:
            self.said = ""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._stopping.append(number)
        else:
            self.answers.append(Answer(number, self._time()))

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        if self._again_due is not None:
            return max(0.0, self._again_due - self._now())
        return self._process.wait_time if self._process else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, if there is a server."""
        if self._process:
            self._process.publish(published)

    def tell(self, record: object) -> None:
        """Send a message that must not be lost, if there is a server."""
        if self._process:
            try:
                self._process.tell(record)
            except EOFError:
                self._end(self._process, STOOD_STILL)

    def heard(self) -> Iterator[object]:
        """Yield the requests of clients; other messages are handled here."""
        if self._ending and self._ending.connection.poll():
            self._ended(self._ending)
        if self._again_due is not None and self._now() >= self._again_due:
            self._start_again()
        process = self._process
        if not process:
            return
        try:
            process.flush()
            for record in process.received(MOST_RECEIVED):
                match record:
                    case ServerFailed(said):
                        return self._end(process, said)
                    case ServerStatus():
                        self._take(record)
                    case _:
                        yield record
        except EOFError:
            self._end(process, None)

    def close(self) -> None:
        """End the server, and wait until it is gone."""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._ending.join()

    def _take(self, status: ServerStatus) -> None:
        if self.status is None:
            self._since, self._restarts = self._now(), 0
            self._config = _at_the_same_ports(self._config, status)
        self.status, self.said = status, ""
        if self._starting is not None:
            self.answers.append(Answer(self._starting, status.address))
            self._starting = None

    def _end(self, process: ServerProcess, said: str | None) -> None:
        """End the server for a reason; None if the reason is still unknown."""
        self._ending, self._process = Ending(process, said), None
        self._was_ready = self.status is not None or self._restarts > 0
        self._was_unstable = self.status is not None and self._now() - self._since < STABLE
        self.status, self.said = None, said or ""

    def _ended(self, ending: Ending) -> None:
        """Report the end of a server that is gone."""
        ending.join()
        self._ending, self.said = None, ending.said
        if self._starting is not None:
            self.answers.append(Refusal(self._starting, ending.said or STOPPED))
            self._starting = None
        elif ending.said and self._was_ready and not self._stopping:
            self._plan_again(ending.said)
        self.answers += [Answer(number, self._time()) for number in self._stopping]
        self._stopping.clear()
        if self._next:
            (number, config), self._next = self._next, None
            try:
                self.serve(number, config)
            except WorkbenchError as error:
                self.answers.append(Refusal(number, str(error)))

    def _plan_again(self, cause: str) -> None:
        """Restart a server that ended by itself; give up after some that do not even listen."""
        if self._restarts == len(PAUSES):
            self._restarts = 0
            self.said = f"{cause}; {len(PAUSES)} restarts have failed: start it yourself"
            return
        pause = PAUSE_OF_UNSTABLE if self._was_unstable else PAUSES[self._restarts]
        self._again_due = self._now() + pause
        self._restarts += 1
        self.said = f"{cause}; the server is started again"

    def _start_again(self) -> None:
        self._again_due = None
        try:
            self._config.check()
            self._process = ServerProcess(self._config, self._flight())
        except WorkbenchError as error:  # the token file is gone, or the system is out of resources
            self._plan_again(str(error))


def _at_the_same_ports(config: ServerConfig, status: ServerStatus) -> ServerConfig:
    """Return the configuration of a server that listens at the same address as this one."""
    page = urlsplit(status.page).port if status.page else None
    port = int(status.address.rpartition(":")[2])
    return dataclasses.replace(config, port=port, web_port=page or config.web_port)


class Deferred:
    """Stands for an answer that follows later."""


class FlightNetwork:
    """Serves a flight's network between two slices; it waits only for the disk.

    Args:
        session: the flown session.
        bridge: bridge of the session.
        log: writes the flight's log, on request.
        stream: takes everything that is published, on request.

    Attributes:
        view: state of the network, for display.
    """

    def __init__(
        self,
        session: Session,
        bridge: Bridge,
        log: LogKeeper,
        stream: Stream,
    ) -> None:
        self._session, self._bridge, self._log = session, bridge, log
        self._stream = stream
        self._requests = ClientRequests(session, bridge, self.did)
        rates = session.scenario.rates
        bridge.scripted = frozenset(
            acting_step(action.at, rates) for action in session.scenario.script
        )
        self._server = ServerSupervisor(self._flight, lambda: session.time)
        bridge.at_once = self._server.publish
        self._announcer = Announcer(session.topics, lambda: session.get(RESERVE))
        self.view = NetworkView()
        self._control: ControlState | None = None
        self._broadcast_due = 0.0
        self._scripted = 0  # reported actions of the script
        self._serves, self._said = False, ""
        self._watch_server()

    @property
    def connections(self) -> list[Connection]:
        """Connections to wait for, other than the caller's."""
        return self._server.connections

    def order(self, number: int, what: Do, value: object) -> object:
        """Execute the operator's order, and return the answer, or a `Deferred`.

        Args:
            number: number of the order.
            what: one of `NETWORK_ORDERS`.
            value: its argument.

        Raises:
            WorkbenchError: if it cannot be executed.
        """
        answer: object
        match what, value:
            case Do.SERVE, ServerConfig() as config:
                self._server.serve(number, config)
                answer = Deferred()
            case Do.KEEP_LOG, str(path):
                answer = self._log.start(path)
            case Do.STOP_LOG, _:
                answer = self._log.stop()
            case Do.STOP_SERVING, _:
                self._server.stop(number)
                answer = Deferred()
            case Do.TAKE_OVER, _:
                self.operate()
                answer = self._session.time
            case Do.GIVE_BACK, _:
                answer = self._give_back()
            case Do.DISCONNECT, Disconnect():
                self._server.tell(value)
                answer = self._session.time
            case _:
                raise AssertionError(what, value)
        self._show_log()
        self._watch_server()
        return answer

    def operate(self) -> bool:
        """Give the operator control; return whether a client had it and the drone must hold."""
        holds = self._bridge.authority.take_over(self._session.time)
        if holds:
            self._hold()
        self._watch_control()
        return holds

    @property
    def operates(self) -> bool:
        """Whether the operator has control."""
        return self._bridge.authority.state(self._session.time).hand is Hand.OPERATOR

    def in_landing(self, action: Action) -> Action:
        """Return the form of an operator's action during a landing, which some actions end."""
        if not self.operates:
            self._bridge.moves()  # another pilot's sticks say nothing about the operator's
        return in_landing(action, self._session, self._bridge)

    def did(self, action: Action, by: str = OPERATOR) -> None:
        """Record an action that took effect now."""
        self._note(dataclasses.replace(action, at=self._session.time), by)

    def taken_over(self, same_rows: bool) -> None:
        """Announce the parameters of a new controller to clients.

        Args:
            same_rows: whether they equal those of the last controller, except for their values.
        """
        self._server.tell(self._flight())
        if self._serves and not same_rows:
            self.event("the controller has other parameters: connect again to list them")

    @property
    def done(self) -> list[Action]:
        """Actions since the start, at times of control updates."""
        return self._log.done.actions

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        return self._server.wait_time

    def hear(self) -> None:
        """Execute requests of clients for at most `LONGEST_TURN`; the rest waits."""
        end = time.perf_counter() + LONGEST_TURN
        for record in self._server.heard():
            match record:
                case Command():
                    self._bridge.command(record, self._session.time)
                case backplane.Request():
                    self._server.tell(self._requests.answer(record))
                case Gone(peer):
                    self._requests.gone(peer)
            self._tell_refused()
            if time.perf_counter() >= end:
                break
        self._watch_server()
        self._log.look()
        self._show_log()

    def answers(self) -> list[Answer | Refusal]:
        """Return new answers to deferred orders, once the view shows their effect."""
        answers, self._server.answers = self._server.answers, []
        return answers

    def flown(self) -> None:
        """Publish the results of the steps that were flown."""
        script = self._session.script
        for action in script[self._scripted :]:
            for name, value in {**self._gains_after(action), **action.set}.items():
                self._publish(self._announcer.parameter(action.at, name, value))
        self._scripted = len(script)
        for applied in self._bridge.applied():
            self._note(_action(applied), applied.by)
        for sampled in self._session.drain():
            self._log.write(sampled)
            self._stream.add(sampled.published)
            for said, severity in self._announcer.changes(sampled.published):
                self.event(said, severity)
        for said, severity in self._announcer.reasons(self._session.reason):
            self.event(said, severity)
        self._tell_refused()
        self._watch_control()
        self._show_log()

    def event(self, said: str, severity: int = INFORMATION) -> None:
        """Announce an event to everyone."""
        self._publish(self._announcer.event(self._session.time, said, severity))

    def begin(self) -> None:
        """Start again with a new flight: it has its own log, if any, and its initial values."""
        script = self._session.scenario.script
        actions = (*self.done, *script)
        changed = {n for each in actions for n in (*each.set, *self._gains_after(each))}
        self._announcer.begin()
        self._log.begin_anew()
        self._scripted = 0
        self._show_log()
        self._broadcast_due = 0.0
        self._requests.broken = self._requests.ended = ""
        self.event("the flight started again")
        known = {row.name for row in parameter_table(self._session.controller)}
        for name in sorted(changed & known):
            value = self._session.get(name)
            self._publish(self._announcer.parameter(self._session.time, name, value))
        self._watch_control()

    def ended(self, said: str) -> None:
        """Refuse clients every flight request but stop, for a reason; "" allows them again."""
        self._requests.ended = said

    def broke(self, said: str) -> None:
        """Announce that the flight cannot continue."""
        self.flown()
        self._requests.broken = said
        self.event(said, FAILURE)

    def close(self) -> None:
        """End the server and the log."""
        self._log.stop()
        self._server.close()

    def _flight(self) -> Flight:
        table = parameter_table(self._session.controller)
        rows = tuple(
            ParameterRow(row.name, row.unit, row.minimum, row.maximum, row.default, row.help)
            for row in map(table.find, self._session.parameters())
        )
        limits = self._bridge.authority.limits
        return Flight(
            vehicle=self._session.vehicle.name,
            topics=self._session.topics,
            parameters=rows,
            limits=(limits.level, limits.climb, limits.turn),
        )

    def _gains_after(self, action: Action) -> dict[str, float]:
        """Return the present gains if an action switches to another controller."""
        if action.controller is None:
            return {}
        return {
            row.name: self._session.get(row.name) for row in self._session.controller.parameters
        }

    def _give_back(self) -> float:
        if self._bridge.authority.state(0.0).hand is Hand.OPERATOR:
            self._bridge.authority.begin(self._session.time, "the operator gave control back")
            self._hold()
            self._watch_control()
        return self._session.time

    def _hold(self) -> None:
        hold = effect_action(Effect.HOLD)
        self._session.act(hold)
        self.did(hold)

    def _note(self, action: Action, by: str) -> None:
        """Record an action, and announce parameters that it sets, and a disturbance."""
        self._log.act(action, by)
        for name, value in action.set.items():
            self._publish(self._announcer.parameter(action.at, name, value))
        for said in disturbed(action):
            self.event(said)

    def _watch_control(self) -> None:
        """Announce who has control, on change and periodically."""
        now = self._session.time
        state = self._bridge.authority.state(now)
        last = self._control
        changed = last is None or dataclasses.replace(last, age=state.age) != state
        if not changed and now < self._broadcast_due:
            return
        self._control, self._broadcast_due = state, now + BROADCAST_PERIOD
        self._server.tell(state)
        self._show(control=state)
        if changed and last is not None:
            quiet = state.stage is Stage.LIVE
            self.event(state.reason, INFORMATION if quiet else WARNING)

    def _tell_refused(self) -> None:
        for refused in self._bridge.refused():
            self._server.tell(refused)

    def _watch_server(self) -> None:
        """Notice that a server started or ended: a pilot connected through it has lost control."""
        serves = self._server.serves
        self._bridge.wanted = serves or bool(self._log.path) or self._stream.wanted
        if serves and not self._serves:
            self._control = None  # a new server needs to know who has control, and the time
            now = round(self._session.time * 1e9)
            self._server.publish(Published(now, time.time_ns(), ()))
        elif self._serves and not serves:
            authority = self._bridge.authority
            authority.gone(authority.state(self._session.time).peer)
        self._serves = serves
        self._watch_control()
        status, said, again = self._server.status, self._server.said, self._server.starts_again
        if (self.view.server, self._said) == (status, said):
            return
        news = ""
        if said != self._said and (self.view.server is not None or self.view.starts_again):
            news = said  # the order that started it gets the answer that it failed
        elif self.view.starts_again and status is not None:
            news = f"the server listens again at {status.address}"
        self._said = said
        self._show(server=status, said=said, starts_again=again)
        if news:
            self.event(news, WARNING)

    def _publish(self, published: Published) -> None:
        self._server.publish(published)
        self._log.publish(published)
        self._stream.add(published)

    def _show_log(self) -> None:
        if (self.view.log, self.view.log_said) != (self._log.path, self._log.said):
            self._show(log=self._log.path, log_said=self._log.said)

    def _show(self, **changes: Any) -> None:
        """Update the view."""
        self.view = dataclasses.replace(self.view, **changes)


def _action(applied: Applied) -> Action:
    """Return the action of a script that repeats a request."""
    if isinstance(applied.what, Effect):
        return effect_action(applied.what, applied.at)
    flown = applied.what
    action = Action(applied.at, velocity=list(flown.velocity), yaw_rate=flown.yaw_rate)
    if applied.aborts:
        return dataclasses.replace(action, request="abort_landing", height=HOLD_HERE)
    return action
