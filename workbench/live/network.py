"""A flight's network: its server, its clients and their requests, control, and the log."""

import dataclasses
import time
from multiprocessing.connection import Connection
from typing import Any

from workbench.control.flight_mode import HOLD_HEIGHT_M
from workbench.ipc.worker_process import WorkerRefusal, WorkerResult
from workbench.link import backplane
from workbench.link.authority import SilenceEffect
from workbench.link.backplane import (
    ClientDisconnected,
    Disconnect,
    Published,
    ServedFlight,
    VelocityCommand,
)
from workbench.link.hello import ParameterRow
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    LinkLossStage,
)
from workbench.link.server.config import ServerConfig
from workbench.live.announcer import (
    FAILURE_SEVERITY,
    INFORMATION_SEVERITY,
    RESERVE_PARAMETER,
    WARNING_SEVERITY,
    Announcer,
    disturbance_texts,
)
from workbench.live.client_requests import ClientRequests, effect_action, pilot_action
from workbench.live.log_keeper import LogKeeper
from workbench.live.messages import NetworkView
from workbench.live.orders import KeepLog, NetworkOrder
from workbench.live.server_supervisor import ServerSupervisor
from workbench.live.stream import RecordStream
from workbench.scenario.scenario import Action
from workbench.session.script import acting_step, disturbance_settings
from workbench.session.session import Session
from workbench.systems.bridge import AppliedCommand, Bridge

BROADCAST_PERIOD_S = 1.0
"""Period of broadcasts of who has control [s]."""
MAX_SERVER_RECORDS = 200
"""Limit of the server's records that are handled at once, so that it cannot stop the flight."""
MAX_REQUEST_TURN_S = 0.002
"""Limit of the time for clients between two slices of 1/128 s [s of wall]."""
DEFERRED_REPLY = object()
"""Stands for the answer to an order that follows later."""
OPERATOR_NAME = "operator"
"""Name of the person at the screen, in the log."""


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
        stream: RecordStream,
    ) -> None:
        self._session, self._bridge, self._log = session, bridge, log
        self._stream = stream
        self._requests = ClientRequests(session, bridge, self.act)
        rates = session.scenario.rates
        bridge.scripted = frozenset(
            acting_step(action.at, rates) for action in session.scenario.script
        )
        self._server = ServerSupervisor(self._flight, lambda: session.time)
        bridge.at_once = self._server.publish
        self._announcer = Announcer(session.topics, lambda: session.get(RESERVE_PARAMETER))
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

    def order(
        self, number: int, order: NetworkOrder | ServerConfig | KeepLog | Disconnect
    ) -> object:
        """Execute the operator's order of a number; return the answer, or `DEFERRED_REPLY`.

        Raises:
            WorkbenchError: if it cannot be executed.
        """
        answer: object = self._session.time
        match order:
            case ServerConfig():
                self._server.serve(number, order)
                answer = DEFERRED_REPLY
            case NetworkOrder.STOP_SERVING:
                self._server.stop(number)
                answer = DEFERRED_REPLY
            case KeepLog(path):
                answer = self._log.start(path)
            case NetworkOrder.STOP_LOG:
                answer = self._log.stop()
            case NetworkOrder.TAKE_OVER:
                self.operate()
            case NetworkOrder.GIVE_BACK:
                self._give_back()
            case Disconnect():
                self._server.tell(order)
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
        return self._bridge.authority.state(self._session.time).hand is ControlOwner.OPERATOR

    def operator_action(self, action: Action) -> Action:
        """Return the form in which an operator's action takes effect, see `pilot_action`."""
        if not self.operates:
            self._bridge.moves()  # another pilot's sticks say nothing about the operator's
        return pilot_action(action, self._session, self._bridge)

    def act(self, action: Action, by: str = OPERATOR_NAME) -> None:
        """Let an action take effect now, and record it."""
        self._session.do(action)
        self.did(action, by)

    def did(self, action: Action, by: str = OPERATOR_NAME) -> None:
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
    def lasting(self) -> tuple[str, ...]:
        """What the present warnings say whose cause lasts."""
        return self._announcer.lasting

    @property
    def done(self) -> list[Action]:
        """Actions since the start, at times of control updates."""
        return self._log.done.actions

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        return self._server.wait_time

    def hear(self) -> None:
        """Execute requests of clients for at most `MAX_REQUEST_TURN_S`; the rest waits."""
        end = time.perf_counter() + MAX_REQUEST_TURN_S
        server = self._server.attend()
        try:
            for record in server.received(MAX_SERVER_RECORDS) if server else ():
                match record:
                    case VelocityCommand():
                        self._bridge.command(record, self._session.time)
                    case backplane.ClientRequest():
                        self._server.tell(self._requests.answer(record))
                    case ClientDisconnected(peer):
                        self._requests.gone(peer)
                    case _:
                        self._server.note(record)
                self._tell_refused()
                if time.perf_counter() >= end or not self._server.serves:
                    break
        except EOFError:
            self._server.lost()
        self._watch_server()
        self._log.look()
        self._show_log()

    def take_reset(self) -> bool:
        """Return whether a client has requested to start the flight again; only once."""
        wanted, self._requests.resets = self._requests.resets, False
        return wanted

    def answers(self) -> list[WorkerResult | WorkerRefusal]:
        """Return new answers to deferred orders, once the view shows their effect."""
        answers, self._server.answers = self._server.answers, []
        return answers

    def flown(self) -> None:
        """Publish the results of the steps that were flown."""
        script = self._session.script
        for action in script[self._scripted :]:
            for name, value in {**self._gains_after(action), **self._set_by(action)}.items():
                self._publish(self._announcer.parameter(action.at, name, value))
        self._scripted = len(script)
        for applied in self._bridge.applied():
            self._note(_script_action(applied), applied.by)
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

    def event(self, said: str, severity: int = INFORMATION_SEVERITY) -> None:
        """Announce an event to everyone."""
        self._publish(self._announcer.event(self._session.time, said, severity))

    def begin(self) -> None:
        """Start again with a new flight: it has its own log, if any, and its initial values."""
        script = self._session.scenario.script
        actions = (*self.done, *script)
        changed = {n for each in actions for n in (*self._set_by(each), *self._gains_after(each))}
        self._announcer.begin()
        self._log.begin_anew()
        self._scripted = 0
        self._show_log()
        self._broadcast_due = 0.0
        self._requests.broken = self._requests.ended = ""
        self.event("the flight started again")
        known = {row.name for row in self._session.controller.table}
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
        self.event(said, FAILURE_SEVERITY)

    def close(self) -> None:
        """End the server and the log."""
        self._log.stop()
        self._server.close()

    def _flight(self) -> ServedFlight:
        table = self._session.controller.table
        rows = tuple(
            ParameterRow(row.name, row.unit, row.minimum, row.maximum, row.default, row.help)
            for row in map(table.find, self._session.parameters())
        )
        limits = self._bridge.authority.limits
        return ServedFlight(
            vehicle=self._session.vehicle.name,
            topics=self._session.topics,
            parameters=rows,
            limits=(limits.level, limits.climb, limits.turn),
        )

    def _set_by(self, action: Action) -> dict[str, float]:
        """Return the parameters that an action has set, also by a gust or a push."""
        names = disturbance_settings(action, start=0.0)
        return {**action.set, **{name: self._session.get(name) for name in names}}

    def _gains_after(self, action: Action) -> dict[str, float]:
        """Return the present gains if an action switches to another controller."""
        if action.controller is None:
            return {}
        return {
            row.name: self._session.get(row.name) for row in self._session.controller.parameters
        }

    def _give_back(self) -> None:
        if self._bridge.authority.state(0.0).hand is ControlOwner.OPERATOR:
            self._bridge.authority.begin(self._session.time, "the operator gave control back")
            self._hold()
            self._watch_control()

    def _hold(self) -> None:
        self.act(effect_action(SilenceEffect.HOLD))

    def _note(self, action: Action, by: str) -> None:
        """Record an action, and announce parameters that it sets, and a disturbance."""
        self._log.act(dataclasses.replace(action, end_script=action.end_script or None), by)
        for name, value in self._set_by(action).items():
            self._publish(self._announcer.parameter(action.at, name, value))
        for said in disturbance_texts(action):
            self.event(said)

    def _watch_control(self) -> None:
        """Announce who has control, on change and periodically."""
        now = self._session.time
        state = self._bridge.authority.state(now)
        last = self._control
        changed = last is None or dataclasses.replace(last, age=state.age) != state
        if not changed and now < self._broadcast_due:
            return
        self._control, self._broadcast_due = state, now + BROADCAST_PERIOD_S
        self._server.tell(state)
        self._show(control=state)
        if changed and last is not None:
            quiet = state.stage is LinkLossStage.LIVE
            self.event(state.reason, INFORMATION_SEVERITY if quiet else WARNING_SEVERITY)

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
            self.event(news, WARNING_SEVERITY)

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


def _script_action(applied: AppliedCommand) -> Action:
    """Return the action of a script that repeats a request."""
    if isinstance(applied.what, SilenceEffect):
        return effect_action(applied.what, applied.at)
    flown = applied.what
    action = Action(applied.at, velocity=list(flown.velocity), yaw_rate=flown.yaw_rate)
    if applied.aborts:
        return dataclasses.replace(action, request="abort_landing", height=HOLD_HEIGHT_M)
    return action
