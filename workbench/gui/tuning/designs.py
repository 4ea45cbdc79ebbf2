"""The designs that can be compared, gains and controllers, and what is known of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import (
    AskOther,
    DrawFrequency,
    Judge,
    Predict,
    Question,
    Step,
)
from workbench.analysis.replies import (
    FrequencyCurves,
    Judged,
    OtherAnswered,
    Predicted,
)
from workbench.control.controller import COMMON, LIMITS, SHIPPED
from workbench.gui.analysis import Analysis, Follower
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.errands import single_shot
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_editor import SLOTS
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.home.cards import simulated_text
from workbench.gui.tuning.trial import Trial
from workbench.scenario.parameters import OTHERS, SIGNAL_PATH

MOST_NAMES = 3
"""Names that a short text has."""
KEPT, FLOWN, PROPOSED, TRIED = "kept", "flown", "proposed", "tried"
NAMES = (KEPT, FLOWN, PROPOSED, *SLOTS)
"""Of the sets of gains, in the order in which they stand beside each other."""
STROKES = {
    FLOWN: (CurveStyle.SOLID, 0),
    PROPOSED: (CurveStyle.DASHED, 1),
    KEPT: (CurveStyle.SOLID, 2),
    "A": (CurveStyle.SOLID, 3),
    "B": (CurveStyle.SOLID, 4),
    "C": (CurveStyle.SOLID, 5),
}
"""Style and colour of each set, those of the response for flown and predicted."""
OTHER_COLOURS = (6, 7, 0, 2, 3, 4, 5)
"""Of the other controllers, dashed: no two of seven are alike, and none is like a set."""
SHARED = frozenset(row.name for row in COMMON if row.group == LIMITS) | frozenset(
    row.name for row in OTHERS if row.system in SIGNAL_PATH
)
"""Limits, filters and estimators: they stay as they are when another controller takes over."""
MOST = 300
"""Changes of what flies that are remembered."""
Key = tuple[str, tuple[tuple[str, float], ...]]
MOST_ANSWERS = 128
"""Answers that are remembered."""
REST = 200
"""What a slider leaves behind is asked for when nothing has changed for so long [ms]: the screen
asks about the proposed gains all the time, and its answers are heard."""
ACTUATOR = "actuator"
"""Where loops are cut that are compared, as their margins are."""
About = Step | str | None
"""What is asked: a step, the curves of the loop of a name, or with None the margins."""
Asked = tuple[Key, About]
Answer = Judged | Predicted | FrequencyCurves
KINDS: tuple[type[Question], ...] = (Judge, Predict, DrawFrequency, AskOther)


class OtherControllers:
    """Shipped controllers, and files that have flown since the window is there.

    Args:
        flight: whose controller is not among them.
    """

    def __init__(self, flight: FlightModel) -> None:
        self._flight = flight
        self._files: list[str] = []

    @property
    def present(self) -> str:
        """The one that flies: a shipped one's name, or a file's path."""
        scenario = self._flight.view.scenario
        return scenario.controller if scenario is not None else SHIPPED[0]

    @property
    def all(self) -> tuple[str, ...]:
        """All that are known, in an order that stays."""
        return (*SHIPPED, *self._files)

    @property
    def names(self) -> tuple[str, ...]:
        """All but the one that flies."""
        present = self.present
        return tuple(name for name in self.all if name != present)

    def note_flight(self) -> None:
        """Record what flies now."""
        if self.present not in self.all:
            self._files.append(self.present)


def controller_label(name: str) -> str:
    """Return how a controller is called: a shipped one's name, or that of its file."""
    return Path(name).stem if name.endswith(".py") else name


def gains_text(
    gains: Mapping[str, float],
    base: Mapping[str, float],
    *,
    same: str = "gains as now",
    most: int = MOST_NAMES,
) -> str:
    """Return what a set of gains has otherwise than another, as kp_pitch 180, in few words.

    Args:
        gains: by name.
        base: with which they are compared, where it has the same names.
        same: what is said where none is other.
        most: so many gains are named.
    """
    other = [name for name, value in gains.items() if name in base and base[name] != value]
    if not other:
        return same
    texts = [f"{name} {gains[name]:.4g}" for name in other[:most]]
    more = len(other) - most
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def gains_list(gains: Mapping[str, float], base: Mapping[str, float]) -> tuple[str, ...]:
    """Return a line for each gain that a set has otherwise than another: both values."""
    return tuple(
        f"{name} {value:.6g} instead of {base[name]:.6g}"
        for name, value in gains.items()
        if name in base and base[name] != value
    )


@dataclass(frozen=True)
class Design:
    """A controller and its gains.

    Attributes:
        name: everywhere on the screen.
        gains: that are judged, by name; of another controller those that all have.
        style: of its curves.
        colour: of its curves, their number.
        controller: another one than flies, with its own gains; "" for the one that flies.
        short: by which gains it differs from the kept ones, in few words.
        long: the same, a line for each gain, and when it flew.
    """

    name: str
    gains: Mapping[str, float]
    style: CurveStyle
    colour: int
    controller: str = ""
    short: str = ""
    long: tuple[str, ...] = ()

    @property
    def key(self) -> Key:
        """What decides how it flies."""
        return self.controller, tuple(sorted(self.gains.items()))


@dataclass(frozen=True)
class Flown:
    """Gains that flew from a simulated time [s] on, and the controller whose they are."""

    since: float
    controller: str
    gains: Mapping[str, float]


class Designs(QObject):
    """Knows the designs there are, and when each flew.

    Args:
        flight: whose gains are tuned.
        trial: what is tried.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """A design changed, or there are more or fewer."""

    def __init__(self, flight: FlightModel, trial: Trial, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._trial = flight, trial
        self._others = OtherControllers(flight)
        self._flown: list[Flown] = []
        trial.changed.connect(self._follow)
        trial.gains.state_changed.connect(self._follow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all sets that have gains, and of the controllers that do not fly."""
        return (*self._sets(), *self._others.names)

    def all(self) -> tuple[Design, ...]:
        """Return all designs, in their order; none before a flight has begun."""
        sets = self._sets()
        if not sets:
            return ()
        made = [self._of_gains(name, values) for name, values in sets.items()]
        return (*made, *map(self._of_controller, self._others.names))

    def begin(self) -> None:
        """Forget when gains flew: another flight begins."""
        self._flown = []
        self.take_over()

    def take_over(self) -> None:
        """Record the controller that flies now."""
        self._others.note_flight()
        self._follow()

    def profile(self, name: str) -> dict[str, float]:
        """Return the values of a set that its profile has."""
        gains = self._trial.gains
        stored = {KEPT: gains.kept, PROPOSED: gains.proposed_profile, **gains.slots}
        return dict(stored[name]) if name in stored else gains.ordered_profile

    def differs(self, gains: Mapping[str, float]) -> str:
        """Return in few words by which gains a set differs from the kept ones."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_text(gains, kept, same="as kept", most=1)

    def flight_name(self, time: float, gains: Mapping[str, float]) -> str:
        """Return how gains are called that flew at a simulated time [s], and when that was.

        By the slot or the kept set that has the same gains now, else as tried, with what differs
        from the kept ones; by their controller where that is another one now.
        """
        before = [each for each in self._flown if each.since <= time]
        controller = before[-1].controller if before else self._others.present
        name, note = TRIED, ""
        if controller != self._others.present:
            name = controller_label(controller)
        else:
            for each, values in self._sets().items():
                if each not in (FLOWN, PROPOSED) and values == gains:
                    name = each
                    break
            else:
                note = f" ({self.differs(gains)})"
        return f"{name} at {simulated_text(time, 1)}{note}"

    def gains_list(self, gains: Mapping[str, float]) -> tuple[str, ...]:
        """Return a line for each gain by which a set differs from the kept ones."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_list(gains, kept) or ("gains as kept",)

    def _sets(self) -> dict[str, dict[str, float]]:
        """Return the controller's gains of each set that there is, by its name."""
        gains, flown = self._trial.gains, self._trial.flown
        if not flown:
            return {}
        stored = {KEPT: gains.kept, **gains.slots}
        # filters are no part of a profile: they stay
        found = {name: flown | controller_gains(values) for name, values in stored.items()}
        found |= {FLOWN: flown, PROPOSED: self._trial.proposed}
        return {name: found[name] for name in NAMES if name in found}

    def _of_gains(self, name: str, values: Mapping[str, float]) -> Design:
        differs = self.gains_list(values) if name != KEPT else ()
        return Design(
            name,
            self._trial.gains.of_set(values),
            *STROKES[name],
            short="" if name == KEPT else self.differs(values),
            long=(*differs, self._when(values)),
        )

    def _of_controller(self, name: str) -> Design:
        colour = OTHER_COLOURS[self._others.all.index(name) % len(OTHER_COLOURS)]
        gains = {key: value for key, value in self._trial.flown.items() if key in SHARED}
        said = f"The controller {name}, with its own gains for this vehicle"
        return Design(
            controller_label(name),
            gains,
            CurveStyle.DASHED,
            colour,
            name,
            "own gains",
            (said, "limits and filters as they fly"),
        )

    def _follow(self) -> None:
        """Record what flies now."""
        flown, view = self._trial.flown, self._flight.view
        present = self._others.present
        last = self._flown[-1] if self._flown else None
        if flown and (last is None or last.gains != flown or last.controller != present):
            time = view.snapshot.time if view.snapshot is not None else 0.0
            self._flown = [*self._flown[1 - MOST :], Flown(time, present, flown)]
        self.changed.emit()

    def _when(self, values: Mapping[str, float]) -> str:
        """Return when gains flew last, in words."""
        present = self._others.present
        ends = [*(each.since for each in self._flown[1:]), None]
        for each, end in reversed([*zip(self._flown, ends, strict=True)]):
            if each.controller == present and each.gains == values:
                since = simulated_text(each.since, 1)
                if end is None:
                    return f"flies since {since}"
                return f"flew from {since} to {simulated_text(end, 1)}"
        return "has not flown"


class DesignAnswers(QObject):
    """Asks about designs, one question of a kind at a time, and remembers the answers.

    Gains of the controller that flies are asked about as those of a slider are. Another controller
    is asked about in the slow process: it may have to be compiled.

    Args:
        analysis: who answers.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._known: dict[Asked, Answer] = {}
        self._refused: dict[Asked, str] = {}
        self._designs: tuple[Design, ...] = ()
        self._step: Step | None = None
        self._loop = ""
        self._seen = False
        for kind in KINDS:  # before the followers hear it, who ask the next question
            analysis.answers[kind].connect(self._hear)
        analysis.refused.connect(self._hear_refusal)
        self._followers = {kind: Follower(analysis, kind, self) for kind in KINDS}
        self._rest = single_shot(self._ask, self, REST)
        for each in self._followers.values():
            each.answered.connect(lambda _: self._ask())
            each.refused.connect(lambda _: self._ask())

    def clear(self) -> None:
        """Forget all: another flight begins, or another controller flies."""
        self._known, self._refused = {}, {}
        for each in self._followers.values():
            each.forget()
        self._rest.start()

    def set_seen(self, seen: bool) -> None:
        """Ask only while it is visible; what was refused is tried again."""
        if seen and not self._seen:
            self._refused = {}
        self._seen = seen
        for each in self._followers.values():
            each.set_seen(seen)
        self._rest.start()

    def follow(self, designs: Sequence[Design], step: Step | None, loop: str = "") -> None:
        """Want to know the margins of all of these designs from now on, and more.

        Args:
            designs: that are compared.
            step: that is predicted of each, None for none.
            loop: whose curves over frequency are drawn, of those that have it; "" for none.
        """
        self._designs, self._step, self._loop = tuple(designs), step, loop
        self._rest.start()

    def judged(self, design: Design) -> Judged | None:
        """Return how stable a design is, None while it is not known."""
        known = self._known.get((design.key, None))
        return known if isinstance(known, Judged) else None

    def predicted(self, design: Design) -> Predicted | None:
        """Return the step of a design, None while it is not known."""
        known = self._known.get((design.key, self._step))
        return known if isinstance(known, Predicted) else None

    def curves(self, design: Design) -> FrequencyCurves | None:
        """Return the loop of a design over frequency, None while it is not known."""
        known = self._known.get((design.key, self._loop))
        return known if isinstance(known, FrequencyCurves) else None

    def refusal(self, design: Design) -> str:
        """Return why something of a design is not known, "" where it is or will be."""
        said = (self._refused.get(each, "") for each in self._wanted(design))
        return next(filter(None, said), "")

    @property
    def missing(self) -> tuple[Design, ...]:
        """Designs of which something is not known yet, and will be."""
        return tuple(each for each in self._designs if self._open(each))

    def _wanted(self, design: Design) -> list[Asked]:
        """Return what is to be known of a design."""
        about: list[About] = [None] if self._step is None else [None, self._step]
        judged = self.judged(design)
        if judged is not None and self._loop in [loop.name for loop in judged.loops]:
            about.append(self._loop)
        return [(design.key, each) for each in about]

    def _open(self, design: Design) -> list[Asked]:
        """Return what is neither known nor refused of it."""
        done = self._known.keys() | self._refused.keys()
        return [each for each in self._wanted(design) if each not in done]

    def _ask(self) -> None:
        """Ask the next question of each kind."""
        asked: set[type] = set()
        for design in self._designs if self._seen else ():
            for _, about in self._open(design):
                question = _question(design, about)
                asks: Question = question
                if design.controller:
                    asks = AskOther(design.controller, question)
                if type(asks) not in asked:
                    asked.add(type(asks))
                    self._followers[type(asks)].ask(asks)

    def _hear(self, reply: Answer | OtherAnswered) -> None:
        controller = reply.asked.controller if isinstance(reply, OtherAnswered) else ""
        answer = reply.answer if isinstance(reply, OtherAnswered) else reply
        self._known[_asked(controller, answer.asked)] = answer
        wanted = {each for design in self._designs for each in self._wanted(design)}
        unwanted = [each for each in self._known if each not in wanted]
        for old in unwanted[: max(0, len(self._known) - MOST_ANSWERS)]:
            del self._known[old]
        self.changed.emit()

    def _hear_refusal(self, question: Question, said: str) -> None:
        controller = question.controller if isinstance(question, AskOther) else ""
        asked = question.question if isinstance(question, AskOther) else question
        if isinstance(asked, Judge | Predict | DrawFrequency):
            self._refused[_asked(controller, asked)] = said
            self.changed.emit()


def _question(design: Design, about: About) -> Judge | Predict | DrawFrequency:
    if about is None:
        return Judge(design.gains)
    if isinstance(about, Step):
        return Predict(design.gains, about)
    return DrawFrequency(design.gains, about)


def _asked(controller: str, question: Judge | Predict | DrawFrequency) -> Asked:
    """Return what a question is about."""
    about: About = None
    if isinstance(question, DrawFrequency):
        cut = "" if question.cut == ACTUATOR else f" at {question.cut}"
        about = f"{question.loop}{cut}"
    elif isinstance(question, Predict):
        about = question.step
    return (controller, tuple(sorted(question.gains.items()))), about
