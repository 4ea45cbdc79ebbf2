"""Questions of a screen to its analyst: frozen records of plain numbers.

The newest question of an asker and a kind counts: older ones that still wait are dropped.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from workbench.design.branches import Branch
from workbench.design.judge.margins import RobustnessMeasure
from workbench.scenario.attitude_axes import ATTITUDE_NAMES
from workbench.scenario.loads import LOAD_NAMES

if TYPE_CHECKING:
    from workbench.session.checkpoint import Checkpoint

Gains = Mapping[str, float]
"""Values of the controller's parameters by name: all, or those that differ from the scenario's."""


@dataclass(frozen=True)
class RequestedStep:
    """A step of a command, or of a load in hover.

    Attributes:
        axis: x, y, z or yaw; of a setpoint of attitude or rate its name, see `attitude_axes`; for a
            load its name, see `scenario.loads`.
        amplitude: amplitude [m/s] or [rad/s]; of an attitude [rad]; for a load in its unit.
        duration: time after the edge [s].
        heading: yaw of the drone at the edge, in W [rad]. A velocity is commanded in W, so the
            heading decides how much of it the pitch loop flies, and how much the roll loop.
        acts: duration of a load [s], None for the rest of the flight.
    """

    axis: str
    amplitude: float
    duration: float
    heading: float = 0.0
    acts: float | None = None

    @property
    def is_load(self) -> bool:
        """Whether it is a step of a load."""
        return self.axis in LOAD_NAMES

    @property
    def is_attitude(self) -> bool:
        """Whether it is a step of a setpoint of attitude or rate."""
        return self.axis in ATTITUDE_NAMES


@dataclass(frozen=True)
class Query:
    """A question for an analyst; equal questions have equal answers, whoever asks.

    A package's own question names the process and the function that answers it itself; those of
    the core are in `ANSWERED_BY`.

    Attributes:
        process: one of `QUICK_PROCESS`, `SLOW_PROCESS` and `LONG_PROCESS`.
        answered_by: module and function, as "a_package.flights:fly_again"; the function gets an
            `AnalysedVehicle`, the question and its `Work`, and returns `Working`.
        is_kept: whether the answer serves whoever asks the same again.
        has_notice: whether a notice says why there is no answer, because the user asked for it by
            name; of a question that follows a slider, its card says so.
        asker: who asks; the newest question of a kind replaces only those of the same asker.
    """

    process: ClassVar[int] = 0
    answered_by: ClassVar[str] = ""
    is_kept: ClassVar[bool] = True
    has_notice: ClassVar[bool] = False

    asker: int = field(default=0, kw_only=True, compare=False, repr=False)

    def same(self, other: Query) -> bool:
        """Return whether another question is this one, so that its answer is this one's."""
        return self is other or (self.is_kept and self == other)

    @property
    def stream(self) -> tuple[type[Query], int]:
        """Kind and asker; of those that wait in one stream, the newest counts."""
        return type(self), self.asker


@dataclass(frozen=True)
class Judge(Query):
    """How stable is the hover with these gains? Answered by `Judged`."""

    gains: Gains


@dataclass(frozen=True)
class JudgePlantInput(Query):
    """What is the multi-loop disk margin at the plant's input, see `design.judge.multiloop`?

    Answered by α while the pilot steers, and while the place is held; 0 if unstable.
    """

    gains: Gains


@dataclass(frozen=True)
class DrawFrequency(Query):
    """What is a loop's frequency response? Answered by a `GangOfFour`.

    Attributes:
        gains: gains of the controller.
        loop: name of the loop.
        cut: where the loop is opened: actuator or error.
    """

    gains: Gains
    loop: str
    cut: str = "actuator"


@dataclass(frozen=True)
class PlanMeasurement(Query):
    """Which injection measures a loop in flight?

    Answered by the `Injection`, and whether a place is held during it.

    Attributes:
        gains: gains of the controller.
        loop: name of the loop.
        cut: where the loop is opened: actuator or error.
    """

    has_notice: ClassVar[bool] = True

    gains: Gains
    loop: str
    cut: str = "actuator"


@dataclass(frozen=True)
class ShapeLoop(Query):
    """Which gains of a loop give it a bandwidth and a margin? Answered by `LoopShaped`.

    Attributes:
        gains: gains of the controller; while a slider is held, those before it was grabbed.
        loop: name of the loop.
        bandwidth: requested bandwidth [rad/s]; None for the present one.
        margin: requested phase margin [rad] or disk margin; None for the present one.
        linked: gains that stay equal to gains of the loop, by the names of the latter.
        rests: whether the slider is at rest: then the answer includes saturation and noise.
        robustness: kind of the margin.
    """

    gains: Gains
    loop: str
    bandwidth: float | None = None
    margin: float | None = None
    linked: Mapping[str, str] = field(default_factory=dict)
    rests: bool = False
    robustness: RobustnessMeasure = RobustnessMeasure.PHASE


@dataclass(frozen=True)
class SampleReach(Query):
    """Which margins have all loops over the reach of one loop? Answered by `ReachSampled`.

    Attributes:
        gains: gains of the controller.
        loop: name of the loop.
        bandwidths: least and largest bandwidth that it can reach [rad/s].
        margins: least and largest margin that it can reach, a phase margin [rad] or disk margin.
        linked: gains that stay equal to gains of the loop, by the names of the latter.
        robustness: kind of the margin.
    """

    gains: Gains
    loop: str
    bandwidths: tuple[float, float]
    margins: tuple[float, float]
    linked: Mapping[str, str] = field(default_factory=dict)
    robustness: RobustnessMeasure = RobustnessMeasure.PHASE


@dataclass(frozen=True)
class MovePole(Query):
    """Which gains of a loop move a pole to a place? Answered by `PoleMoved`.

    Attributes:
        gains: gains of the controller when the pole was grabbed.
        loop: name of the loop.
        pole: the pole then, in continuous terms, the upper one of a pair [1/s].
        place: requested place [1/s].
        linked: gains that stay equal to gains of the loop, by the names of the latter.
    """

    gains: Gains
    loop: str
    pole: complex
    place: complex
    linked: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FindRanges(Query):
    """In which range of each gain, the others fixed, is the loop stable?

    Answered by the smallest and largest value of each gain, by its name.
    """

    gains: Gains


@dataclass(frozen=True)
class Predict(Query):
    """What is the response to a step of a command or a load? Answered by `Predicted`."""

    gains: Gains
    step: RequestedStep


@dataclass(frozen=True)
class DrawMap(Query):
    """How does a metric depend on two gains? Answered by `Mapped`."""

    gains: Gains
    x: str
    y: str
    metric: str
    step: RequestedStep


@dataclass(frozen=True)
class Sensitivities(Query):
    """Which gains affect the metrics of a step most?

    Answered, for each metric by name, by its change for one percent more of each gain by name, in
    the metric's unit, the strongest first.
    """

    has_notice: ClassVar[bool] = True

    gains: Gains
    step: RequestedStep


@dataclass(frozen=True)
class Tune(Query):
    """Which gains meet wishes such as `x.rise_time <= 0.4`? Answered by `Searched`s, then `Tuned`.

    Attributes:
        gains: initial gains.
        wishes: wishes as typed.
        velocity: velocity of the trimmed flight to tune for, in W [m/s].
    """

    is_kept: ClassVar[bool] = False
    has_notice: ClassVar[bool] = True

    gains: Gains
    wishes: tuple[str, ...]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Fork(Query):
    """How does the flight continue from a checkpoint with each branch?

    Answered by the `FlownBranch`es in this order, each with the metrics of its step: `StepMetrics`,
    or None without a step, or if the flight was lost.

    Attributes:
        checkpoint: common start of the branches.
        branches: branches to fly.
        duration: duration of each branch [s].
        step: step commanded at the start, in addition to the present command; None for no step.
    """

    is_kept: ClassVar[bool] = False
    has_notice: ClassVar[bool] = True

    checkpoint: Checkpoint
    branches: tuple[Branch, ...]
    duration: float
    step: RequestedStep | None = None


@dataclass(frozen=True)
class RegressionCase(Query):
    """Write a spec and its baseline for a step with these gains.

    Answered by the paths of both, and a sentence about their content.

    Attributes:
        path: path of the spec, NAME.workbench.yaml.
        gains: gains to pin.
        step: step to fly, of a command or a load.
        margins: whether the margins of all loops become limits too.
        overwrite: whether existing files may be replaced.
    """

    is_kept: ClassVar[bool] = False
    has_notice: ClassVar[bool] = True

    path: Path
    gains: Gains
    step: RequestedStep
    margins: bool = True
    overwrite: bool = False


@dataclass(frozen=True)
class OtherControllerQuery(Query):
    """What is the answer with another controller? Answered as the question itself.

    Attributes:
        controller: name of a shipped one, or path of a file.
        question: question whose gains change the controller's own, which its tuning rule provides.
    """

    controller: str
    question: Judge | Predict | DrawFrequency


@dataclass(frozen=True)
class StopQueries:
    """End the questions up to a number: a search keeps its best result, other work is dropped."""

    number: int


QUICK_PROCESS = 0
SLOW_PROCESS = 1
LONG_PROCESS = 2
"""Process that answers: the first answers while a slider moves; the second takes a tenth of a
second to some seconds, and is asked when a slider is at rest; the third takes minutes, and nothing
else waits for it."""
ANSWERED_BY: dict[type[Query], tuple[int, str]] = {
    Judge: (QUICK_PROCESS, "judging:judge_gains"),
    ShapeLoop: (QUICK_PROCESS, "loop_placing:shape_loop"),
    MovePole: (QUICK_PROCESS, "loop_placing:move_pole"),
    DrawFrequency: (QUICK_PROCESS, "judging:draw_frequency"),
    Predict: (QUICK_PROCESS, "predicting:predict"),
    JudgePlantInput: (SLOW_PROCESS, "judging:judge_plant_input"),
    SampleReach: (SLOW_PROCESS, "loop_placing:sample_reach"),
    PlanMeasurement: (SLOW_PROCESS, "judging:plan_measurement"),
    Fork: (SLOW_PROCESS, "predicting:fork"),
    DrawMap: (QUICK_PROCESS, "predicting:draw_map"),
    FindRanges: (QUICK_PROCESS, "gain_ranges:find_ranges"),
    Sensitivities: (SLOW_PROCESS, "predicting:weigh"),
    Tune: (LONG_PROCESS, "tuning:tune_gains"),
    RegressionCase: (SLOW_PROCESS, "tuning:pin"),
    OtherControllerQuery: (SLOW_PROCESS, ""),
}
"""Process, file and function for each kind of question, the most urgent kind first.
`OtherControllerQuery` is answered by the function of its inner question."""


def place_of_answer(kind: type) -> tuple[int, str] | None:
    """Return the process that answers a kind of question, and module and function; None if none."""
    if kind in ANSWERED_BY:
        process, place = ANSWERED_BY[kind]
        return process, f"workbench.analysis.{place}"
    if issubclass(kind, Query) and kind.answered_by:
        return kind.process, kind.answered_by
    return None
