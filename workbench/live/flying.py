"""The loop that flies a session in real time and executes the pilot's orders between its steps."""

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from multiprocessing.connection import Connection, wait

import numpy as np

from workbench.common.errors import WorkbenchError, sentences
from workbench.common.own_file import read_own
from workbench.control.controller import Controller, load_controller, with_estimator
from workbench.ipc.send_queue import SendQueue
from workbench.ipc.worker_process import Answer, Refusal, Request
from workbench.live.alarms import Alarms, hit_speed
from workbench.live.announcer import FAILURE, INFORMATION, WARNING
from workbench.live.exciter import Exciter, Measurer
from workbench.live.log_keeper import LogKeeper
from workbench.live.messages import (
    CLOSE,
    AutopilotView,
    Changed,
    Do,
    Flown,
    Hit,
    Order,
    Pace,
    Phase,
    Report,
    TakenOver,
    Told,
)
from workbench.live.network import NETWORK_ORDERS, Deferred, FlightNetwork
from workbench.live.stream import Stream
from workbench.scenario.excitation import Excitation
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Action, Injection, check_injection, check_scenario
from workbench.session.script import repeated
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot
from workbench.systems.bridge import Bridge

LONGEST_LAG = 0.25
"""Largest lag of the flight behind the wall clock; time beyond it is skipped and never flown [s of
wall].

Other work delays a process by a tenth of a second now and then; the flight catches up on that
within a hundredth.
"""
SLICE = 1 / 128
"""Wall time of one slice; orders are read between slices [s]."""
WINDOW = 1.0
"""Averaging time of the real-time factor [s of wall]."""
SLOWEST, FASTEST = 0.01, 20.0
"""Limits of the speed; few machines keep up beyond the upper one."""
PERIOD = 0.25
"""Period between checks of the controller's file [s of wall]."""
REPORT_PERIOD = 1 / 60
"""Period between reports [s of wall]."""
LONGEST_FLY_ON = 60.0
"""Longest time that is flown at once while paused [s]: orders wait meanwhile."""
MOST_ORDERS = 100
"""Limit of orders between two slices; the others wait, so orders cannot stop the flight."""
ONE_HIT = 1.0
"""Impacts within this time count as one hit [s]."""
LONGEST_WAIT = 0.5
"""Longest wait before the loop checks whether it should end [s]."""


class FlightClock:
    """Tells how many steps to fly now, and whether the flight keeps up.

    A flight that falls behind by more than `LONGEST_LAG` does not catch up: it continues from its
    present time, and `pace` reports it. The class reads no clock itself: every method takes the
    time, so that tests can use any clock.

    Args:
        step: simulated time of a step [s].
        now: wall time [s].
    """

    def __init__(self, step: float, now: float) -> None:
        self._step = step
        self._speed = 1.0
        self._paused = False
        self._given_up = 0.0
        self._worst_lag = 0.0
        self.restart(now)

    @property
    def paused(self) -> bool:
        """Whether no step is due."""
        return self._paused

    @property
    def slice(self) -> int:
        """Number of steps in a slice."""
        return max(1, round(self._speed * SLICE / self._step))

    def pause(self) -> None:
        """Stop making steps due."""
        self._paused = True

    def resume(self, now: float) -> None:
        """Make steps due from now on."""
        if self._paused:
            self._paused = False
            self.restart(now)

    def set_speed(self, speed: float, now: float) -> None:
        """Set the number of simulated seconds per second from now on."""
        self._speed = speed
        self.restart(now)

    def restart(self, now: float) -> None:
        """Count as neither early nor late now."""
        self._origin = now
        self._flown = 0
        self._last_given_up = -math.inf
        self._marks: deque[tuple[float, int]] = deque([(now, 0)])

    def due(self, now: float) -> int:
        """Return how many steps to fly at once: none, or a slice."""
        if self._paused:
            return 0
        lag = self._lag(now)
        # a slow flight of long steps is behind by more until its next slice is due
        longest = max(LONGEST_LAG, 2.0 * self.slice * self._step / self._speed)
        if lag > longest:
            self._given_up += lag - longest
            self._last_given_up = now
            self._origin += lag - longest
        self._worst_lag = max(self._worst_lag, lag)
        behind = math.floor(self._lag(now) * self._speed / self._step + 1e-6)
        return self.slice if behind >= self.slice else 0

    def flown(self, steps: int, now: float) -> None:
        """Record the flown steps."""
        self._flown += steps
        self._marks.append((now, self._flown))
        while now - self._marks[1][0] >= WINDOW:
            self._marks.popleft()

    def wait(self, now: float) -> float:
        """Return the time until the next slice is due [s], infinite while paused."""
        if self._paused:
            return math.inf
        return max(0.0, self.slice * self._step / self._speed - self._lag(now))

    def pace(self, now: float) -> Pace:
        """Return how well the flight keeps up; the lag is the largest since the last call."""
        began, flown = self._marks[0]
        wall = now - began
        achieved = (self._flown - flown) * self._step / wall if wall > 0.0 else self._speed
        worst, self._worst_lag = self._worst_lag, 0.0
        return Pace(
            asked=self._speed,
            achieved=0.0 if self._paused else achieved,
            lag=worst,
            given_up=self._given_up,
            slow=not self._paused and now - self._last_given_up < WINDOW,
        )

    def _lag(self, now: float) -> float:
        """Return the lag of the flight in wall time [s]."""
        return now - self._origin - self._flown * self._step / self._speed


class LawFile:
    """Tells when a controller's file was saved with a different text.

    It polls the file: editors write in place, or replace the file.

    Args:
        law: the flying law.
        now: wall time [s].
    """

    def __init__(self, law: Controller, now: float) -> None:
        self._path, self._text = law.file, law.text
        self._state = self._look()
        self._due = now

    def edited(self, now: float) -> bool:
        """Return whether there is a new text that was not reported before."""
        if now < self._due:
            return False
        self._due = now + PERIOD
        state = self._look()
        if state in (None, self._state):  # briefly absent, as with some editors
            return False
        self._state = state
        try:
            text = read_own(self._path, "controller")
        except WorkbenchError:
            return True  # the loader reports what is wrong
        changed, self._text = text != self._text, text
        return changed and bool(text)  # an empty file is about to be written

    def _look(self) -> tuple[int, int, int] | None:
        try:
            state = self._path.stat()
        except OSError:
            return None
        return state.st_mtime_ns, state.st_size, state.st_ino


class Flying:
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
        stream: Stream | None = None,
        watch: bool = False,
    ) -> None:
        self._session = session
        self._settings = settings
        self._send_queue = send_queue
        self._now = now
        rates = session.scenario.rates
        self._step = rates.control_period  # a session flies whole ones
        self._physics = rates.control_steps
        self._clock = FlightClock(self._step, now())
        log = LogKeeper(session, settings, session.parameters())
        self._stream = stream or Stream()
        self._network = FlightNetwork(session, bridge, log, self._stream)
        self._exciter = Exciter(session, lambda: self._network.operates, self._network.did)
        self._measurer = Measurer(
            session,
            lambda: self._network.operates,
            self._network.did,
            lambda injected: send_queue.post(Changed({"measured": injected})),
        )
        self._alarms = Alarms(session, lambda said: self._network.event(said, WARNING))
        self._watches = watch
        self._law = session.controller
        self._law_file = LawFile(self._law, now())
        self._shown = self._network.view
        self._broken = self._ended = self._starting = ""
        self._hit: Hit | None = None
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
                    orders = list(_received(connection))
                except (EOFError, OSError):
                    return
                self.obey([order for order in orders if isinstance(order, Request)])
                if CLOSE in orders:
                    return
                self._network.hear()
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
        due = LONGEST_WAIT if self._broken else self._clock.wait(self._now())
        return min(due, LONGEST_WAIT, self._network.wait_time)

    def fly(self) -> None:
        """Fly the steps that are due, and report if a report is due."""
        steps = 0 if self._broken else self._clock.due(self._now())
        if steps:
            self._fly(steps)
            self._clock.flown(steps, self._now())
            if self._now() >= self._next_report:
                self.report()

    def obey(self, orders: list[Request]) -> None:
        """Execute an order at the present step, and answer after a report that shows its effect."""
        answers: list[Answer | Refusal] = []
        for order in orders:
            try:
                with sentences("the flight cannot do that"):
                    value = self._do(order)
            except WorkbenchError as error:
                answers.append(Refusal(order.number, str(error)))
            else:
                if not isinstance(value, Deferred):
                    answers.append(Answer(order.number, value))
        if orders:
            self.report()
        for answer in answers:
            self._send_queue.post(answer)

    def report(self) -> None:
        """Report the present state."""
        now = self._now()
        self._next_report = max(self._next_report + REPORT_PERIOD, now)
        self._shown = self._network.view
        paused = Phase.PAUSED if self._clock.paused else Phase.FLYING
        phase = Phase.BROKEN if self._broken else Phase.STARTING if self._starting else paused
        if not self._broken:  # nothing can be computed of a broken flight
            self._seen = self._session.snapshot()
        snapshot, pace = self._seen, self._clock.pace(now)
        if not self._broken:
            self._alarms.look_at_pace(pace, now)
        self._stream.flush()
        exciting, flight = self._exciter.exciting, self._flight
        ended, hit = self._exciter.ended or self._measurer.ended, self._hit
        report = Report(
            phase,
            self._broken or self._starting,
            snapshot,
            pace,
            self._shown,
            exciting,
            flight,
            ended,
            hit,
            self._measurer.share,
            self._autopilot(),
        )
        self._send_queue.show(report)
        if not self._broken:
            self.shown(snapshot, pace)

    def _do(self, order: Request) -> object:
        """Execute an order, and return its answer."""
        match order.what:
            case Order(Do.GET, str(name)):
                return self._session.get(name)
            case Order(Do.READ, str(sensor)):
                return self._session.reading(sensor)
            case Order(Do.GET_FLOWN):
                return self._flown()
            case Order(Do.FORESEE, (float(ends), np.ndarray() as p_WB)):
                self.foresee(ends, p_WB)
            case Order(what, value) if what in NETWORK_ORDERS:
                answer = self._network.order(order.number, what, value)
                self._exciter.watch()
                return answer
            case Order(Do.RESET):
                self._reset()
            case Order(Do.PAUSE):
                self._clock.pause()
            case Order(Do.SET_SPEED, float(factor)):
                self._set_speed(factor)
            case _ if self._broken:
                raise WorkbenchError(f"{self._broken}: reset it first")
            case Action(request=str(asked)) if self._ended and asked != "stop":
                raise WorkbenchError(self._ended)
            case Order(Do.EXCITE | Do.MEASURE) if self._ended:
                raise WorkbenchError(self._ended)
            case Order(Do.RESUME):
                self._clock.resume(self._now())
            case Order(Do.FLY_ON, float(duration)):
                self._fly_on(duration)
            case Order(Do.GET_CHECKPOINT):
                return self._session.checkpoint()
            case Order(Do.EXCITE, Excitation() as excitation):
                return self._excite(excitation)
            case Order(Do.MEASURE, (Injection() as injection, bool(hold))):
                return self._measure(injection, hold)
            case Order(Do.STOP_EXCITING):
                self._exciter.end()
                self._measurer.end()
            case Action(controller=str(name)):
                self._take_over(name)
            case Action(flies=False) as action:
                self._session.act(action)
                self._network.did(action)
                if action.set and self._measurer.end():
                    self._measurer.ended = "a parameter was changed: it hovers where it is"
            case Action() as asked:
                action = self._network.in_landing(asked)
                self._session.act(action)  # a refused order takes control from nobody
                if self._network.operate() or self._exciter.end() or self._measurer.end():
                    self._session.act(action)  # again, after the hold
                self._network.did(action)
            case unknown:
                raise AssertionError(unknown)
        return self._session.time

    def _watch(self) -> None:
        """Load the law's file again if it was saved; a law that cannot fly changes nothing."""
        law = self._law
        if not self._watches or law.shipped or self._broken:
            return
        if not self._law_file.edited(self._now()):
            return
        try:
            with sentences("it cannot take over"):
                self._take_over(law.reference)
        except WorkbenchError as error:
            self._tell(f"{error}; {law.name} flies on as it was", WARNING)

    def _take_over(self, name_or_path: str) -> None:
        """Switch to another law from now on."""
        estimator = self._session.controller.estimator
        law = with_estimator(load_controller(name_or_path), estimator)
        # a script that sets missing parameters would break the flight later, or after a reset
        check_scenario(replace(self._session.flown_scenario, controller=name_or_path))
        action = Action(controller=name_or_path)
        self._session.act(action)
        # with all gains: another machine that repeats the log may not have the gain file
        gains = {row.name: self._session.get(row.name) for row in law.parameters}
        self._network.did(replace(action, set=gains))
        if law is self._law:
            self._tell(f"{law.name} flies already, with the same text")
        self._show_law()
        self._clock.restart(self._now())  # do not catch up on the time that this took
        self.report()

    def _show_law(self) -> None:
        """Announce a new law: of an edit, of the script, or of a reset."""
        law, session = self._session.controller, self._session
        if law is self._law:
            return
        same_rows = parameter_table(law).rows == parameter_table(self._law).rows
        self._law, self._law_file = law, LawFile(law, self._now())
        flown = session.flown_scenario
        values = session.parameters()
        self._send_queue.post(TakenOver(law, values, flown.controller, flown.vehicle.gains))
        self._tell(f"{law.name} has taken over at {session.time:.2f} s")
        self._network.taken_over(same_rows)

    def _tell(self, said: str, severity: int = INFORMATION) -> None:
        """Report an event to the caller and to all clients."""
        self._send_queue.post(Told(said))
        self._network.event(said, severity)

    def _reset(self) -> None:
        if self._broken:  # a program that does not arm may do so
            self._session.end_program()
        self._session.reset()
        self._flight += 1
        self._exciter.drop()
        self._measurer.drop()
        self._alarms.begin()
        self._exciter.ended, self._measurer.ended, self._hit = "", "", None
        self._network.begin()
        self._show_law()
        self._broken = self._ended = ""
        self._clock.restart(self._now())

    def _excite(self, excitation: Excitation) -> float:
        self._exciter.check(excitation)
        self._network.operate()
        self._measurer.end()
        self._measurer.ended = ""
        return self._exciter.begin(excitation)

    def _measure(self, injection: Injection, hold: bool) -> float:
        self._measurer.check()
        check_injection(injection, self._session.controller, self._session.scenario.rates)
        self._network.operate()
        self._exciter.end()
        self._exciter.ended = ""
        return self._measurer.begin(injection, hold=hold)

    def _set_speed(self, factor: float) -> None:
        if not SLOWEST <= factor <= FASTEST:
            raise WorkbenchError(
                f"the speed is {factor:g}: give it one from {SLOWEST:g} to {FASTEST:g}"
            )
        self._clock.set_speed(factor, self._now())

    def _fly_on(self, duration: float) -> None:
        if not self._clock.paused:
            raise WorkbenchError("the flight runs: pause it first")
        if not 0.0 <= duration <= LONGEST_FLY_ON:
            raise WorkbenchError(
                f"cannot fly on for {duration:g} s at once: give it 0 to {LONGEST_FLY_ON:g} s"
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
            self._show_law()

    def _start_program(self) -> None:
        """Start the program that runs the law, if any, after a reset: that takes long.

        Raises:
            WorkbenchError: if it cannot be started.
        """
        if self._law.program is None or self._session.program:
            return
        self._starting = f"starting the program that runs {self._law.name}"
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
            self._tell(self._ended, FAILURE)
        self.report()

    def _autopilot(self) -> AutopilotView | None:
        if self._law.program is None:
            return None
        return AutopilotView(self._session.exchange, self._ended)

    def _fly_part(self, steps: int) -> None:
        """Fly physics steps without an action between them."""
        excited = self._exciter.exciting is not None or self._measurer.share is not None
        for part in self._alarms.parts(steps):
            before = self._session.state()
            duration = part / self._physics * self._step
            self._session.tick(duration)
            self._look_for_hit(before[10:13], duration)
            self._alarms.look(excited=excited)

    def _look_for_hit(self, before: np.ndarray, duration: float) -> None:
        """Record a hard hit within a flown part."""
        after = self._session.state()[10:13]
        speed = hit_speed(self._session.vehicle, before, after, duration)
        again = self._hit is not None and self._session.time - self._hit.time < ONE_HIT
        if speed and not again:
            self._hit = Hit(self._session.time, speed)

    def _flown(self) -> Flown:
        done = self._network.done
        again = repeated(self._session.scenario, self._settings, done, self._session.time)
        return Flown(self._session.recording(), self._session.samples(), again)


def _received(connection: Connection) -> Iterator[object]:
    """Yield received messages, up to a limit; EOFError if the other side is gone."""
    for _ in range(MOST_ORDERS):
        if not connection.poll():
            return
        yield connection.recv()
