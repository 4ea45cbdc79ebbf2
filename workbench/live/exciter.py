"""Flies excitations: commands of the operator's, at whole steps that no pace moves."""

import math
from collections.abc import Callable, Iterator

from workbench.errors import WorkbenchError
from workbench.excitation import AXES, Excitation, Exciting
from workbench.live.step_plan import StepPlan
from workbench.scenario import Action
from workbench.session import Session
from workbench.systems.mode import FlightMode

IN_FLIGHT = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)
"""Modes in which a drone flies as it is told."""
LIMITS = {"x": "max_speed", "y": "max_speed", "z": "max_climb_rate", "yaw": "max_yaw_rate"}
"""Parameters that limit the amplitudes."""


class Exciter:
    """Cuts what is flown where a command of an excitation changes, and gives the command there.

    Args:
        session: that is flown.
        operates: tells whether the operator is who flies; who else does ends an excitation.
        did: told of every command that came into force.

    Attributes:
        exciting: what is flown, None while nothing is.
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
        self.exciting: Exciting | None = None
        self._plan: StepPlan | None = None
        self._first = self._next = 0
        self._value = 0.0

    def check(self, excitation: Excitation) -> None:
        """Refuse what cannot be flown now.

        Raises:
            WorkbenchError: for the first thing that is wrong.
        """
        excitation.check()
        excitation.check(self._session.get(LIMITS[excitation.axis]))
        if self._session.scenario.figure_eight:
            raise WorkbenchError("the scenario flies its figure of eight: excite another one")
        mode = self._session.snapshot().mode
        if mode not in IN_FLIGHT:
            raise WorkbenchError(f"the drone is {mode.label}: it can be excited once it hovers")

    def begin(self, excitation: Excitation) -> float:
        """Fly what was checked, from the next control update on; return its time [s]."""
        self.end()
        self._plan = StepPlan(excitation, self._session.scenario.rates)
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
        """End it where somebody else flies, or the drone flies no more."""
        if self._plan is None:
            return
        at_mode = self._now % self._mode == 1 % self._mode  # the mode is as it was in between
        if self._operates() and not (at_mode and self._session.snapshot().mode not in IN_FLIGHT):
            return
        if self._value and self._is_asked_for():  # who flies now did not ask for anything else
            self._give(0.0)
        self.drop()

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
        """Return the next step at which to act, or to watch: after a script or the mode acted."""
        now = self._now
        mode = ((now - 1) // self._mode + 1) * self._mode + 1
        script = (step + 1 for step in self._scripted if step >= now)
        return min(self._next, mode, *script)

    def _act(self) -> None:
        """Give the command that is due, if any."""
        if self._plan is None or self.exciting is None or self._now < self._next:
            return
        if self._now - self._first >= self._plan.length:
            if not self.exciting.excitation.repeats:
                self.end()
                return
            self._first += self._plan.length
            round_ = self.exciting.round + 1
            began = self._first * self._step
            self.exciting = Exciting(self.exciting.excitation, began, round_)
        step = self._now - self._first
        self._give(self._plan.value(step))
        self._next = self._first + self._plan.next_change(step)

    def _give(self, value: float) -> None:
        """Command a value on the axis of the excitation, and nothing on the others."""
        assert self.exciting
        numbers = [value if axis == self.exciting.excitation.axis else 0.0 for axis in AXES]
        action = Action(velocity=numbers[:3], yaw_rate=numbers[3])
        self._value = value
        self._session.act(action)
        self._did(action)

    def _is_asked_for(self) -> bool:
        """Return whether the drone still does as it was told here."""
        assert self.exciting
        place = AXES.index(self.exciting.excitation.axis)
        return self._session.snapshot().reference[place] == self._value
