"""Flies excitations: commands of the operator's, at whole steps that no pace moves.

A drone that has strayed during a round goes back to where it began, so that no excitation wanders
off. One that has no room is refused; one that leads into an obstacle, or makes the drone swing or
hit something, ends, and the drone hovers.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.live.excitation_guard import ExcitationGuard
from workbench.live.step_plan import StepPlan
from workbench.scenario.axes import AXES, find_axis
from workbench.scenario.excitation import Excitation, Exciting
from workbench.scenario.scenario import Action
from workbench.session.session import Session

IN_FLIGHT = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)
"""Modes in which a drone flies as it is told."""
"""Parameters that limit the amplitudes."""
WATCH_PERIOD = 1 / 32
"""About so often the drone is watched [s]."""
NEAR = 0.1
"""A drone this near to where it began is back [m] or [rad]."""
STILL = 0.05
"""A drone slower than this stands [m/s] or [rad/s]."""
STRAY, STRAY_TIME = 0.5, 0.5
"""Between rounds without a rest a drone may stray by so much, and by this time at the amplitude
[m] or [rad], [s]."""
PATIENCE = 3.0
"""A way back that comes no nearer for so long, as in wind, is over [s]."""
TURN_RATE = 1.0
"""Yaw rate per angle on the way back [1/s]."""


class Exciter:
    """Cuts what is flown where a command of an excitation changes, and gives the command there.

    Args:
        session: that is flown.
        operates: tells whether the operator is who flies; who else does ends an excitation.
        did: told of every command that came into force.

    Attributes:
        exciting: what is flown, None while nothing is.
        ended: why the last one ended before it was over, "" where nobody but a pilot ended it.
    """

    def __init__(
        self, session: Session, operates: Callable[[], bool], did: Callable[[Action], None]
    ) -> None:
        self._session, self._operates, self._did = session, operates, did
        rates = session.scenario.rates
        self._step = rates.physics_step
        self._control = round(rates.control_period / self._step)
        self._mode = round(rates.mode_period / self._step)
        self._scripted = [
            math.ceil(action.at / self._step - 1e-6) for action in session.scenario.script
        ]
        self._watch = self._control * max(1, round(WATCH_PERIOD / rates.control_period))
        self.exciting: Exciting | None = None
        self.ended = ""
        self._plan: StepPlan | None = None
        self._guard: ExcitationGuard | None = None
        self._first = self._next = 0
        self._value = 0.0
        self._home = session.snapshot()
        self._nearest, self._nearer_at = math.inf, 0

    def check(self, excitation: Excitation) -> None:
        """Refuse what cannot be flown now.

        Raises:
            WorkbenchError: for the first thing that is wrong.
        """
        excitation.check()
        excitation.check(self._session.get(find_axis(excitation.axis).limit))
        if self._session.scenario.figure_eight:
            raise WorkbenchError("the scenario flies its figure of eight: excite another one")
        mode = self._session.snapshot().mode
        if mode not in IN_FLIGHT:
            raise WorkbenchError(f"the drone is {mode.label}: it can be excited once it hovers")
        ExcitationGuard(self._session, excitation).check_room()

    def begin(self, excitation: Excitation) -> float:
        """Fly what was checked, from the next control update on; return its time [s]."""
        if not self.end():  # another one in its place goes back to where the first one began
            self._home = self._session.snapshot()
        self.ended = ""
        self._plan = StepPlan(excitation, self._session.scenario.rates)
        self._guard = ExcitationGuard(self._session, excitation)
        self._first = self._next = -(-self._now // self._control) * self._control
        self.exciting = Exciting(excitation, self._first * self._step, 1)
        self._act()
        return self.exciting.began

    def end(self) -> bool:
        """Hover where it is, if anything is flown; return whether it was."""
        if self._plan is None:
            return False
        self._give(0.0)
        self.drop()
        return True

    def drop(self) -> None:
        """Forget what is flown, without a command."""
        self._plan = self.exciting = None

    def watch(self) -> None:
        """End it where somebody else flies, or the drone flies no more, or not as it should."""
        if self._plan is None or self._guard is None:
            return
        if self._now % self._watch == 0 and self._operates():
            self._end_in_trouble(self._guard)
            if self._plan is None:
                return
        at_mode = self._now % self._mode == 1 % self._mode  # the mode is as it was in between
        if self._operates() and not (at_mode and self._session.snapshot().mode not in IN_FLIGHT):
            return
        if self._value and self._is_asked_for():  # who flies now did not ask for anything else
            self._give(0.0)
        self.drop()

    def _end_in_trouble(self, guard: ExcitationGuard) -> None:
        """End it where it must end.

        In wind a drone that is asked for no velocity drifts on, so before an obstacle it is sent
        back to where it began.
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
        """Yield how many steps are to be flown one after the other, and act before each part."""
        while steps:
            self._act()
            part = min(steps, self._next_stop() - self._now) if self._plan else steps
            yield part
            steps -= part
            self.watch()

    @property
    def _now(self) -> int:
        """Steps flown."""
        return round(self._session.time / self._step)

    def _next_stop(self) -> int:
        """Return the next step at which to act, or to watch, also after a script or the mode."""
        now = self._now
        watch = (now // self._watch + 1) * self._watch
        mode = ((now - 1) // self._mode + 1) * self._mode + 1
        script = (step + 1 for step in self._scripted if step >= now)
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
        self._give(self._plan.value(step))
        if self.exciting.excitation.edges:
            self._guard.step()
        self._next = self._first + self._plan.next_change(step)

    def _goes_back(self, guard: ExcitationGuard) -> bool:
        """Go back to where the first round began, if need be; return whether it is on the way."""
        assert self.exciting
        left, speed = self._left()
        if not self.exciting.returning:
            excitation = self.exciting.excitation
            last = excitation.rests or not excitation.repeats
            stray = NEAR if last else STRAY + STRAY_TIME * abs(excitation.amplitude)
            if abs(left) <= stray:
                return False
            self.exciting = dataclasses.replace(self.exciting, returning=True)
            self._nearest, self._nearer_at = math.inf, self._now
            guard.step()
            self._value = 0.0
            if excitation.axis != "yaw":
                self._do(Action(go_to=list(self._home.p_WB)))
        if abs(left) < self._nearest - 0.1 * NEAR:
            self._nearest, self._nearer_at = abs(left), self._now
        stuck = (self._now - self._nearer_at) * self._step > PATIENCE
        if stuck or (abs(left) < NEAR and speed < STILL):
            return False
        if self.exciting.excitation.axis == "yaw":
            most = abs(self.exciting.excitation.amplitude)
            self._give(max(-most, min(most, TURN_RATE * left)))
        self._next = self._now + self._mode
        return True

    def _left(self) -> tuple[float, float]:
        """Return the way to where it began [m] or [rad], and the speed [m/s] or [rad/s]."""
        assert self.exciting
        now = self._session.snapshot()
        if self.exciting.excitation.axis == "yaw":
            turn = self._home.roll_pitch_yaw[2] - now.roll_pitch_yaw[2]
            return math.remainder(turn, math.tau), abs(now.w_WB[2])
        return math.dist(now.p_WB, self._home.p_WB), math.hypot(*now.v_WB)

    def _give(self, value: float) -> None:
        """Command a value on the axis of the excitation, and nothing on the others."""
        assert self.exciting
        numbers = [value if axis == self.exciting.excitation.axis else 0.0 for axis in AXES]
        self._value = value
        self._do(Action(velocity=numbers[:3], yaw_rate=numbers[3]))

    def _do(self, action: Action) -> None:
        self._session.act(action)
        self._did(action)

    def _is_asked_for(self) -> bool:
        """Return whether the drone still does as it was told here."""
        assert self.exciting
        place = AXES.index(self.exciting.excitation.axis)
        return self._session.snapshot().reference[place] == self._value
