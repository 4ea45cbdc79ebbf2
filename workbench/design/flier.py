"""Who flies a flight: Drake's diagram, or compiled code that gives the same flight within 1e-9.

Compiled code flies a hundred times as fast, but loading it takes the time of a short flight on the
diagram, and compiling it that of a long one.
"""

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from workbench.common.errors import unknown_name
from workbench.common.optional_package import has_package, install_command

if TYPE_CHECKING:
    from workbench.design.scripted_flight import ScriptedFlight
    from workbench.scenario.scenario import Action, Scenario
    from workbench.session.recording import Recording
    from workbench.session.session import Session
    from workbench.setup import Setup

AUTO, DIAGRAM, COMPILED = FLY_ON_CHOICES = ("auto", "diagram", "compiled")
FLY_ON_VARIABLE = "WORKBENCH_FLY_ON"
"""Environment variable with one of `FLY_ON_CHOICES`; processes that a command starts have it,
too."""
MAX_UPDATES_LOADING = 1500
"""Control updates that the diagram flies while compiled code is loaded."""
MAX_UPDATES_COMPILING = 30_000
"""Control updates that the diagram flies while the code is compiled: in 15 s, at 1500 to 3000 a
second."""


def choose_engine(
    wish: str, why_not: Callable[[], str], updates: int, is_kept: Callable[[], bool]
) -> tuple[str, str]:
    """Return who flies, `DIAGRAM` or `COMPILED`, and why, as the end of a sentence.

    Args:
        wish: one of `FLY_ON_CHOICES`.
        why_not: asked why the flight cannot be compiled; "" if it can.
        updates: of control, that are to be flown.
        is_kept: asked whether there is machine code of it.
    """
    if wish == DIAGRAM:
        return DIAGRAM, "as is asked for"
    if wish == AUTO and updates <= MAX_UPDATES_LOADING:
        return DIAGRAM, f"for {updates} control updates no compiled code is loaded"
    if reason := why_not():
        return DIAGRAM, reason
    if wish == COMPILED:
        return COMPILED, "as is asked for"
    if is_kept():
        return COMPILED, f"which is quicker for {updates} control updates"
    if updates > MAX_UPDATES_COMPILING:
        return COMPILED, f"for {updates} control updates it is worth to compile it"
    return DIAGRAM, f"for {updates} control updates it is not worth to compile it"


@dataclass(frozen=True)
class FlierFlight:
    """A flight.

    Attributes:
        recording: of it.
        exchange: statistics of the exchange with a program that ran the law, see
            `Session.exchange`.
        ended: why that program ended in flight, else "".
    """

    recording: "Recording"
    exchange: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    ended: str = field(default="", kw_only=True)


class Flier:
    """Flies a scenario, and others that differ in script and duration alone.

    Args:
        scenario: what to fly, or its setup.
        settings: parameter values that override those of the scenario's gains.
        fly_on: one of `FLY_ON_CHOICES`; "" for that of the environment variable `FLY_ON_VARIABLE`,
            or `AUTO`.
        flights: how many like this are to be flown, so that code for all is compiled where that is
            worth it.

    Raises:
        WorkbenchError: if there is no such choice, or the scenario cannot be built.
    """

    def __init__(
        self,
        scenario: "Scenario | Setup",
        settings: Mapping[str, float] | None = None,
        fly_on: str = "",
        flights: int = 1,
    ) -> None:
        from workbench.setup import make_setup

        self._setup = make_setup(scenario, settings)
        self._wish = fly_on or os.environ.get(FLY_ON_VARIABLE, "") or AUTO
        if self._wish not in FLY_ON_CHOICES:
            raise unknown_name("choice of who flies", self._wish, FLY_ON_CHOICES)
        self._flights = flights
        self._session: Session | None = None
        self._begins: Setup | None = None  # at whose start the session is
        self._scripted: ScriptedFlight | None = None
        self._choose()

    def follow(self, script: "Sequence[Action]", duration: float) -> None:
        """Let the next flight have another script and duration [s]."""
        now = self._setup.scenario
        flight = dataclasses.replace(now, script=list(script), duration=duration)
        self._setup = self._setup.with_scenario(flight)
        self._choose()

    def get(self, name: str) -> float:
        """Return the value of a live parameter at the start."""
        if self._flies == COMPILED and self._scripted:
            return self._scripted.values[name]
        return self._begun().get(name)

    @property
    def session(self) -> "Session":
        """What flies on the diagram: as it flew last, or at the start if it has not flown."""
        return self._session or self._begun()

    def fly(
        self, progress: Callable[[float], None] | None = None, *, programs: bool = True
    ) -> FlierFlight:
        """Fly.

        Args:
            progress: called with the flown share, 0 .. 1.
            programs: whether a program may run the law, see `Session.programs`.

        Raises:
            FlightBrokenError: if the simulation cannot go on; `session` has what was flown.
        """
        if self._flies == COMPILED and self._scripted:
            flight = self._setup.scenario
            recording, why_not = self._scripted.fly(flight.script, flight.duration, progress)
            if recording:
                return FlierFlight(recording)
            self._tell(f"it flies again on the diagram: {why_not}")
        session, self._begins = self._begun(), None
        with session.programs() if programs else nullcontext():
            session.run(progress)
        return FlierFlight(session.recording(), exchange=session.exchange, ended=session.ended)

    def _begun(self) -> "Session":
        """Return a session at the start of the flight."""
        if self._session is None:
            from workbench.session.session import Session  # loads Drake

            self._session = Session(self._setup)
        elif self._begins is not self._setup:
            flight = self._setup.scenario
            self._session.follow(flight.script, flight.duration)
        self._begins = self._setup
        return self._session

    def _choose(self) -> None:
        """Decide who flies next."""
        scenario = self._setup.scenario
        updates = math.floor(scenario.duration / scenario.rates.control_period + 1e-6)
        self._flies, why = choose_engine(
            self._wish, self._why_not, self._flights * updates, lambda: self._ready.is_kept
        )
        who = "compiled code" if self._flies == COMPILED else "the diagram"
        self._tell(f"{who} flies: {why}", self._wish not in (AUTO, self._flies))

    def _why_not(self) -> str:
        """Return why the flight cannot be compiled."""
        if not has_package("numba"):
            return f"numba is not installed: `{install_command('numba')}` brings it"
        from workbench.design import scripted_flight

        if reason := scripted_flight.why_no_script(self._setup):
            return reason
        if self._scripted is None:
            self._scripted = scripted_flight.ScriptedFlight(self._setup)
        return self._scripted.why_not

    @property
    def _ready(self) -> "ScriptedFlight":
        assert self._scripted
        return self._scripted

    def _tell(self, what: str, loud: bool = False) -> None:
        """Tell those who ask for it; or everybody, as a wish is not fulfilled."""
        import logging  # this module is loaded for the options of commands

        logging.getLogger("workbench.flier").log(logging.INFO if loud else logging.DEBUG, what)
