"""The responses that were flown: the present one, and the last few."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from workbench.analysis.replies import StepNumbers
from workbench.gui.tuning.rounds import StepPart, step_parts
from workbench.gui.tuning.step_measure import measure_step
from workbench.gui.tuning.trace import Trace
from workbench.scenario.excitation import LATE, Excitation, Exciting

GHOSTS = 5
"""Responses that are kept besides the present one."""
SHORTEST = 0.1
"""Of a response that is kept [s]."""

Take = Callable[[Excitation, float, float], Trace]
"""Takes a trace of an excitation, from one simulated time to another [s]."""


@dataclass(frozen=True)
class Round:
    """One round of an excitation that is flown.

    Attributes:
        excitation: what is flown.
        begun: simulated time of its edge [s].
        gains: that fly it.
        again: whether a round of the same went before it without a gap.
    """

    excitation: Excitation
    begun: float
    gains: Mapping[str, float]
    again: bool = False

    @property
    def end(self) -> float:
        """Simulated time at which it is over [s]."""
        return self.begun + self.excitation.round_time

    def next_edge(self, time: float) -> float:
        """Return when the command jumps next after a simulated time, or the round ends [s]."""
        edges = (self.begun + edge for edge in self.excitation.edges)
        return min((edge for edge in edges if edge > time + LATE), default=self.end)

    @property
    def parts(self) -> tuple[StepPart, ...]:
        """The steps in it."""
        return step_parts(self.excitation, again=self.again)


@dataclass(frozen=True)
class Response:
    """A flown round.

    Attributes:
        round: what was asked.
        trace: what came of it.
        numbers: of its first step; None where it has none, or was ended before.
    """

    round: Round
    trace: Trace
    numbers: StepNumbers | None


class ResponseHistory:
    """Cuts a flight into responses.

    Args:
        take: takes a trace from the flight.

    Attributes:
        round: that is flown, or was flown last; None before the first.
        numbers: of the newest round whose first step is over, None before it.
        ghosts: the last responses before that, the newest first.
    """

    def __init__(self, take: Take) -> None:
        self._take = take
        self.clear()

    @property
    def is_running(self) -> bool:
        """Whether the newest round is being flown."""
        return self._running

    def clear(self) -> None:
        """Forget all: another flight begins."""
        self.round: Round | None = None
        self.numbers: StepNumbers | None = None
        self.ghosts: tuple[Response, ...] = ()
        self._running = False
        self._ended = 0.0
        self._measured = False
        self._changed = False

    def begin(self, exciting: Exciting, gains: Mapping[str, float]) -> None:
        """Take note of a round; the same one again changes nothing, unless gains have changed.

        Args:
            exciting: what is flown since when.
            gains: that fly it now.
        """
        before = self.round
        excitation, begun = exciting.excitation, exciting.began
        if before is not None and before.begun == begun and before.excitation == excitation:
            self._changed = self._changed or gains != before.gains
            return
        self._keep(min(begun, before.end) if before is not None else begun)
        self.round = Round(excitation, begun, dict(gains), exciting.again)
        self._running, self._measured, self._changed = True, False, False

    def end(self, now: float) -> None:
        """Take note that nothing excites the flight any more, at a simulated time [s]."""
        if self._running:
            self._running, self._ended = False, now

    def present(self, now: float) -> Trace | None:
        """Return what was flown of the newest round by now [s], and measure what is over."""
        if self.round is None:
            return None
        until = min(now, self.round.end) if self._running else min(self._ended, self.round.end)
        trace = self._take(self.round.excitation, self.round.begun, until)
        if not self._measured:
            numbers = self._measure(self.round, trace)
            if numbers is not None:
                self.numbers, self._measured = numbers, True
        return trace

    def _keep(self, end: float) -> None:
        """Make the newest round a ghost."""
        if self.round is None:
            return
        until = end if self._running else min(self._ended, self.round.end)
        trace = self._take(self.round.excitation, self.round.begun, until)
        if not len(trace) or trace.time[-1] < SHORTEST:
            return
        numbers = self.numbers if self._measured else self._measure(self.round, trace)
        kept = Response(self.round, trace, numbers)
        self.ghosts = (kept, *self.ghosts)[:GHOSTS]

    def _measure(self, flown: Round, trace: Trace) -> StepNumbers | None:
        """Return the numbers of a round's first step; those of the others are alike."""
        if not flown.parts:
            return None
        return measure_step(trace, flown.parts[0], changed=self._changed)
