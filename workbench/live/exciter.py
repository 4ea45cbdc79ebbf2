"""Flies excitations and injections, at steps that do not depend on the machine's speed.

A drone that has drifted during a round returns to its start, so repeated rounds do not carry it
off. An excitation without enough room is refused; one that leads into an obstacle, or makes the
drone swing or hit something, ends, and the drone hovers.
"""

import bisect
import dataclasses
import math
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.live.alarms import hit_speed
from workbench.scenario.axes import AXES, Axis
from workbench.scenario.excitation import Excitation, Exciting
from workbench.scenario.loads import Load
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Action, Injection, Rates
from workbench.session.injected import Injected
from workbench.session.script import acting_step
from workbench.session.session import Session

SLOWING = 4.0
"""Deceleration that every drone can reach [m/s²]."""
REACTION = 0.5
"""Time before a drone decelerates at that rate, and between checks for obstacles [s]."""
MARGIN = 0.1
"""Distance kept free [m]."""
OVERTILT = math.radians(20.0)
"""Overshoot above `max_tilt`: a step swings past it by less [rad]."""
CALM = 1.0
"""A step has settled after this time [s] …"""
SWING_RATE = 1.0
"""… to tilt rates below this [rad/s], unless the drone swings."""
SEEN = 1.0
"""A swing goes to both sides within this time [s]."""
DIRECTIONS = {"x": ("east", "west"), "y": ("north", "south"), "z": ("up", "down")}
"""Direction along the axis, and against it."""
IN_FLIGHT = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)
"""Modes in which a drone follows commands."""
WATCH_PERIOD = 1 / 32
"""Approximate period of checks of the drone [s]."""
NEAR = 0.1
"""Distance from its start at which a drone counts as back [m] or [rad]."""
STILL = 0.05
"""Speed below which a drone counts as at rest [m/s] or [rad/s]."""
STRAY, STRAY_TIME = 0.5, 0.5
"""Allowed drift between rounds without a rest: this distance, plus this time at the amplitude [m]
or [rad], [s]."""
PATIENCE = 3.0
"""A return that comes no nearer for this long, as in wind, ends [s]."""
TURN_RATE = 1.0
"""Yaw rate per angle during the return [1/s]."""
LOADED_TURN_RATE = 0.5
"""Largest yaw rate during the return from a load [rad/s]."""


class StepPlan:
    """Tells at which steps of a round a command or a load changes, and its new value.

    A round takes the nearest whole number of control periods and begins with a control update, so
    every round looks the same to the law. A chirp changes with every control update.

    Args:
        excitation: the flown excitation.
        rates: rates of the flight.

    Attributes:
        length: length of a round, in steps.
    """

    def __init__(self, excitation: Excitation, rates: Rates) -> None:
        self._once = dataclasses.replace(excitation, repeats=False)
        self._step = rates.physics_step
        control = rates.control_steps
        self.length = control * max(1, round(excitation.round_time / rates.control_period))
        edges = [acting_step(edge, rates) for edge in excitation.edges]
        self._changes = edges or range(0, self.length, control)

    def next_change(self, step: int) -> int:
        """Return the next step after a given one at which the command changes or the round ends."""
        place = bisect.bisect_right(self._changes, step)
        return min(self._changes[place], self.length) if place < len(self._changes) else self.length

    def value(self, step: int) -> float:
        """Return the command or the load at a step of the round, in its unit."""
        return self._once.command(step * self._step)


class ExcitationGuard:
    """Monitors one excitation.

    Args:
        session: the flown session.
        excitation: excitation to be flown, None for an injection, which hardly moves the drone.
    """

    def __init__(self, session: Session, excitation: Excitation | None = None) -> None:
        self._session, self._excitation = session, excitation
        self._time, self._v_WB = session.time, session.state()[10:13]
        self._calm_from = math.inf
        self._rates: deque[tuple[float, float, float]] = deque()

    def check_room(self) -> None:
        """Refuse an excitation that leads into an obstacle.

        Raises:
            WorkbenchError: names the obstacle.
        """
        if self._excitation is None or self._excitation.axis not in DIRECTIONS:
            return
        axis, size = self._excitation.axis, abs(self._excitation.amplitude)
        rates = self._session.scenario.rates
        plan = StepPlan(self._excitation, rates)
        times = range(0, plan.length, rates.control_steps)
        command = np.array([plan.value(step) for step in times])
        place = np.append(0.0, np.cumsum(command) * rates.control_period)
        for sign, where in zip((1.0, -1.0), DIRECTIONS[axis], strict=True):
            if not (sign * command > 0.0).any():
                continue
            needed = float((sign * place).max()) + _stopping_way(size)
            direction = [sign if name == axis else 0.0 for name in AXES[:3]]
            free, what = self._session.free_way(direction, needed)
            if what:
                raise WorkbenchError(
                    f"there is no room: the excitation needs {needed:.1f} m {where}, and {what} is "
                    f"{free:.1f} m away: give it a smaller amplitude, a shorter period or the "
                    "other sign, or fly elsewhere first"
                )

    def step(self) -> None:
        """Record that the command steps now."""
        self._calm_from = self._session.time + CALM
        self._rates.clear()

    def trouble(self) -> str:
        """Return a sentence if the drone has hit something or swings, else ""."""
        session = self._session
        state, now, before = session.state(), session.time, self._v_WB
        duration, self._time, self._v_WB = now - self._time, now, state[10:13]
        hit = hit_speed(session.vehicle, before, self._v_WB, duration)
        if hit:
            return f"the drone has hit something: its velocity changed by {hit:.1f} m/s at once"
        return self._swing(state)

    def obstacle(self) -> str:
        """Return the obstacle that is so close ahead that the drone must stop now, "" for none."""
        v_WB = self._session.state()[10:13]
        speed = float(np.linalg.norm(v_WB))
        if not 0.0 < speed < math.inf:
            return ""
        free, what = self._session.free_way((v_WB / speed).tolist(), _stopping_way(speed))
        return f"{what} is {free:.1f} m ahead" if what else ""

    def _swing(self, state: np.ndarray) -> str:
        """Return how the drone swings, "" if it does not."""
        _, x, y, _ = state[0:4] / np.linalg.norm(state[0:4])
        tilt = math.acos(max(-1.0, 1.0 - 2.0 * (x * x + y * y)))
        if tilt > self._session.get("max_tilt") + OVERTILT:
            return f"the drone oscillates: it tilts by {math.degrees(tilt):.0f}°"
        now = self._session.time
        if now < self._calm_from:
            return ""
        self._rates.append((now, float(state[7]), float(state[8])))
        while self._rates[0][0] < now - SEEN:
            self._rates.popleft()
        _, *rates = zip(*self._rates, strict=True)
        least = max(min(max(rate), -min(rate)) for rate in rates)
        if least < SWING_RATE:
            return ""
        since = now - self._calm_from + CALM
        return (
            f"the drone oscillates: {math.degrees(least):.0f}°/s to both sides {since:.1f} s after "
            "the step"
        )


def _stopping_way(speed: float) -> float:
    """Return the stopping distance of a drone [m]."""
    return REACTION * speed + 0.5 * speed * speed / SLOWING + MARGIN


class SetpointDrive:
    """Turns the value of an excitation into a command along an axis.

    Args:
        session: the flown session.
        axis: axis of the command.
        amplitude: amplitude of the excitation [m/s] or [rad/s].

    Attributes:
        limit: largest allowed amplitude.
        stray: allowed drift between rounds without a rest [m] or [rad].
        turn_rate: largest yaw rate during the return [rad/s].
    """

    def __init__(self, session: Session, axis: Axis, amplitude: float) -> None:
        self._session, self._axis = session, axis
        self.limit = session.get(axis.limit)
        self.stray = STRAY + STRAY_TIME * abs(amplitude)
        self.turn_rate = abs(amplitude)

    def action(self, value: float, duration: float) -> Action:
        """Command a value on the axis and zero on the others, until the next command."""
        numbers = [value if axis == self._axis.name else 0.0 for axis in AXES]
        return Action(velocity=numbers[:3], yaw_rate=numbers[3])

    def left_behind(self, value: float) -> Action | None:
        """Return the action that ends a command still in force when someone else takes over."""
        asked = self._session.snapshot().reference[AXES.index(self._axis.name)]
        return self.action(0.0, 0.0) if value and asked == value else None


class LoadDrive:
    """Turns the value of an excitation into a push or a gust, while the drone holds.

    Args:
        session: the flown session.
        load: the acting load.

    Attributes:
        limit, stray, turn_rate: see `SetpointDrive`.
    """

    stray, turn_rate = STRAY, LOADED_TURN_RATE

    def __init__(self, session: Session, load: Load) -> None:
        self._session, self._load = session, load
        self.limit = parameter_table().find(load.limit).maximum

    def action(self, value: float, duration: float) -> Action:
        """Apply a load of a value for at most a time [s], and command the drone to hold."""
        load = self._load_with(value, duration)
        return dataclasses.replace(load, velocity=[0.0] * 3, yaw_rate=0.0)

    def left_behind(self, value: float) -> Action | None:
        """Return the action that ends the load when someone else takes control."""
        return self._load_with(0.0, 0.0) if value else None

    def _load_with(self, value: float, duration: float) -> Action:
        least = parameter_table().find("push_duration").minimum
        centre = self._session.vehicle.p_BoBcm_B
        return self._load.action(value, max(duration, least), centre)


def drive(session: Session, excitation: Excitation) -> SetpointDrive | LoadDrive:
    """Return the drive that turns values of an excitation into actions."""
    row = excitation.row
    if isinstance(row, Load):
        return LoadDrive(session, row)
    return SetpointDrive(session, row, excitation.amplitude)


class Exciter:
    """Splits a flight at steps where the command of an excitation changes, and commands it there.

    Args:
        session: the flown session.
        operates: tells whether the operator has control; any other pilot ends an excitation.
        did: called with every command that took effect.

    Attributes:
        exciting: the present excitation, None without one.
        ended: why the last one ended early, "" if a pilot ended it.
    """

    def __init__(
        self, session: Session, operates: Callable[[], bool], did: Callable[[Action], None]
    ) -> None:
        self._session, self._operates, self._did = session, operates, did
        rates = session.scenario.rates
        self._step = rates.physics_step
        self._control = rates.control_steps
        self._mode = round(rates.mode_period / self._step)
        self._scripted = [acting_step(action.at, rates) for action in session.scenario.script]
        self._watch = self._control * max(1, round(WATCH_PERIOD / rates.control_period))
        self.exciting: Exciting | None = None
        self.ended = ""
        self._plan: StepPlan | None = None
        self._guard: ExcitationGuard | None = None
        self._drive: SetpointDrive | LoadDrive | None = None
        self._first = self._next = 0
        self._value = 0.0
        self._home = session.snapshot()
        self._nearest, self._nearer_at = math.inf, 0

    def check(self, excitation: Excitation) -> None:
        """Check that an excitation can be flown now.

        Raises:
            WorkbenchError: for the first problem.
        """
        excitation.check()
        excitation.check(drive(self._session, excitation).limit)
        if self._session.scenario.figure_eight:
            raise WorkbenchError("the scenario flies its figure of eight: excite another one")
        mode = self._session.snapshot().mode
        if mode not in IN_FLIGHT:
            raise WorkbenchError(f"the drone is {mode.label}: it can be excited once it hovers")
        ExcitationGuard(self._session, excitation).check_room()

    def begin(self, excitation: Excitation) -> float:
        """Fly a checked excitation from the next control update on; return its time [s]."""
        if not self.end():  # one that replaces another returns to where the first one started
            self._home = self._session.snapshot()
        self.ended = ""
        self._plan = StepPlan(excitation, self._session.scenario.rates)
        self._guard = ExcitationGuard(self._session, excitation)
        self._drive = drive(self._session, excitation)
        self._first = self._next = -(-self._now // self._control) * self._control
        self.exciting = Exciting(excitation, self._first * self._step, 1)
        self._act()
        return self.exciting.began

    def end(self) -> bool:
        """Hover in place if an excitation is flown; return whether it was."""
        if self._plan is None:
            return False
        self._give(0.0)
        self.drop()
        return True

    def drop(self) -> None:
        """Forget the excitation without a command."""
        self._plan = self.exciting = None

    def watch(self) -> None:
        """End it if someone else has control, or the drone no longer flies, or misbehaves."""
        if self._plan is None or self._guard is None:
            return
        if self._now % self._watch == 0 and self._operates():
            self._end_in_trouble(self._guard)
            if self._plan is None:
                return
        at_mode = (self._now - 1) % self._mode < self._control  # else the mode is that of before
        if self._operates() and not (at_mode and self._session.snapshot().mode not in IN_FLIGHT):
            return
        assert self._drive
        if end := self._drive.left_behind(self._value):
            self._do(end)
        self.drop()

    def _end_in_trouble(self, guard: ExcitationGuard) -> None:
        """End it for a reason.

        In wind a drone with a commanded velocity of zero still drifts, so near an obstacle it is
        sent back to its start.
        """
        assert self.exciting
        trouble, ahead = guard.trouble(), guard.obstacle()
        if ahead and not trouble and not self.exciting.returning:
            self._do(Action(go_to=list(self._home.p_WB), yaw_rate=0.0))
            self.drop()
            self.ended = f"{ahead}: the drone goes back to where it began"
        elif trouble or ahead:
            self.end()
            self.ended = f"{trouble or ahead}: it hovers where it is"

    def parts(self, steps: int) -> Iterator[int]:
        """Yield numbers of steps to fly one after the other, and act before each part."""
        while steps:
            self._act()
            part = min(steps, self._next_stop() - self._now) if self._plan else steps
            yield part
            steps -= part
            self.watch()

    @property
    def _now(self) -> int:
        """Number of flown steps."""
        return round(self._session.time / self._step)

    def _next_stop(self) -> int:
        """Return the next step with an action, a check, a script's action or a new mode."""
        now, control = self._now, self._control
        watch = (now // self._watch + 1) * self._watch
        changes = -(-now // self._mode) * self._mode  # next; the session stands at control updates
        mode = (changes // control + 1) * control
        script = (step + control for step in self._scripted if step >= now)
        return min(self._next, watch, mode, *script)

    def _act(self) -> None:
        """Give the command that is due, if any."""
        if not self._plan or not self._guard or not self.exciting or self._now < self._next:
            return
        if self.exciting.returning or self._now - self._first >= self._plan.length:
            if self._goes_back(self._guard):
                return
            if not self.exciting.excitation.repeats:
                self.end()
                return
            self._first = self._now
            self.exciting = dataclasses.replace(
                self.exciting,
                began=self._first * self._step,
                round=self.exciting.round + 1,
                from_rest=self.exciting.returning,
                returning=False,
            )
        step = self._now - self._first
        change = self._plan.next_change(step)
        self._give(self._plan.value(step), (change - step) * self._step)
        if self.exciting.excitation.edges:
            self._guard.step()
        self._next = self._first + change

    def _goes_back(self, guard: ExcitationGuard) -> bool:
        """Return to the start of the first round if necessary; tell whether the drone does."""
        assert self.exciting and self._drive
        left, speed = self._left()
        if not self.exciting.returning:
            excitation = self.exciting.excitation
            last = excitation.rests or not excitation.repeats
            stray = NEAR if last else self._drive.stray
            if abs(left) <= stray:
                return False
            self.exciting = dataclasses.replace(self.exciting, returning=True)
            self._nearest, self._nearer_at = math.inf, self._now
            guard.step()
            self._value = 0.0
            if not excitation.row.turns:
                self._do(Action(go_to=list(self._home.p_WB)))
        if abs(left) < self._nearest - 0.1 * NEAR:
            self._nearest, self._nearer_at = abs(left), self._now
        stuck = (self._now - self._nearer_at) * self._step > PATIENCE
        if stuck or (abs(left) < NEAR and speed < STILL):
            return False
        if self.exciting.excitation.row.turns:
            most = self._drive.turn_rate
            yaw_rate = max(-most, min(most, TURN_RATE * left))
            self._do(Action(velocity=[0.0] * 3, yaw_rate=yaw_rate))
            self._value = yaw_rate
        self._next = self._now + self._control * max(1, round(self._mode / self._control))
        return True

    def _left(self) -> tuple[float, float]:
        """Return the distance to the start [m] or [rad], and the speed [m/s] or [rad/s]."""
        assert self.exciting
        now = self._session.snapshot()
        if self.exciting.excitation.row.turns:
            turn = self._home.roll_pitch_yaw[2] - now.roll_pitch_yaw[2]
            return math.remainder(turn, math.tau), abs(now.w_WB[2])
        return math.dist(now.p_WB, self._home.p_WB), math.hypot(*now.v_WB)

    def _give(self, value: float, duration: float = 0.0) -> None:
        """Command a value along the axis of the excitation; a load for a time [s]."""
        assert self._drive
        self._value = value
        self._do(self._drive.action(value, duration))

    def _do(self, action: Action) -> None:
        self._session.act(action)
        self._did(action)


LEAST_PERIODS = 2
"""Least number of periods of an injection for a result."""


class Measurer:
    """Flies an injection until it is over, someone else takes control, or the drone misbehaves.

    Args:
        session: the flown session.
        operates: tells whether the operator has control; any other pilot ends a measurement.
        did: called with every command that took effect.
        tell: called with the measurement after each whole period.

    Attributes:
        ended: why the last one ended early, "" if a pilot ended it.
    """

    def __init__(
        self,
        session: Session,
        operates: Callable[[], bool],
        did: Callable[[Action], None],
        tell: Callable[[Injected], None],
    ) -> None:
        self._session, self._operates, self._did, self._tell = session, operates, did, tell
        rates = session.scenario.rates
        self._step = rates.physics_step
        control = rates.control_steps
        self._watch = control * max(1, round(WATCH_PERIOD / rates.control_period))
        self._guard: ExcitationGuard | None = None
        self._told = 0
        self._home = session.snapshot()
        self.ended = ""

    @property
    def share(self) -> float | None:
        """Share of the measurement that is flown, 0 .. 1; None without one."""
        return self._session.injecting if self._guard is not None else None

    def check(self) -> None:
        """Check that a measurement can be flown now.

        Raises:
            WorkbenchError: says what to do first.
        """
        if self._session.scenario.figure_eight:
            raise WorkbenchError("the scenario flies its figure of eight: measure in another one")
        mode = self._session.snapshot().mode
        if mode not in IN_FLIGHT:
            raise WorkbenchError(f"the drone is {mode.label}: it can be measured once it hovers")

    def begin(self, injection: Injection, *, hold: bool) -> float:
        """Measure from the next control update on, and return the time [s].

        Raises:
            WorkbenchError: if the injection cannot be flown.
        """
        self.end()
        self._home = self._session.snapshot()
        self._do(injection.action(hold=hold))
        self._guard, self._told, self.ended = ExcitationGuard(self._session), 0, ""
        return self._session.time

    def end(self) -> bool:
        """Hover in place if a measurement is flown; return whether it was."""
        if self._guard is None:
            return False
        self.drop()
        self._do(Action(velocity=[0.0] * 3, yaw_rate=0.0, injection=Injection()))
        return True

    def drop(self) -> None:
        """Forget the measurement without a command."""
        self._guard = None

    def parts(self, steps: int) -> Iterator[int]:
        """Yield numbers of steps to fly one after the other, with a check after each part."""
        while steps:
            now = round(self._session.time / self._step)
            part = steps
            if self._guard is not None:
                part = min(steps, (now // self._watch + 1) * self._watch - now)
            yield part
            steps -= part
            self._look()

    def _look(self) -> None:
        """Report new periods, and end a measurement that is over or must end."""
        guard, injected = self._guard, self._session.injected
        if guard is None:
            return
        if injected is None or not self._operates():
            if injected is not None:  # someone else has control
                self._do(Action(injection=Injection()))
            self.drop()
            return
        periods = len(injected.came)
        if periods >= LEAST_PERIODS and periods > self._told:
            self._told = periods
            self._tell(injected)
        trouble, ahead = guard.trouble(), guard.obstacle()
        if trouble:
            self.end()
            self.ended = f"{trouble}: it hovers where it is"
        elif ahead or self._session.injecting == 1.0:
            self.drop()
            home = list(self._home.p_WB)
            self._do(Action(go_to=home, yaw_rate=0.0, injection=Injection()))
            if ahead:
                self.ended = f"{ahead}: the drone goes back to where it began"
        elif self._session.snapshot().mode not in IN_FLIGHT:
            self._do(Action(injection=Injection()))
            self.drop()

    def _do(self, action: Action) -> None:
        self._session.act(action)
        self._did(action)
