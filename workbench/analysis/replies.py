"""Replies of an analyst: frozen records of plain numbers and arrays.

None contains an object of Drake's, so a screen need not load Drake.
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
        name: name of the loop.
        growing: whether an unstable mode involves it.
        turned: contributions to the phase at the crossover, by cause [rad], see
            `design.judge.phase_budget`; empty for an unstable loop.
    """

    name: str = ""
    growing: bool = False
    turned: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Judged:
    """Stability with given gains.

    Attributes:
        asked: the question.
        loops: loops in the order of the cascade.
        poles: poles of the closed loop in continuous terms, complex (k) [1/s].
        stable: whether everything is stable.
        said: what is unstable, as a sentence; "" if everything is stable.
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
        steering: α while the pilot steers, 0 if unstable.
        holding: α while the position is held, 0 if unstable.
    """

    asked: JudgePlantInput
    steering: float
    holding: float

    @property
    def disk_margin(self) -> float:
        """The smaller of both."""
        return min(self.steering, self.holding)


@dataclass(frozen=True)
class FrequencyCurves(GangOfFour):
    """Frequency response of a loop, and the question."""

    asked: DrawFrequency


@dataclass(frozen=True)
class LoopShaped:
    """Gains of a loop for a bandwidth and a margin, see `design.judge.loop_shaping`.

    Attributes:
        asked: the question.
        gains: gains of the loop, and gains linked with them.
        bandwidth: bandwidth with these gains [rad/s], NaN if unstable; see `LoopMargins`.
        phase_margin: phase margin with these gains [rad].
        disk_margin: disk margin with these gains.
        reached: whether the requested values are reached.
        bandwidths: least and largest bandwidth with at least the requested margin [rad/s], NaN if
            unknown.
        reach: least and largest margin at this bandwidth, NaN if unknown.
        said: what limits them, as a sentence.
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
        gains: gains of the loop, and gains linked with them.
        pole: the pole with these gains [1/s].
        reached: whether it is at the requested place.
        said: what prevents it, as a sentence, "" if it is reached.
    """

    asked: MovePole
    gains: Gains
    pole: complex
    reached: bool
    said: str


@dataclass(frozen=True)
class MeasurementPlanned:
    """An injection that measures a loop, and whether a place is held during it."""

    asked: PlanMeasurement
    injection: Injection
    hold: bool


@dataclass(frozen=True)
class Ranges:
    """The stable range of each gain by name, smallest and largest, with the others fixed."""

    asked: FindRanges
    stable: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class StepNumbers:
    """Metrics of one flown step of a command or a load; NaN if it has none.

    Times in s, overshoot and error in %, rotor use as a share, the peak in the response's unit.
    `withheld` says why some are NaN, as for a step that has not settled; else "".
    """

    rise_time: float
    settling_time: float
    overshoot: float
    steady_state_error: float
    peak_rotor_use: float
    withheld: str = ""
    peak: float = math.nan


def step_numbers(metrics: StepMetrics | LoadMetrics, peak_rotor_use: float) -> StepNumbers:
    """Return the numbers of a step of a command or a load; a load has no rise and no overshoot."""
    return StepNumbers(
        rise_time=metrics.rise_time if isinstance(metrics, StepMetrics) else math.nan,
        settling_time=metrics.settling_time,
        overshoot=metrics.overshoot if isinstance(metrics, StepMetrics) else math.nan,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
        peak=metrics.peak,
    )


@dataclass(frozen=True)
class Predicted:
    """Response to a step of a command or a load.

    Attributes:
        asked: the question.
        time: time from the edge on (N) [s].
        response: response (N) [m/s] or [rad/s]; for a load the deviation, in its unit.
        numbers: metrics of the response.
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
        values: (N_y, N_x), NaN if a flight was lost or has no such metric.
        unit: unit of the values.
    """

    asked: DrawMap
    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    unit: str


@dataclass(frozen=True)
class Weighed:
    """Effects of the gains on each metric of a step.

    Attributes:
        asked: the question.
        slopes: for each metric by name, its change for one percent more of each gain by name, in
            the metric's unit, the strongest first.
    """

    asked: Weigh
    slopes: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Searched:
    """Progress of a search.

    Attributes:
        phase: present phase, in words.
        share: used share of its budget, 0 .. 1.
        gains: best values so far of the searched gains.
        said: wish with the least reserve, in words.
    """

    phase: str
    share: float
    gains: Gains
    said: str


@dataclass(frozen=True)
class Wished:
    """One wish: its text, its values before and after as text, and whether it is met."""

    wish: str
    before: str
    after: str
    met: bool


@dataclass(frozen=True)
class TunedStep:
    """A step before and after a search (N), for the plot."""

    axis: str
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray


@dataclass(frozen=True)
class Tuned:
    """Result of a search.

    Attributes:
        before: values of the searched gains before.
        gains: their values now.
        met: whether all wishes are met, for the corners and the full diagram, too.
        stopped: whether the user ended the search.
        wishes: each wish.
        steps: steps before and after.
        said: further remarks, as why wishes are not met.
        widened: number of default limits that were relaxed to what the rule's gains reach; `said`
            names them.
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
        branches: branches in the order of the question.
        numbers: metrics of each step; None without a step, or if the flight was lost.
    """

    branches: tuple[FlownBranch, ...]
    numbers: tuple[StepNumbers | None, ...] = ()


@dataclass(frozen=True)
class Pinned:
    """A regression was written: its spec, its baseline, and a sentence about its content."""

    spec: Path
    baseline: Path
    said: str


@dataclass(frozen=True)
class FlownAgain:
    """A logged flight, and the same flight with other gains, see `design.predict.what_if`.

    Columns of six are x, y, z, v_x, v_y, v_z [m, m/s].

    Attributes:
        asked: the question.
        vehicle: vehicle whose model flew it again.
        logged_vehicle: vehicle that the log names; "" without one.
        doubt: why the result may be wrong, as a sentence; else "".
        flown: the controller that flew the log.
        flown_gains: its values, as far as the log has them.
        time: time from the start of the log on (k) [s].
        setpoint: position (k, 3) [m].
        logged: motion of the log (k, 6).
        other: motion with other gains (k, 6); NaN once the drone is lost.
        low: lower edges of its band (k, 6).
        high: upper edges of its band (k, 6).
        off_setpoint: RMS distance of log and other flight from the setpoint (2, 3) [m].
        difference: RMS difference between the two (6).
        band: half of the band's width, mean over time (6).
        stays: whether the nominal vehicle survives.
        lost: number of lost vehicles.
        drawn: number of flown vehicles: the nominal one, and uncertain ones.
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
    """An answer with a controller other than the one that flies."""

    asked: AskOther
    answer: Judged | Predicted | FrequencyCurves
