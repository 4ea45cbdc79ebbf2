"""Answers of an analyst: frozen records of plain numbers and arrays.

None carries an object of Drake's, so that a screen does not load it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.analysis.questions import (
    AskOther,
    DrawFrequency,
    DrawMap,
    FindRanges,
    FlyAgain,
    Gains,
    Judge,
    JudgePlantInput,
    MovePole,
    PlanMeasurement,
    Predict,
    ShapeLoop,
    Weigh,
)
from workbench.design.branches import FlownBranch
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.margins import LoopMargins
from workbench.design.response_metrics import LoadMetrics, StepMetrics
from workbench.scenario.scenario import Injection


@dataclass(frozen=True)
class JudgedLoop(LoopMargins):
    """The margins of one loop.

    Attributes:
        name: of the loop.
        growing: whether a mode that grows goes through it.
        turned: what turned the phase at the crossover, by its name [rad], see
            `design.judge.phase_budget`; nothing of an unstable loop.
    """

    name: str = ""
    growing: bool = False
    turned: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Judged:
    """How stable gains are.

    Attributes:
        asked: the question.
        loops: in the order of the cascade.
        poles: of the closed loop in continuous terms, as complex numbers (k) [1/s].
        stable: whether all is.
        said: what is unstable, in a sentence; "" where all is stable.
    """

    asked: Judge
    loops: tuple[JudgedLoop, ...]
    poles: np.ndarray
    stable: bool
    said: str


@dataclass(frozen=True)
class JudgedPlantInput:
    """The multi-loop disk margin at the plant's input, see `design.judge.multiloop`.

    Attributes:
        asked: the question.
        steering: α while the pilot steers, 0 where a mode grows.
        holding: α while the place is held, likewise.
    """

    asked: JudgePlantInput
    steering: float
    holding: float

    @property
    def disk_margin(self) -> float:
        """The lesser of both."""
        return min(self.steering, self.holding)


@dataclass(frozen=True)
class FrequencyCurves(GangOfFour):
    """A loop over frequency, and the question."""

    asked: DrawFrequency


@dataclass(frozen=True)
class LoopShaped:
    """Gains of a loop for a bandwidth and a margin, see `design.judge.loop_shaping`.

    Attributes:
        asked: the question.
        gains: of the loop, and of what is linked with them.
        bandwidth: with them [rad/s], NaN where it is unstable; of `LoopMargins`.
        phase_margin: with them [rad].
        disk_margin: with them.
        reached: whether the asked ones are.
        bandwidths: least and largest with no less of the asked margin [rad/s], NaN where not known.
        reach: least and largest of the asked margin at this bandwidth, likewise.
        said: what limits them, in a sentence.
    """

    asked: ShapeLoop
    gains: Gains
    bandwidth: float
    phase_margin: float
    disk_margin: float
    reached: bool
    bandwidths: tuple[float, float]
    reach: tuple[float, float]
    said: str


@dataclass(frozen=True)
class PoleMoved:
    """Gains of a loop that move a pole, see `design.judge.pole_placing`.

    Attributes:
        asked: the question.
        gains: of the loop, and of what is linked with them.
        pole: where it is with them [1/s].
        reached: whether that is the asked place.
        said: what is in the way, in a sentence, "" where it is reached.
    """

    asked: MovePole
    gains: Gains
    pole: complex
    reached: bool
    said: str


@dataclass(frozen=True)
class MeasurementPlanned:
    """An injection that measures a loop, and whether a place is held meanwhile."""

    asked: PlanMeasurement
    injection: Injection
    hold: bool


@dataclass(frozen=True)
class Ranges:
    """The stable range of each gain by name, smallest and largest, while the others stay."""

    asked: FindRanges
    stable: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class StepNumbers:
    """Metrics of one flown step of a command or a load; NaN where it has none.

    Times in s, overshoot and error in %, rotor use as a share, the peak in the response's unit.
    `withheld` says why some are NaN, as of a step that has not settled; "" if none is for
    such a reason.
    """

    rise_time: float
    settling_time: float
    overshoot: float
    steady_state_error: float
    peak_rotor_use: float
    withheld: str = ""
    peak: float = math.nan


def step_numbers(metrics: StepMetrics, peak_rotor_use: float) -> StepNumbers:
    """Return the numbers of a step of a command."""
    return StepNumbers(
        rise_time=metrics.rise_time,
        settling_time=metrics.settling_time,
        overshoot=metrics.overshoot,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
        peak=metrics.peak,
    )


def load_numbers(metrics: LoadMetrics, peak_rotor_use: float) -> StepNumbers:
    """Return the numbers of a step of a load."""
    return StepNumbers(
        rise_time=math.nan,
        settling_time=metrics.settling_time,
        overshoot=math.nan,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
        peak=metrics.peak,
    )


@dataclass(frozen=True)
class Predicted:
    """A step of a command or a load as it would be flown.

    Attributes:
        asked: the question.
        time: from the edge on (N) [s].
        response: (N) [m/s] or [rad/s]; of a load the deviation, in its response's unit.
        numbers: metrics of it.
        lost: whether the drone was lost.
    """

    asked: Predict
    time: np.ndarray
    response: np.ndarray
    numbers: StepNumbers
    lost: bool


@dataclass(frozen=True)
class Mapped:
    """A metric over two gains.

    Attributes:
        asked: the question.
        x: values along the columns.
        y: values along the rows.
        values: (N_y, N_x), NaN where a flight was lost or never got there.
        unit: of them.
    """

    asked: DrawMap
    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    unit: str


@dataclass(frozen=True)
class Weighed:
    """What the gains do to each metric of a step.

    Attributes:
        asked: the question.
        slopes: of each metric by its name, for one percent more of each gain by its name, in the
            metric's unit, the strongest first.
    """

    asked: Weigh
    slopes: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Searched:
    """How a search goes.

    Attributes:
        phase: in words.
        share: of its budget, 0 .. 1.
        gains: the best so far, those that are searched.
        said: what it has least to spare of, in words.
    """

    phase: str
    share: float
    gains: Gains
    said: str


@dataclass(frozen=True)
class Wished:
    """One wish, before and after: its text, its values as texts, and whether it is met."""

    wish: str
    before: str
    after: str
    met: bool


@dataclass(frozen=True)
class TunedStep:
    """A step before and after a search (N) each, for the plot."""

    axis: str
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray


@dataclass(frozen=True)
class Tuned:
    """What a search found.

    Attributes:
        before: the gains that were searched, as they were.
        gains: and as found.
        met: whether all wishes are met, corners and full diagram included.
        stopped: whether the user ended it.
        wishes: one by one.
        steps: before and after.
        said: what else should be known, why wishes are not met.
        widened: how many defaults gave way to what the rule's gains reach; `said` names them.
    """

    before: Gains
    gains: Gains
    met: bool
    stopped: bool
    wishes: tuple[Wished, ...]
    steps: tuple[TunedStep, ...]
    said: tuple[str, ...]
    widened: int = 0


@dataclass(frozen=True)
class Forked:
    """All branches of a fork.

    Attributes:
        branches: in the order in which they were asked for.
        numbers: of the step of each; None without a step, or where the flight was lost.
    """

    branches: tuple[FlownBranch, ...]
    numbers: tuple[StepNumbers | None, ...] = ()


@dataclass(frozen=True)
class Pinned:
    """A regression was written: its spec, its baseline, and a sentence on what it holds."""

    spec: Path
    baseline: Path
    said: str


@dataclass(frozen=True)
class FlownAgain:
    """A logged flight, and the one that would have been, see `design.predict.what_if`.

    Columns of six are x, y, z, v_x, v_y, v_z [m, m/s].

    Attributes:
        asked: the question.
        vehicle: whose model flew it again.
        logged_vehicle: that flew, as the log names it; "" where it does not.
        doubt: why it may be wrong, in a sentence; "" where nothing says so.
        flown: the controller that flew.
        flown_gains: its values, as far as the log tells them.
        time: from the start of the log on (k) [s].
        setpoint: position (k, 3) [m].
        logged: (k, 6).
        other: the flight that would have been (k, 6); NaN once it is lost.
        low: lower edges of its band (k, 6).
        high: upper edges.
        off_setpoint: RMS by which log and other flight are off the setpoint (2, 3) [m].
        difference: RMS between the two (6).
        band: half its width, mean over time (6).
        stays: whether the nominal vehicle is not lost.
        lost: vehicles that are.
        drawn: vehicles that were flown: the nominal one, and uncertain ones.
    """

    asked: FlyAgain
    vehicle: str
    logged_vehicle: str
    doubt: str
    flown: str
    flown_gains: Gains
    time: np.ndarray
    setpoint: np.ndarray
    logged: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray
    off_setpoint: np.ndarray
    difference: np.ndarray
    band: np.ndarray
    stays: bool
    lost: int
    drawn: int


@dataclass(frozen=True)
class OtherAnswered:
    """What was asked about another controller than the one that flies, and the answer to it."""

    asked: AskOther
    answer: Judged | Predicted | FrequencyCurves
