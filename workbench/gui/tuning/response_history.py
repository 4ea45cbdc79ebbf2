"""The flown responses to an excitation: the present round and the earlier ones."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from workbench.design.load_metrics import ResponseMetrics
from workbench.gui.tuning.round_trace import RoundTrace
from workbench.gui.tuning.step_part import StepPart, measure_load, measure_step, step_parts
from workbench.gui.units import age_text
from workbench.scenario.axes import CommandAxis
from workbench.scenario.excitation import EDGE_TOLERANCE_S, ActiveExcitation, Excitation
from workbench.scenario.loads import Load

MAX_EARLIER_RESPONSES = 5
"""Number of kept earlier responses."""
MIN_KEPT_RESPONSE_S = 0.1
"""Shortest kept response [s]."""
TraceReader = Callable[[Excitation, float, float], RoundTrace]
"""Returns the signals of an excitation between two simulated times [s]."""
DecayTimeReader = Callable[[], float]
"""Returns the time by which the transient of the chosen step decays with the gains that fly [s]."""


@dataclass(frozen=True)
class ExcitationRound:
    """One round of an excitation.

    Attributes:
        excitation: the flown excitation.
        begun: simulated time of its edge [s].
        gains: gains that fly it.
        again: whether an equal round preceded it without a gap.
        hover: angle of the hover or velocity of the drift before it, see `ActiveExcitation`.
        swings: whether joints swung when it began.
        unsteady: why its steps have no steady state, "" if they may have.
    """

    excitation: Excitation
    begun: float
    gains: Mapping[str, float]
    again: bool = False
    hover: float = 0.0
    swings: bool = False
    unsteady: str = ""

    @property
    def response_name(self) -> str:
        """Name of its response."""
        name = self.excitation.row.response
        before = "the drift" if isinstance(self.excitation.row, CommandAxis) else "hover"
        return f"{name}, from that of {before}" if self.hover else name

    @property
    def end(self) -> float:
        """Simulated time of its end [s]."""
        return self.begun + self.excitation.round_time

    def next_edge(self, time: float) -> float:
        """Return the time of the command's next jump after a time, or of the round's end [s]."""
        edges = (self.begun + edge for edge in self.excitation.edges)
        return min((edge for edge in edges if edge > time + EDGE_TOLERANCE_S), default=self.end)

    @property
    def parts(self) -> tuple[StepPart, ...]:
        """The steps in it."""
        return step_parts(self.excitation, again=self.again)


@dataclass(frozen=True)
class FlownResponse:
    """A flown round.

    Attributes:
        round: the round.
        trace: flown signals.
        numbers: numbers of its first step; None if it has none, or ended early.
    """

    round: ExcitationRound
    trace: RoundTrace
    numbers: ResponseMetrics | None


class ResponseHistory:
    """Divides a flight into responses.

    Args:
        take: returns signals of the flight.
        decay_time: of the step.

    Attributes:
        round: the present or last round; None before the first.
        numbers: numbers of the newest round with a completed first step, None before it; those that
            are withheld replace none that are not.
        measured: the round that they belong to.
        withheld: why those of a newer round are withheld, "" if they are not.
        ghosts: earlier responses, the newest first.
        is_running: whether the newest round is in progress.
    """

    def __init__(self, take: TraceReader, decay_time: DecayTimeReader) -> None:
        self._take = take
        self._decay_time = decay_time
        self.clear()

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self.round: ExcitationRound | None = None
        self.numbers: ResponseMetrics | None = None
        self.measured: ExcitationRound | None = None
        self.withheld = ""
        self._newest: ResponseMetrics | None = None
        self.ghosts: tuple[FlownResponse, ...] = ()
        self.is_running = False
        self._ended = 0.0
        self._changed = False

    def begin(self, exciting: ActiveExcitation, gains: Mapping[str, float]) -> None:
        """Record a round; the same one has no effect unless gains have changed.

        Args:
            exciting: the excitation and its start, in a round.
            gains: gains that fly it now.
        """
        before = self.round
        excitation, begun = exciting.excitation, exciting.began
        if before is not None and before.begun == begun and before.excitation == excitation:
            self._changed = self._changed or gains != before.gains
            return
        self._keep(min(begun, before.end) if before is not None else begun)
        self.round = ExcitationRound(
            excitation,
            begun,
            dict(gains),
            exciting.again,
            exciting.hover,
            exciting.swings,
            exciting.unsteady,
        )
        self.is_running, self._newest, self._changed = True, None, False

    def end(self, now: float) -> None:
        """Record that the excitation has ended, at a simulated time [s]."""
        if self.is_running:
            self.is_running, self._ended = False, now

    def present(self, now: float) -> RoundTrace | None:
        """Return the signals of the newest round until now [s], and measure completed steps."""
        if self.round is None:
            return None
        until = min(now, self.round.end) if self.is_running else min(self._ended, self.round.end)
        trace = self._trace(self.round, until)
        if self._newest is None:
            self._newest = self._measure(self.round, trace)
            if self._newest is not None:
                self._take_numbers(self._newest, self.round)
        return trace

    def age_text(self, now: float, gains: Mapping[str, float]) -> str:
        """Return how old the numbers are; "" for those of the newest round with the present gains.

        Args:
            now: simulated time [s].
            gains: gains that fly now.
        """
        flown, said = self.measured, []
        if flown is not None and flown is not self.round:
            age = max(0.0, now - flown.begun - flown.parts[0].end)
            said.append(f"{age_text(math.ceil(age))} ago")
        if flown is not None and flown.gains != gains:
            said.append("with other gains")
        return ", ".join(said)

    def _take_numbers(self, numbers: ResponseMetrics, flown: ExcitationRound) -> None:
        """Show new numbers, unless they are withheld and the present ones are not."""
        self.withheld = numbers.withheld
        if not numbers.withheld or self.numbers is None or self.numbers.withheld:
            self.numbers, self.measured = numbers, flown

    def _keep(self, end: float) -> None:
        """Make the newest round a ghost."""
        if self.round is None:
            return
        until = end if self.is_running else min(self._ended, self.round.end)
        trace = self._trace(self.round, until)
        if not len(trace) or trace.time[-1] < MIN_KEPT_RESPONSE_S:
            return
        numbers = self._newest or self._measure(self.round, trace)
        kept = FlownResponse(self.round, trace, numbers)
        self.ghosts = (kept, *self.ghosts)[:MAX_EARLIER_RESPONSES]

    def _trace(self, flown: ExcitationRound, until: float) -> RoundTrace:
        """Return the signals of a round until a time [s], from that of the hover or the drift."""
        trace = self._take(flown.excitation, flown.begun, until)
        return replace(trace, response=trace.response - flown.hover) if flown.hover else trace

    def _measure(self, flown: ExcitationRound, trace: RoundTrace) -> ResponseMetrics | None:
        """Return the numbers of a round's first step; the other steps are similar."""
        if not flown.parts:
            return None
        how: Any = {"changed": self._changed, "rests": not flown.swings}
        if isinstance(flown.excitation.row, Load):
            return measure_load(trace, flown.parts[0], **how)
        return measure_step(
            trace, flown.parts[0], decay=self._decay_time(), unsteady=flown.unsteady, **how
        )
