"""Inject a signal at a loop point during a flight, to measure the loop."""

from collections.abc import Callable, Iterator

from workbench.common.errors import WorkbenchError
from workbench.live.excitation_guard import IN_FLIGHT, WATCH_PERIOD_S, ExcitationGuard
from workbench.scenario.scenario import Action, Injection
from workbench.session.injected import InjectedSignal
from workbench.session.session import Session

MIN_INJECTION_PERIODS = 2
"""Least number of periods of an injection for a result."""


class Measurer:
    """Flies an injection until it is over, someone else takes control, or the drone misbehaves.

    Args:
        session: the flown session.
        operates: tells whether the operator has control; any other pilot ends a measurement.
        do: lets a command take effect, and records it.
        tell: called with the measurement after each whole period.

    Attributes:
        ended: why the last one ended early, "" if a pilot ended it.
    """

    def __init__(
        self,
        session: Session,
        operates: Callable[[], bool],
        do: Callable[[Action], None],
        tell: Callable[[InjectedSignal], None],
    ) -> None:
        self._session, self._operates, self._do, self._tell = session, operates, do, tell
        rates = session.scenario.rates
        self._step = rates.physics_step
        control = rates.control_steps
        self._watch = control * max(1, round(WATCH_PERIOD_S / rates.control_period))
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
        if periods >= MIN_INJECTION_PERIODS and periods > self._told:
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
