"""Questions of a screen to its analyst: frozen records of plain numbers.

The newest of a kind counts: one that waits is dropped for it.
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
"""Values of the controller's parameters by name, those that differ from the scenario's or all."""


@dataclass(frozen=True)
class Step:
    """A step of a command, or of a load in hover.

    Attributes:
        axis: x, y, z or yaw; of a load its name, see `scenario.loads`.
        amplitude: [m/s] or [rad/s]; of a load in its unit.
        duration: after its edge [s].
        heading: yaw of the drone at the edge, in W [rad]. A velocity is commanded in W, so the
            heading decides how much of it the pitch loop flies, and how much the roll loop.
        acts: for how long a load acts [s], None to the end.
    """

    axis: str
    amplitude: float
    duration: float
    heading: float = 0.0
    acts: float | None = None

    @property
    def is_load(self) -> bool:
        """Whether it is one of a load."""
        return self.axis in LOADS


class Question:
    """Something that an analyst answers."""


@dataclass(frozen=True)
class Judge(Question):
    """How stable are these gains at hover? Answered by `Judged`."""

    gains: Gains


@dataclass(frozen=True)
class JudgePlantInput(Question):
    """What is the disk margin of force and moments at once? Answered by `JudgedPlantInput`."""

    gains: Gains


@dataclass(frozen=True)
class DrawFrequency(Question):
    """What does a loop look like over frequency? Answered by `FrequencyCurves`.

    Attributes:
        gains: of the controller.
        loop: name of one of its loops.
        cut: where it is opened: actuator or error.
    """

    gains: Gains
    loop: str
    cut: str = "actuator"


@dataclass(frozen=True)
class PlanMeasurement(Question):
    """Which injection measures a loop in flight? Answered by `MeasurementPlanned`.

    Attributes:
        gains: of the controller.
        loop: name of one of its loops.
        cut: where it is opened: actuator or error.
    """

    gains: Gains
    loop: str
    cut: str = "actuator"


@dataclass(frozen=True)
class ShapeLoop(Question):
    """Which gains of a loop give it a bandwidth and a margin? Answered by `LoopShaped`.

    Attributes:
        gains: of the controller; where a slider is held, those that were as it was taken.
        loop: name of one of its loops.
        bandwidth: asked [rad/s]; None for what it is.
        margin: asked: a phase margin [rad], or a disk margin; None for what it is.
        linked: gains that have the same values as the loop's, by the names of these.
        rests: whether nothing moves: then the answer tells of saturation and noise, too.
        robustness: which margin is asked.
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
    """Which gains of a loop bring a pole to a place? Answered by `PoleMoved`.

    Attributes:
        gains: of the controller, those that were as the pole was taken.
        loop: name of one of its loops.
        pole: where it was then, in continuous terms, the upper one of a pair [1/s].
        place: where it is wanted [1/s].
        linked: gains that have the same values as the loop's, by the names of these.
    """

    gains: Gains
    loop: str
    pole: complex
    place: complex
    linked: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FindRanges(Question):
    """In which range of each gain, alone, is the loop stable? Answered by `Ranges`."""

    gains: Gains


@dataclass(frozen=True)
class Predict(Question):
    """How would a step of a command or a load be flown? Answered by `Predicted`."""

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
    """Which gain moves the metrics of a step most? Answered by `Weighed`."""

    gains: Gains
    step: Step


@dataclass(frozen=True)
class Tune(Question):
    """Find gains for wishes, as `x.rise_time <= 0.4`; answered by `Searched`s, then `Tuned`.

    Attributes:
        gains: to begin with.
        wishes: as they are typed.
        velocity: of the steady flight that is tuned for, in W [m/s].
    """

    gains: Gains
    wishes: tuple[str, ...]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Fork(Question):
    """How does the flight go on from a checkpoint, with each branch? Answered by `Forked`.

    Attributes:
        checkpoint: from which it goes on.
        branches: to be flown.
        duration: to be flown [s].
        step: that is commanded at once, as a step from what is asked for now; None lets it fly on.
    """

    checkpoint: Checkpoint
    branches: tuple[Branch, ...]
    duration: float
    step: Step | None = None


@dataclass(frozen=True)
class Pin(Question):
    """Write a spec and its baseline for a step with these gains. Answered by `Pinned`.

    Attributes:
        path: of the spec, NAME.spec.yaml.
        gains: to be pinned.
        step: to be flown, of a command or a load.
        margins: whether the margins of all loops become limits too.
        overwrite: whether files that are there may be replaced.
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
        log: its file.
        gains: of the controller that flies, of all sets where they are scheduled.
        controller: another one that flies it instead, with its own gains; "" for that of the gains.
        flown: the one that flew the log; "" for what the log says.
        draws: uncertain vehicles that the band is made of, the vehicle itself besides. Those of the
            question before are kept where nothing else is asked otherwise.
    """

    log: Path
    gains: Gains
    controller: str = ""
    flown: str = ""
    draws: int = 40


@dataclass(frozen=True)
class AskOther(Question):
    """What is the answer if another controller flies? Answered by `OtherAnswered`.

    Attributes:
        controller: a shipped one's name, or a file's path.
        question: whose gains are values over the controller's own: those of a vehicle's rule.
    """

    controller: str
    question: Judge | Predict | DrawFrequency


@dataclass(frozen=True)
class Stop:
    """End the questions up to a number: a search keeps its best, other work is given up."""

    number: int


QUICK, SLOW, LONG = range(3)
"""The process that answers: one answers while a slider moves; the next takes a tenth of a second to
some seconds, and is asked once a slider rests; one takes minutes, and nothing else waits for it."""
ANSWERED_BY: dict[type[Question], tuple[int, str]] = {
    Judge: (QUICK, "judging:judge"),
    ShapeLoop: (QUICK, "shaping:shape_loop"),
    MovePole: (QUICK, "shaping:move_pole"),
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
"""The process, file and function that answer each kind of question, the most urgent kind first.
`AskOther` is answered by those of the question in it."""
