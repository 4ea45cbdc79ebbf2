"""Measures a loop of a live flight: injects, watches the drone, and tells each period's result."""

from collections.abc import Callable, Iterator

from workbench.common.errors import WorkbenchError
from workbench.live.exciter import IN_FLIGHT, WATCH_PERIOD, ExcitationGuard
from workbench.scenario.scenario import Action, Injection
from workbench.session.injected import Injected
from workbench.session.session import Session

LEAST = 2
"""Periods from which on there is a result."""


class Measurer:
    """Flies an injection until it is over, somebody else flies, or the drone does not as it should.

    Args:
        session: that is flown.
        operates: tells whether the operator is who flies; who else does ends a measurement.
        did: told of every command that came into force.
        tell: told of what was measured, after each whole period.

    Attributes:
        ended: why the last one ended before it was over, "" where a pilot ended it.
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
        control = round(rates.control_period / self._step)
        self._watch = control * max(1, round(WATCH_PERIOD / rates.control_period))
        self._guard: ExcitationGuard | None = None
        self._told = 0
        self._home = session.snapshot()
        self.ended = ""

    @property
    def share(self) -> float | None:
        """How much of a measurement is flown, 0 .. 1; None while none is."""
        return self._session.injecting if self._guard is not None else None

    def check(self) -> None:
        """Refuse what cannot be measured now.

        Raises:
            WorkbenchError: with what to do first.
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
        """Hover where it is, if anything is measured; return whether it was."""
        if self._guard is None:
            return False
        self.drop()
        self._do(Action(velocity=[0.0] * 3, yaw_rate=0.0, injection=Injection()))
        return True

    def drop(self) -> None:
        """Forget what is measured, without a command."""
        self._guard = None

    def parts(self, steps: int) -> Iterator[int]:
        """Yield how many steps are to be flown one after the other, and look after each part."""
        while steps:
            now = round(self._session.time / self._step)
            part = steps
            if self._guard is not None:
                part = min(steps, (now // self._watch + 1) * self._watch - now)
            yield part
            steps -= part
            self._look()

    def _look(self) -> None:
        """Tell what is new, and end what is over, or must end."""
        guard, injected = self._guard, self._session.injected
        if guard is None:
            return
        if injected is None or not self._operates():
            if injected is not None:  # somebody else flies
                self._do(Action(injection=Injection()))
            self.drop()
            return
        periods = len(injected.came)
        if periods >= LEAST and periods > self._told:
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
