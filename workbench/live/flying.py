"""The loop that flies a session in real time and executes the pilot's orders between its steps."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from multiprocessing.connection import Connection, wait

import numpy as np

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.ipc.send_queue import SendQueue
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult
from workbench.link.backplane import Disconnect
from workbench.link.server.config import ServerConfig
from workbench.live.alarms import Alarms
from workbench.live.announcer import FAILURE_SEVERITY, WARNING_SEVERITY
from workbench.live.exciter import Exciter
from workbench.live.flight_clock import FlightClock
from workbench.live.flying_law import FlyingLaw
from workbench.live.log_keeper import LogKeeper
from workbench.live.measurer import Measurer
from workbench.live.messages import (
    CLOSE_MESSAGE,
    AutopilotView,
    FlightReport,
    FlownSoFar,
    Pace,
    Phase,
    ViewChange,
)
from workbench.live.network import DEFERRED_REPLY, FlightNetwork
from workbench.live.orders import (
    FlightOrder,
    FlyOn,
    GetParameter,
    GetReading,
    KeepLog,
    MeasureLoop,
    NetworkOrder,
    SetSpeed,
    ShowPrediction,
)
from workbench.live.stream import RecordStream
from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import Action, Injection
from workbench.scenario.scenario_check import check_injection
from workbench.session.action_check import checked_action, checked_number
from workbench.session.script import repeat_scenario
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot
from workbench.systems.bridge import Bridge

REPORT_PERIOD_S = 1 / 60
"""Period between reports [s of wall]."""
MAX_FLY_ON_S = 60.0
"""Longest time that is flown at once while paused [s]: orders wait meanwhile."""
MAX_ORDERS_PER_SLICE = 100
"""Limit of orders between two slices; the others wait, so orders cannot stop the flight."""
MAX_LOOP_WAIT_S = 0.5
"""Longest wait before the loop checks whether it should end [s]."""


class FlightLoop:
    """Flies a session until its caller ends it.

    Args:
        session: a session at its start.
        bridge: bridge of the session.
        settings: parameter values that the session was built with beside the scenario's.
        send_queue: takes answers and reports.
        now: returns the wall time [s].
        stream: takes everything that is published.
        watch: whether the controller's file is loaded again whenever it is saved.

    Attributes:
        shown: called with every reported snapshot, repeatedly while paused.
        foresee: called with a predicted path.
    """

    def __init__(
        self,
        session: Session,
        bridge: Bridge,
        settings: Mapping[str, float],
        send_queue: SendQueue,
        now: Callable[[], float],
        stream: RecordStream | None = None,
        watch: bool = False,
    ) -> None:
        self._session, self._settings = session, settings
        self._send_queue, self._now = send_queue, now
        rates = session.scenario.rates
        self._step = rates.control_period  # a session flies whole ones
        self._physics = rates.control_steps
        self._clock = FlightClock(self._step, now())
        log = LogKeeper(session, settings, session.parameters())
        self._stream = stream or RecordStream()
        self._network = FlightNetwork(session, bridge, log, self._stream)
        self._exciter = Exciter(session, lambda: self._network.operates, self._network.act)
        self._measurer = Measurer(
            session,
            lambda: self._network.operates,
            self._network.act,
            lambda injected: send_queue.post(ViewChange({"measured": injected})),
        )
        self._alarms = Alarms(session, lambda said: self._network.event(said, WARNING_SEVERITY))
        self._flying = FlyingLaw(session, self._network, send_queue, now, watch)
        self._shown = self._network.view
        self._broken = self._ended = self._starting = ""
        self._flight = 1
        self._seen = session.snapshot()
        self.shown: Callable[[Snapshot, Pace], None] = lambda snapshot, pace: None
        self.foresee: Callable[[float, np.ndarray], None] = lambda ends, p_WB: None
        self._next_report = now()

    def run(self, connection: Connection, wanted: Callable[[], bool]) -> None:
        """Fly until the order to close, or until the caller is gone.

        Args:
            connection: source of orders.
            wanted: tells whether the caller is still there.
        """
        self.report()
        with closing(self._network):
            while wanted():
                wait([connection, *self._network.connections], self.wait())
                try:
                    messages = list(_received_messages(connection))
                except (EOFError, OSError):
                    return
                requests = [each for each in messages if isinstance(each, WorkerRequest)]
                answers: list[WorkerResult | WorkerRefusal] = []
                for request in requests:
                    try:
                        value = self.do(request)
                    except WorkbenchError as error:
                        answers.append(WorkerRefusal(request.number, str(error)))
                        continue
                    if value is not DEFERRED_REPLY:  # whose answer comes from the network
                        answers.append(WorkerResult(request.number, value))
                if requests:
                    self.report()  # which shows the effect, before the answers
                for answer in answers:
                    self._send_queue.post(answer)
                if CLOSE_MESSAGE in messages:
                    return
                self._network.hear()
                if self._network.take_reset():
                    self._reset()
                    self.report()
                self._watch()
                self.fly()
                if self._network.view is not self._shown:  # also while paused
                    self.report()
                elif self._clock.paused and not self._broken:  # a new viewer sees it, too
                    self.shown(self._seen, self._clock.pace(self._now()))
                for answer in self._network.answers():
                    self._send_queue.post(answer)

    def wait(self) -> float:
        """Return the time until something is due [s]."""
        due = MAX_LOOP_WAIT_S if self._broken else self._clock.wait(self._now())
        return min(due, MAX_LOOP_WAIT_S, self._network.wait_time)

    def fly(self) -> None:
        """Fly the steps that are due, and report if a report is due."""
        steps = 0 if self._broken else self._clock.due(self._now())
        if steps:
            self._fly(steps)
            self._clock.flown(steps, self._now())
            if self._now() >= self._next_report:
                self.report()

    def report(self) -> None:
        """Report the present state."""
        now = self._now()
        self._next_report = max(self._next_report + REPORT_PERIOD_S, now)
        self._shown = self._network.view
        paused = Phase.PAUSED if self._clock.paused else Phase.FLYING
        phase = Phase.BROKEN if self._broken else Phase.STARTING if self._starting else paused
        if not self._broken:  # nothing can be computed of a broken flight
            self._seen = self._session.snapshot()
        snapshot, pace = self._seen, self._clock.pace(now)
        if not self._broken:
            self._alarms.look_at_pace(pace, now)
        self._stream.flush()
        runs_program = self._flying.law.program is not None
        report = FlightReport(
            phase,
            self._broken or self._starting,
            snapshot,
            pace,
            self._shown,
            self._exciter.exciting,
            self._flight,
            self._exciter.ended or self._measurer.ended,
            self._alarms.hit,
            self._measurer.share,
            AutopilotView(self._session.exchange, self._ended) if runs_program else None,
            (*self._alarms.lasting, *self._network.lasting),
            self._session.next_action,
        )
        self._send_queue.show(report)
        if not self._broken:
            self.shown(snapshot, pace)

    @drake_error_sentences("the flight cannot do that")
    def do(self, request: WorkerRequest) -> object:
        """Execute an order at the present step; return its answer, or `DEFERRED_REPLY`.

        Raises:
            WorkbenchError: if it is refused.
        """
        session, order = self._session, request.what
        match order:
            case GetParameter(str(name)):
                return session.get(name)
            case GetReading(str(sensor)):
                return session.reading(sensor)
            case FlightOrder.GET_FLOWN:
                return self._flown()
            case ShowPrediction(float(ends), np.ndarray() as p_WB):
                self.foresee(ends, p_WB)
            case NetworkOrder() | ServerConfig() | KeepLog(str()) | Disconnect(int(), str()):
                answer = self._network.order(request.number, order)
                self._exciter.watch()
                return answer
            case FlightOrder.RESET:
                self._reset()
            case FlightOrder.PAUSE:
                self._clock.pause()
            case SetSpeed(factor):
                self._clock.set_speed(checked_number("speed", factor), self._now())
            case _ if self._broken:
                raise WorkbenchError(f"{self._broken}: reset it first")
            case Excitation() | MeasureLoop() if self._ended:
                raise WorkbenchError(self._ended)
            case Action(request=str(asked)) if self._ended and asked != "stop":
                raise WorkbenchError(self._ended)
            case FlightOrder.RESUME:
                self._clock.resume(self._now())
            case FlyOn(duration):
                self._fly_on(checked_number("duration", duration))
            case FlightOrder.GET_CHECKPOINT:
                return session.checkpoint()
            case Excitation():
                return self._excite(order)
            case MeasureLoop(Injection()):
                return self._measure(order)
            case FlightOrder.STOP_EXCITING:
                self._exciter.end()
                self._measurer.end()
            case Action(controller=str(name)):
                self._take_over(name)
            case Action(flies=False):
                action = checked_action(order)
                session.do(action)
                self._network.did(action)
                if action.set and self._measurer.end():
                    self._measurer.ended = "a parameter was changed: it hovers where it is"
            case Action():
                action = self._network.operator_action(checked_action(order))
                session.do(action)  # a refused order takes control from nobody
                if self._network.operate() or self._exciter.end() or self._measurer.end():
                    session.do(action)  # again, after the hold
                self._network.did(action)
            case unknown:
                raise WorkbenchError(f"{unknown!r:.60} is no order to a flight, see live/orders.py")
        return session.time

    def _watch(self) -> None:
        """Load the law's file again if it was saved; a law that cannot fly changes nothing."""
        if self._broken or not self._flying.edited():
            return
        law = self._flying.law
        try:
            with drake_error_sentences("it cannot take over"):
                self._take_over(law.reference)
        except WorkbenchError as error:
            self._flying.tell(f"{error}; {law.name} flies on as it was", WARNING_SEVERITY)

    def _take_over(self, name_or_path: str) -> None:
        self._flying.take_over(name_or_path)
        self._clock.restart(self._now())  # do not catch up on the time that this took
        self.report()

    def _reset(self) -> None:
        if self._broken:  # a program that does not arm may do so
            self._session.end_program()
        self._session.reset()
        self._flight += 1
        self._exciter.drop()
        self._measurer.drop()
        self._alarms.begin()
        self._exciter.ended = self._measurer.ended = ""
        self._network.begin()
        self._flying.show()
        self._send_queue.post(ViewChange({"values": self._session.parameters()}))
        self._broken = self._ended = ""
        self._clock.restart(self._now())

    def _excite(self, excitation: Excitation) -> float:
        self._exciter.check(excitation)
        self._network.operate()
        self._measurer.end()
        self._measurer.ended = ""
        return self._exciter.begin(excitation)

    def _measure(self, order: MeasureLoop) -> float:
        self._measurer.check()
        check_injection(order.injection, self._session.controller, self._session.scenario.rates)
        self._network.operate()
        self._exciter.end()
        self._exciter.ended = ""
        return self._measurer.begin(order.injection, hold=order.hold)

    def _fly_on(self, duration: float) -> None:
        if not self._clock.paused:
            raise WorkbenchError("the flight runs: pause it first")
        if not 0.0 <= duration <= MAX_FLY_ON_S:
            raise WorkbenchError(
                f"cannot fly on for {duration:g} s at once: give it 0 to {MAX_FLY_ON_S:g} s"
            )
        left = math.floor(duration / self._step + 1e-6)
        while left and not self._broken:
            steps = min(left, self._clock.slice)
            self._fly(steps)
            left -= steps
            if self._now() >= self._next_report:
                self.report()
        if self._broken:
            raise WorkbenchError(self._broken)

    def _fly(self, steps: int) -> None:
        try:
            self._start_program()
            for whole in self._exciter.parts(steps * self._physics):
                for part in self._measurer.parts(whole):
                    self._fly_part(part)
        except WorkbenchError as error:  # an error of Drake, or of an action of the script
            self._broken = str(error)
            self._exciter.drop()
            self._measurer.drop()
            self._network.broke(self._broken)
            self.report()
        self._network.flown()
        if not self._broken:
            self._note_ended()
            self._flying.show()

    def _start_program(self) -> None:
        """Start the program that runs the law, if any, after a reset: that takes long.

        Raises:
            WorkbenchError: if it cannot be started.
        """
        if self._flying.law.program is None or self._session.program:
            return
        self._starting = f"starting the program that runs {self._flying.law.name}"
        self.report()
        try:
            self._session.tick(0.0)
        finally:
            self._starting = ""
        self._clock.restart(self._now())

    def _note_ended(self) -> None:
        """Report once that the program that runs the law has ended; the flight continues."""
        if self._session.ended == self._ended:
            return
        self._ended = self._session.ended
        self._exciter.drop()
        self._measurer.drop()
        self._network.ended(self._ended)
        if self._ended:
            self._flying.tell(self._ended, FAILURE_SEVERITY)
        self.report()

    def _fly_part(self, steps: int) -> None:
        """Fly physics steps without an action between them."""
        excited = self._exciter.exciting is not None or self._measurer.share is not None
        for part in self._alarms.parts(steps):
            before = self._session.state()
            duration = part / self._physics * self._step
            self._session.tick(duration)
            self._alarms.look_for_hit(before[10:13], duration)
            self._alarms.look(excited=excited)

    def _flown(self) -> FlownSoFar:
        done = self._network.done
        again = repeat_scenario(self._session.scenario, self._settings, done, self._session.time)
        return FlownSoFar(self._session.recording(), self._session.samples(), again)


def _received_messages(connection: Connection) -> Iterator[object]:
    """Yield received messages, up to a limit; EOFError if the other side is gone."""
    for _ in range(MAX_ORDERS_PER_SLICE):
        if not connection.poll():
            return
        yield connection.recv()
