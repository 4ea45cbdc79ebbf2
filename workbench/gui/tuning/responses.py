"""Flown rounds of an excitation, their steps, and the numbers of a step."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.analysis.replies import StepNumbers, load_numbers
from workbench.design.response_metrics import load_metrics, response_metrics, why_withheld
from workbench.gui.signals import Signals
from workbench.plant.vehicle import Vehicle
from workbench.scenario.excitation import LATE, Excitation, Exciting, Shape
from workbench.scenario.loads import Load

GHOSTS = 5
"""Earlier responses that are kept."""
SHORTEST = 0.1
"""Of a response that is kept [s]."""
FEWEST = 8
"""Samples of a step that has numbers."""
SAME = 1e-6
"""Times that differ by less are the same [s]."""
SAMPLED = 1 / 128
"""The last sample of a round may be so much before its end [s]."""


@dataclass(frozen=True)
class Trace:
    """What was flown from the edge of a round on; (N) each.

    Attributes:
        time: from the edge on [s].
        response: velocity [m/s] or yaw rate [rad/s]; of a load the deviation from where it was.
        tilt: [rad].
        rotor_use: largest share of any rotor's speed limit, at each time.
    """

    time: np.ndarray
    response: np.ndarray
    tilt: np.ndarray
    rotor_use: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def until(self, end: float) -> "Trace":
        """Return the part up to a time, which it includes [s]."""
        size = int(np.searchsorted(self.time, end + 1e-6))
        return self.between(0, size)

    def since(self, begin: float) -> "Trace":
        """Return the part from a time on, which becomes zero [s]."""
        first = int(np.searchsorted(self.time, begin - 1e-6))
        return self.between(first, len(self.time), begin)

    def between(self, first: int, last: int, zero: float = 0.0) -> "Trace":
        """Return the samples from one to another, their times from `zero` on."""
        part = slice(first, last)
        return Trace(
            self.time[part] - zero,
            self.response[part],
            self.tilt[part],
            self.rotor_use[part],
        )


def take_trace(
    signals: Signals, excitation: Excitation, vehicle: Vehicle, begun: float, end: float = np.inf
) -> Trace:
    """Return what was flown since a round began, or until its end: copies.

    Args:
        signals: of the flight.
        excitation: that was flown.
        vehicle: that flew it.
        begun: simulated time of the round's edge [s].
        end: simulated time up to which is wanted [s].
    """
    since = begun - 1e-6
    time, response = signals.series(excitation.row.signal, since)
    _, roll = signals.series("position_data.roll", since)
    _, pitch = signals.series("position_data.pitch", since)
    shares = [
        signals.series(f"rotors.speed.{index}", since)[1] / rotor.max_rot_velocity
        for index, rotor in enumerate(vehicle.rotors)
    ]
    last = int(np.searchsorted(time, end + 1e-6))
    # All of these come from one sample of the flight; a topic may be one behind for a moment.
    size = min(last, len(roll), *(len(share) for share in shares))
    time, roll, pitch, response = time[:size], roll[:size], pitch[:size], response[:size]
    if isinstance(excitation.row, Load):
        response = response - response[:1]
    tilt = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0))
    use = np.max(np.abs([share[:size] for share in shares]), axis=0)
    return Trace(time - begun, response.copy(), tilt, use)


@dataclass(frozen=True)
class StepPart:
    """A step within a round, from one level of the command to another.

    Attributes:
        begin: from the round's edge on [s].
        end: when the command changes again [s].
        before: level before, in the unit of the excitation's amplitude.
        level: that is asked for.
    """

    begin: float
    end: float
    before: float
    level: float

    @property
    def duration(self) -> float:
        """For how long the level is asked for [s]."""
        return self.end - self.begin

    @property
    def jump(self) -> float:
        """By how much the command changes."""
        return self.level - self.before


def step_parts(excitation: Excitation, *, again: bool = False) -> tuple[StepPart, ...]:
    """Return the steps of a round in their order, back to rest left out; a chirp has none.

    Args:
        excitation: what is flown.
        again: whether a round of the same was flown just before.
    """
    size, period = excitation.amplitude, excitation.period
    half = 0.5 * period
    match excitation.shape:
        case Shape.STEP:
            return (StepPart(0.0, period, 0.0, size),)
        case Shape.PULSE:  # what a load has done is over when the drone is back
            over = excitation.round_time if isinstance(excitation.row, Load) else period
            return (StepPart(0.0, over, 0.0, size),)
        case Shape.DOUBLET:
            return (StepPart(0.0, half, 0.0, size), StepPart(half, period, size, -size))
        case Shape.SQUARE:
            first = StepPart(0.0, half, -size if again else 0.0, size)
            return (first, StepPart(half, period, size, -size))
    return ()


def measure_step(trace: Trace, part: StepPart, *, changed: bool = False) -> StepNumbers | None:
    """Return the numbers of a step; None before it is over, or where it is too short.

    Args:
        trace: of the round, from its edge on.
        part: the step in it.
        changed: whether gains changed while it was flown.
    """
    if not len(trace) or trace.time[-1] < part.end - SAME:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    rise = flown.response - part.before
    duration = float(flown.time[-1])
    found = response_metrics(flown.time, rise[None, :], part.jump)
    kept = found.withheld(duration, part.jump)
    names = ("rise_time", "settling_time", "overshoot", "steady_state_error", "peak")
    return StepNumbers(
        **{name: math.nan if changed else float(getattr(kept, name)[0]) for name in names},
        peak_rotor_use=float(flown.rotor_use.max()),
        withheld=why_withheld(found, duration, part.jump, changed=changed),
    )


def measure_load(trace: Trace, part: StepPart, *, changed: bool = False) -> StepNumbers | None:
    """Return the numbers of a step of a load; None before it is over, or where it is too short.

    Args: as of `measure_step`.
    """
    if not len(trace) or trace.time[-1] < part.end - SAMPLED:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    found = load_metrics(flown.time, flown.response - flown.response[0], changed=changed)
    return load_numbers(found, float(flown.rotor_use.max()))


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
        """Record a round; the same one again changes nothing, unless gains have changed.

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
        """Record that the excitation has ended, at a simulated time [s]."""
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
        if isinstance(flown.excitation.row, Load):
            return measure_load(trace, flown.parts[0], changed=self._changed)
        return measure_step(trace, flown.parts[0], changed=self._changed)
