"""A flight's network: its server, who commands, and its log, served between slices."""

import dataclasses
from collections.abc import Callable
from multiprocessing.connection import Connection

from workbench.errors import WorkbenchError
from workbench.link.authority import Effect
from workbench.link.backplane import (
    ControlState,
    Disconnect,
    Flight,
    Hand,
    Published,
    ServerFailed,
    ServerStatus,
    Stage,
)
from workbench.link.server.config import ServerConfig
from workbench.live.announcer import FAILURE, INFORMATION, WARNING, Announcer
from workbench.live.desk import Desk
from workbench.live.log_keeper import LogKeeper
from workbench.live.messages import Answer, Refusal
from workbench.live.network_orders import KeepLog, Network, NetworkOrder, NetworkView, Serve
from workbench.live.serving import Serving
from workbench.scenario import Action
from workbench.session import Session
from workbench.systems.bridge import Applied, Bridge
from workbench.vehicle_parameters import vehicle_parameters

BROADCAST_PERIOD = 1.0
"""Between two broadcasts of who flies [s]."""
OPERATOR = "operator"
"""Who acts at the screen, in the log."""
STANDSTILL = [0.0, 0.0, 0.0]


class Later:
    """Stands for an answer that is given when it is known."""


class NetworkStage:
    """What a flight does for its network between two slices; it never waits for anybody.

    Args:
        session: that is flown.
        bridge: of the session.
        log: keeps the flight's log, where one is wanted.
        answer: sends an answer to the flight's caller.

    Attributes:
        view: of the network, to be shown.
    """

    def __init__(
        self,
        session: Session,
        bridge: Bridge,
        log: LogKeeper,
        answer: Callable[[object], None],
    ) -> None:
        self._session, self._bridge, self._log, self._answer = session, bridge, log, answer
        self._desk = Desk(session, bridge, self.did)
        self._serving: Serving | None = None
        self._starting: int | None = None
        self._announcer = Announcer(session.topics)
        self.view = NetworkView()
        self._control: ControlState | None = None
        self._broadcast_due = 0.0
        self._listen()

    @property
    def connections(self) -> list[Connection]:
        """What to wait on besides the caller."""
        return [self._serving.connection] if self._serving else []

    def order(self, number: int, wanted: NetworkOrder) -> object:
        """Do what the operator wants, and return the answer, or a `Later`.

        Raises:
            WorkbenchError: if it cannot be done.
        """
        match wanted:
            case Serve(config):
                return self._serve(number, config)
            case KeepLog(path):
                answer: object = self._log.start(path)
            case Network.STOP_LOG:
                answer = self._log.stop()
            case Network.STOP_SERVING:
                answer = self._stop_serving("")
            case Network.TAKE_OVER:
                answer = self.operate()
            case Network.GIVE_BACK:
                answer = self._give_back()
            case Disconnect():
                answer = self._offer(wanted)
        self._listen()
        self._show(log=self._log.path)
        return answer

    def operate(self) -> float:
        """Let the operator fly: a client that does loses control, and the drone holds first."""
        hand = self._bridge.authority.state(self._session.time).hand
        self._bridge.authority.take_over(self._session.time)
        if hand is Hand.CLIENT:
            self._hold()
        self._watch_control()
        return self._session.time

    def did(self, action: Action, by: str = OPERATOR) -> None:
        """Take note of an action that came into force now."""
        self._note(dataclasses.replace(action, at=self._session.time), by)

    @property
    def done(self) -> list[Action]:
        """What was done since the start, at times of whole steps."""
        return [action for action, _ in self._log.done]

    def hear(self) -> None:
        """Do what clients ask for."""
        if not self._serving:
            return
        try:
            for record in self._serving.heard():
                self._hear(record)
        except EOFError:
            self._stop_serving(self._serving.cause())
        self._watch_control()

    def flown(self) -> None:
        """Pass on what came of the steps that were flown."""
        for applied in self._bridge.applied():
            self._note(_action(applied), applied.by)
        for sampled in self._session.drain():
            self._log.write(sampled)
            self._offer(sampled.published)
            if (said := self._announcer.mode_said(sampled.published)) is not None:
                self.event(said)
        for refused in self._bridge.refused():
            self._offer(refused)
        self._watch_control()
        if self._log.said:
            self._show(said=self._log.said, log="")

    def event(self, said: str, severity: int = INFORMATION) -> None:
        """Let everybody know what happened."""
        self._publish(self._announcer.event(self._session.time, said, severity))

    def begin(self) -> None:
        """Begin with a new flight: it has a log of its own, if any."""
        self._log.begin_anew()
        self._broadcast_due = 0.0
        self.event("the flight began anew")
        self._watch_control()

    def broke(self, said: str) -> None:
        """Let everybody know that the flight cannot go on."""
        self.flown()
        self.event(said, FAILURE)

    def close(self) -> None:
        """End the server and the log."""
        self._log.stop()
        if self._serving:
            self._serving.close()
            self._serving = None

    def _serve(self, number: int, config: ServerConfig) -> Later:
        if self._serving:
            raise WorkbenchError("the flight is served already: stop its server first")
        config.check()
        rows = tuple(
            (row.name, row.unit, row.minimum, row.maximum, row.default, row.help)
            for row in vehicle_parameters(self._session.vehicle)
        )
        limits = self._bridge.authority.limits
        flight = Flight(
            vehicle=self._session.vehicle.name,
            topics=self._session.topics,
            parameters=rows,
            limits=(limits.level, limits.climb, limits.turn),
        )
        self._serving, self._starting = Serving(config, flight), number
        self._control = None
        self._listen()
        self._watch_control()
        return Later()

    def _hear(self, record: object) -> None:
        """Do one thing that the server says or asks."""
        match record:
            case ServerStatus():
                if self._starting is not None:
                    self._answer(Answer(self._starting, record.address))
                    self._starting = None
                self._show(server=record, said="")
            case ServerFailed(said):
                self._stop_serving(said)
            case _:
                reply = self._desk.answer(record)  # type: ignore[arg-type]
                if reply:
                    self._offer(reply)

    def _stop_serving(self, said: str) -> float:
        """End the server; who commanded through it has lost its connection."""
        if self._serving:
            serving, self._serving = self._serving, None
            serving.close()
            self._bridge.authority.gone(self._bridge.authority.state(0.0).peer)
        if self._starting is not None:
            self._answer(Refusal(self._starting, said or "the server was stopped"))
            self._starting = None
        self._listen()
        self._show(server=None, said=said)
        self._watch_control()
        return self._session.time

    def _give_back(self) -> float:
        if self._bridge.authority.state(0.0).hand is Hand.OPERATOR:
            self._bridge.authority.begin(self._session.time, "the operator gave control back")
            self._hold()
            self._watch_control()
        return self._session.time

    def _hold(self) -> None:
        hold = Action(velocity=STANDSTILL, yaw_rate=0.0)
        self._session.act(hold)
        self.did(hold)

    def _note(self, action: Action, by: str) -> None:
        """Keep an action, and let all know of parameters that it sets."""
        self._log.act(action, by)
        for name, value in action.set.items():
            self._publish(self._announcer.parameter(action.at, name, value))

    def _watch_control(self) -> None:
        """Tell who flies, on change and once in a while."""
        now = self._session.time
        state = self._bridge.authority.state(now)
        last = self._control
        changed = last is None or dataclasses.replace(last, age=state.age) != state
        if not changed and now < self._broadcast_due:
            return
        self._control, self._broadcast_due = state, now + BROADCAST_PERIOD
        self._offer(state)
        self._show(control=state)
        if changed and last is not None:
            quiet = state.stage is Stage.LIVE
            self.event(state.reason, INFORMATION if quiet else WARNING)

    def _publish(self, published: Published) -> None:
        self._offer(published)
        self._log.publish(published)

    def _offer(self, record: object) -> float:
        if self._serving:
            self._serving.offer(record)
        return self._session.time

    def _listen(self) -> None:
        """Let topics be made only where somebody wants them."""
        self._bridge.wanted = self._serving is not None or bool(self._log.path)

    def _show(self, **changes: object) -> None:
        """Let the view show how it goes."""
        self.view = dataclasses.replace(self.view, **changes)  # type: ignore[arg-type]


def _action(applied: Applied) -> Action:
    """Return what a script does to fly the same."""
    if applied.what is Effect.HOLD:
        return Action(applied.at, velocity=STANDSTILL, yaw_rate=0.0)
    if applied.what is Effect.LAND:
        return Action(applied.at, velocity=STANDSTILL, yaw_rate=0.0, request="land")
    return Action(applied.at, velocity=list(applied.what.velocity), yaw_rate=applied.what.yaw_rate)
