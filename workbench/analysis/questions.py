"""Questions of a screen to its analyst: frozen records of plain numbers.

The newest question of a kind counts: older ones that still wait are dropped.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.design.branches import Branch
from workbench.design.judge.margins import Robustness
from workbench.scenario.loads import LOADS

if TYPE_CHECKING:
    from workbench.session.checkpoint import Checkpoint

Gains = Mapping[str, float]
"""Values of the controller's parameters by name: all, or those that differ from the scenario's."""


@dataclass(frozen=True)
class Step:
    """A step of a command, or of a load in hover.

    Attributes:
        axis: x, y, z or yaw; for a load its name, see `scenario.loads`.
        amplitude: amplitude [m/s] or [rad/s]; for a load in its unit.
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
        return self.axis in LOADS


class Question:
    """A question for an analyst."""


@dataclass(frozen=True)
class Judge(Question):
    """How stable is the hover with these gains? Answered by `Judged`."""

    gains: Gains


@dataclass(frozen=True)
class JudgePlantInput(Question):
    """What is the multi-loop disk margin at the plant's input, see `design.judge.multiloop`?

    Answered by α while the pilot steers, and while the place is held; 0 if unstable.
    """

    gains: Gains


@dataclass(frozen=True)
class DrawFrequency(Question):
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
class PlanMeasurement(Question):
    """Which injection measures a loop in flight?

    Answered by the `Injection`, and whether a place is held during it.

    Attributes:
        gains: gains of the controller.
        loop: name of the loop.
        cut: where the loop is opened: actuator or error.
    """

    gains: Gains
    loop: str
    cut: str = "actuator"


@dataclass(frozen=True)
class ShapeLoop(Question):
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
    robustness: Robustness = Robustness.PHASE


@dataclass(frozen=True)
class MovePole(Question):
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
class FindRanges(Question):
    """In which range of each gain, the others fixed, is the loop stable?

    Answered by the smallest and largest value of each gain, by its name.
    """

    gains: Gains


@dataclass(frozen=True)
class Predict(Question):
    """What is the response to a step of a command or a load? Answered by `Predicted`."""

    gains: Gains
    step: Step


@dataclass(frozen=True)
class DrawMap(Question):
    """How does a metric depend on two gains? Answered by `Mapped`."""

    gains: Gains
    x: str
    y: str
    metric: str
    step: Step


@dataclass(frozen=True)
class Weigh(Question):
    """Which gains affect the metrics of a step most?

    Answered, for each metric by name, by its change for one percent more of each gain by name, in
    the metric's unit, the strongest first.
    """

    gains: Gains
    step: Step


@dataclass(frozen=True)
class Tune(Question):
    """Which gains meet wishes such as `x.rise_time <= 0.4`? Answered by `Searched`s, then `Tuned`.

    Attributes:
        gains: initial gains.
        wishes: wishes as typed.
        velocity: velocity of the trimmed flight to tune for, in W [m/s].
    """

    gains: Gains
    wishes: tuple[str, ...]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Fork(Question):
    """How does the flight continue from a checkpoint with each branch?

    Answered by the `FlownBranch`es in this order, each with the metrics of its step: `StepNumbers`,
    or None without a step, or if the flight was lost.

    Attributes:
        checkpoint: common start of the branches.
        branches: branches to fly.
        duration: duration of each branch [s].
        step: step commanded at the start, in addition to the present command; None for no step.
    """

    checkpoint: Checkpoint
    branches: tuple[Branch, ...]
    duration: float
    step: Step | None = None


@dataclass(frozen=True)
class Pin(Question):
    """Write a spec and its baseline for a step with these gains.

    Answered by the paths of both, and a sentence about their content.

    Attributes:
        path: path of the spec, NAME.spec.yaml.
        gains: gains to pin.
        step: step to fly, of a command or a load.
        margins: whether the margins of all loops become limits too.
        overwrite: whether existing files may be replaced.
    """

    path: Path
    gains: Gains
    step: Step
    margins: bool = True
    overwrite: bool = False


@dataclass(frozen=True)
class FlyAgain(Question):
    """How would a logged flight have gone with these gains? Answered by `FlownAgain`.

    Attributes:
        log: path of the log.
        gains: gains of the controller that flies, of all sets if they are scheduled.
        controller: another controller, with its own gains; "" for that of the gains.
        flown: the controller that flew the log; "" for the one that the log names.
        draws: number of uncertain vehicles for the band, in addition to the nominal one. The last
            question's vehicles are used again if nothing else has changed.
    """

    log: Path
    gains: Gains
    controller: str = ""
    flown: str = ""
    draws: int = 40


@dataclass(frozen=True)
class AskOther(Question):
    """What is the answer with another controller? Answered as the question itself.

    Attributes:
        controller: name of a shipped one, or path of a file.
        question: question whose gains change the controller's own, which its tuning rule provides.
    """

    controller: str
    question: Judge | Predict | DrawFrequency


@dataclass(frozen=True)
class Stop:
    """End the questions up to a number: a search keeps its best result, other work is dropped."""

    number: int


QUICK = 0
SLOW = 1
LONG = 2
"""Process that answers: the first answers while a slider moves; the second takes a tenth of a
second to some seconds, and is asked when a slider is at rest; the third takes minutes, and nothing
else waits for it."""
ANSWERED_BY: dict[type[Question], tuple[int, str]] = {
    Judge: (QUICK, "judging:judge"),
    ShapeLoop: (QUICK, "judging:shape_loop"),
    MovePole: (QUICK, "judging:move_pole"),
    DrawFrequency: (QUICK, "judging:draw_frequency"),
    Predict: (QUICK, "predicting:predict"),
    JudgePlantInput: (SLOW, "judging:judge_plant_input"),
    PlanMeasurement: (SLOW, "judging:plan_measurement"),
    Fork: (SLOW, "predicting:fork"),
    DrawMap: (QUICK, "predicting:draw_map"),
    FindRanges: (QUICK, "judging:find_ranges"),
    Weigh: (SLOW, "predicting:weigh"),
    Tune: (LONG, "tuning:tune"),
    Pin: (SLOW, "tuning:pin"),
    FlyAgain: (LONG, "predicting:fly_again"),
    AskOther: (SLOW, ""),
}
"""Process, file and function for each kind of question, the most urgent kind first. `AskOther` is
answered by the function of its inner question."""
