"""Flies excitations and injections, at steps that do not depend on the machine's speed.

A drone that has drifted during a round returns to its start, so repeated rounds do not carry it
off. A round whose numbers need a beginning at rest waits for it, for as long as the drone gets
slower. A load that swings lets the drone stand still twice in a swing, so a vehicle with loose
joints is at rest if its largest motion over some time is small.

In wind a step of a command begins at the steady drift, as that of `fly_step`.

An excitation without enough room is refused; one that leads into an obstacle, or makes the drone
swing or hit something, ends, and the drone hovers.
"""

import dataclasses
import math
from collections import deque
from collections.abc import Callable, Iterator

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import HOOKS
from workbench.live.excitation_guard import IN_FLIGHT, WATCH_PERIOD_S, ExcitationGuard, StepPlan
from workbench.live.step_drive import StepDrive
from workbench.scenario.excitation import MAX_SWING_WAIT_S, ActiveExcitation, Excitation
from workbench.scenario.scenario import Action
from workbench.session.drift import MAX_HOVER_S
from workbench.session.script import acting_step
from workbench.session.session import Session

RETURNED_DISTANCE = 0.1
"""Distance from its start at which a drone counts as back [m] or [rad]."""
RETURN_TIMEOUT_S = 3.0
"""A return that comes no nearer, or no slower, for this long, as in wind, ends [s]."""
SWING_WAIT_WINDOW_S = 3.0
"""A vehicle with loose joints is as restless as at most within this time [s]: that is half of its
swing or more if a period takes 18 s or less, as with a load on 80 m."""
MAX_UNDAMPED_WAIT_S, SWING_DECAY_SHARE = 10.0, 0.05
"""A swing that decays by less than this share within this time [s] is not waited for."""
RETURN_YAW_GAIN = 1.0
"""Yaw rate per angle during the return [1/s]."""


class Exciter:
    """Splits a flight at steps where the command of an excitation changes, and commands it there.

    Args:
        session: the flown session.
        operates: tells whether the operator has control; any other pilot ends an excitation.
        do: lets a command take effect, and records it.

    Attributes:
        exciting: the present excitation, None without one.
        ended: why the last one ended early, "" if a pilot ended it.
    """

    def __init__(
        self, session: Session, operates: Callable[[], bool], do: Callable[[Action], None]
    ) -> None:
        self._session, self._operates, self._do = session, operates, do
        rates = session.scenario.rates
        self._step = rates.physics_step
        self._control = rates.control_steps
        self._mode = round(rates.mode_period / self._step)
        self._scripted = [acting_step(action.at, rates) for action in session.scenario.script]
        self._watch = self._control * max(1, round(WATCH_PERIOD_S / rates.control_period))
        self.exciting: ActiveExcitation | None = None
        self.ended = ""
        self._plan: StepPlan | None = None
        self._guard: ExcitationGuard | None = None
        self._drive: StepDrive | None = None
        self._first = self._next = 0
        self._value = 0.0
        self._home = session.snapshot()
        self._nearest, self._nearer_at = math.inf, 0
        self._waits_from = 0
        self._moved: deque[tuple[int, float]] = deque()  # steps, and the unrest at them
        self._calmest, self._calmer_at = math.inf, 0
        self._drift_from: int | None = None

    def check(self, excitation: Excitation) -> None:
        """Check that an excitation can be flown now.

        Raises:
            WorkbenchError: for the first problem.
        """
        excitation.check()
        drive = StepDrive(self._session, excitation)
        excitation.check(drive.limit)
        drive.check_tilt()
        if self._session.scenario.figure_eight:
            raise WorkbenchError("the scenario flies its figure of eight: excite another one")
        mode = self._session.snapshot().mode
        if mode not in IN_FLIGHT:
            raise WorkbenchError(f"the drone is {mode.label}: it can be excited once it hovers")
        ExcitationGuard(self._session, excitation).check_room()

    def begin(self, excitation: Excitation) -> float:
        """Fly a checked excitation from the next control update on; return its time [s].

        If a round of it begins at rest, a drone that moves comes to rest first.
        """
        if not self.end():  # one that replaces another returns to where the first one started
            self._home = self._session.snapshot()
        self.ended = ""
        self._plan = StepPlan(excitation, self._session.scenario.rates)
        self._guard = ExcitationGuard(self._session, excitation)
        self._drive = StepDrive(self._session, excitation)
        self._first = self._next = -(-self._now // self._control) * self._control
        self._drift_from = None
        moves = self._drive.unrest() >= 1.0 or self._drive.drifts
        waits = excitation.rests and (self._is_loose or moves)
        self.exciting = ActiveExcitation(
            excitation,
            self._first * self._step,
            0 if waits else 1,
            hover=self._drive.hover.angle,
            unsteady="" if waits else self._drive.why_unsteady(),
        )
        if waits:
            self._begin_wait()
            self._give(0.0)
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
        assert self.exciting and self._drive
        trouble, ahead = guard.trouble(), guard.obstacle()
        if ahead and not trouble and not self.exciting.returning:
            self._do(dataclasses.replace(self._drive.home(self._home.p_WB), yaw_rate=0.0))
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
        if self.exciting.round == 0:
            if self._drift_from is None and self._comes_to_rest():
                return
            if self._finds_drift(self._guard) or not self._begin_round():
                return
        elif self.exciting.returning or self._now - self._first >= self._plan.length:
            if self._drift_from is None and self._goes_back(self._guard):
                return
            if not self.exciting.excitation.repeats:
                self.end()
                return
            if self._finds_drift(self._guard) or not self._begin_round():
                return
        step = self._now - self._first
        change = self._plan.next_change(step)
        self._give(self._plan.value(step), (change - step) * self._step)
        if self.exciting.excitation.edges:
            self._guard.step()
        self._next = self._first + change

    def _begin_round(self) -> bool:
        """Begin a round, and return True; not if joints swing or the hover tilts too far."""
        assert self.exciting and self._drive
        excitation = self.exciting.excitation
        swings = self._is_loose and excitation.rests and self._unrest() >= 1.0
        if swings and excitation.repeats:
            waited = (self._now - self._waits_from) * self._step
            self.end()
            self.ended = (
                f"the vehicle still swings after {waited:.0f} s: damp its swing, give the step a "
                "larger amplitude, or fly a single one"
            )
            return False
        self._moved.clear()
        self._first = self._now
        if excitation.rests or self.exciting.returning:
            self._drive.begin_round()
            try:
                self._drive.check_tilt()
            except WorkbenchError as too_far:
                self.end()
                self.ended = str(too_far)
                return False
        self.exciting = dataclasses.replace(
            self.exciting,
            hover=self._drive.hover.angle,
            began=self._first * self._step,
            round=self.exciting.round + 1,
            from_rest=self.exciting.returning,
            returning=False,
            waited=None,
            swings=swings,
            drifts=False,
            unsteady=self._drive.why_unsteady(),
        )
        return True

    def _finds_drift(self, guard: ExcitationGuard) -> bool:
        """Tell whether the drone still has to drift steadily in wind before a round, and does."""
        assert self.exciting and self._drive
        if self._drift_from is None:
            if not self._drive.drifts:
                return False
            self._drift_from, self._value = self._now, 0.0
            self.exciting = dataclasses.replace(self.exciting, drifts=True)
            guard.step()
            self._do(self._drive.begin_drift())
        drifted = (self._now - self._drift_from) * self._step
        if self._drive.drifts_steadily() or drifted > MAX_HOVER_S:
            self._drift_from = None
            return False
        self._look_again()
        return True

    def _comes_to_rest(self) -> bool:
        """Tell whether the drone still has to come to rest before the first round, and does."""
        assert self.exciting and self._drive
        unrest = self._unrest()
        if unrest < 1.0 or (
            not self._swing_decays(unrest) if self._is_loose else self._is_stuck(unrest, 1.0)
        ):
            return False
        self._look_again()
        return True

    def _goes_back(self, guard: ExcitationGuard) -> bool:
        """Return to the start of the first round if necessary; tell whether the drone does."""
        assert self.exciting and self._drive
        excitation = self.exciting.excitation
        waits_for_swing = self._is_loose and excitation.rests and excitation.repeats
        unrest = self._unrest() if waits_for_swing else self._drive.unrest()
        left, at_rest = self._left(), unrest < 1.0
        if not self.exciting.returning:
            last = excitation.rests or not excitation.repeats
            stray = RETURNED_DISTANCE if last else self._drive.stray
            if abs(left) <= stray and (at_rest or not excitation.rests):
                return False
            self.exciting = dataclasses.replace(self.exciting, returning=True)
            self._begin_wait()
            guard.step()
            self._value = 0.0
            if not excitation.row.turns:
                self._do(self._drive.home(self._home.p_WB))
        is_back = abs(left) < RETURNED_DISTANCE and at_rest
        is_stuck = self._is_stuck(abs(left), 0.1 * RETURNED_DISTANCE)
        if waits_for_swing and not at_rest and (abs(left) < RETURNED_DISTANCE or is_stuck):
            is_stuck = not self._swing_decays(unrest)
        if is_back or is_stuck:
            return False
        if excitation.row.turns:
            most = self._drive.turn_rate
            yaw_rate = max(-most, min(most, RETURN_YAW_GAIN * left))
            if abs(left) < RETURNED_DISTANCE:  # near enough: it comes to rest
                yaw_rate = 0.0
            self._do(Action(velocity=[0.0] * 3, yaw_rate=yaw_rate))
            self._value = yaw_rate
        self._look_again()
        return True

    @property
    def _is_loose(self) -> bool:
        """Whether joints of what flies swing freely."""
        session = self._session
        hooks_open = bool(session.vehicle.unloaded and session.get(HOOKS))
        return session.vehicle.with_hooks(hooks_open).turned is not None

    def _begin_wait(self) -> None:
        """Begin to wait for rest, or to fly back."""
        self._waits_from = self._nearer_at = self._calmer_at = self._now
        self._nearest = self._calmest = math.inf
        self._moved.clear()

    def _unrest(self) -> float:
        """Return the unrest, of loose joints its largest value lately; they wait to know it."""
        assert self._drive
        now, unrest = self._now, self._drive.unrest()
        if not self._is_loose:
            return unrest
        window = SWING_WAIT_WINDOW_S / self._step
        self._moved.append((now, unrest))
        while len(self._moved) > 1 and self._moved[1][0] <= now - window:
            self._moved.popleft()
        known = now - self._moved[0][0] >= window
        return max(0.0 if known else 1.0, *(each for _, each in self._moved))

    def _swing_decays(self, unrest: float) -> bool:
        """Tell whether a swing is still worth waiting for, and show for how long it was."""
        assert self.exciting
        if unrest < (1.0 - SWING_DECAY_SHARE) * self._calmest:
            self._calmest, self._calmer_at = unrest, self._now
        waited = (self._now - self._waits_from) * self._step
        self.exciting = dataclasses.replace(self.exciting, waited=waited)
        undamped = (self._now - self._calmer_at) * self._step
        return waited < MAX_SWING_WAIT_S and undamped < MAX_UNDAMPED_WAIT_S

    def _look_again(self) -> None:
        """Act again after about a period of the flight mode."""
        self._next = self._now + self._control * max(1, round(self._mode / self._control))

    def _is_stuck(self, left: float, least: float) -> bool:
        """Tell whether a distance or a speed has not fallen by some least amount for long."""
        if left < self._nearest - least:
            self._nearest, self._nearer_at = left, self._now
        return (self._now - self._nearer_at) * self._step > RETURN_TIMEOUT_S

    def _left(self) -> float:
        """Return the distance to the start [m] or [rad]."""
        assert self.exciting
        now = self._session.snapshot()
        if self.exciting.excitation.row.turns:
            turn = self._home.roll_pitch_yaw[2] - now.roll_pitch_yaw[2]
            return math.remainder(turn, math.tau)
        return math.dist(now.p_WB, self._home.p_WB)

    def _give(self, value: float, duration: float = 0.0) -> None:
        """Command a value along the axis of the excitation; a load for a time [s]."""
        assert self._drive
        self._value = value
        self._do(self._drive.action(value, duration))
