"""The designs that can be compared, gains and controllers, and their known results."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
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
from workbench.analysis.replies import Judged, JudgedLoop, Predicted
from workbench.common.plain_text import plain_name
from workbench.control.controller import COMMON, LIMITS, SHIPPED
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.gui.analysis import Analysis, Follower, key_of
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.errands import single_shot
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_editor import SLOTS
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.home.cards import simulated_text
from workbench.gui.tuning.trial import Trial
from workbench.scenario.parameters import OTHERS, SIGNAL_PATH

MOST_NAMES = 3
"""Largest number of names in a short text."""
KEPT, FLOWN, PROPOSED, TRIED = "kept", "flown", "proposed", "tried"
NAMES = (KEPT, FLOWN, PROPOSED, *SLOTS)
"""Names of the sets of gains, in the order of their columns."""
STROKES = {
    FLOWN: (CurveStyle.SOLID, 0),
    PROPOSED: (CurveStyle.DASHED, 1),
    KEPT: (CurveStyle.SOLID, 2),
    "A": (CurveStyle.SOLID, 3),
    "B": (CurveStyle.SOLID, 4),
    "C": (CurveStyle.SOLID, 5),
}
"""Style and colour of each set, like those of the response for flown and predicted."""
OTHER_COLOURS = (6, 7, 0, 2, 3, 4, 5)
"""Colours of the other controllers, dashed: seven differ from each other and from all sets."""
SHARED = frozenset(row.name for row in COMMON if row.group == LIMITS) | frozenset(
    row.name for row in OTHERS if row.system in SIGNAL_PATH
)
"""Limits, filters and estimators: another controller does not change them."""
MOST = 300
"""Number of remembered changes of the flown gains."""
REST = 200
"""Time without changes after which other questions about a slider's gains are asked [ms]: the
screen asks about the proposed gains all the time, and its answers are used here."""
About = Step | str | None
"""Subject of a question: a step, the curves of a loop by name, or None for the margins."""
KINDS: tuple[type[Question], ...] = (Judge, Predict, DrawFrequency, AskOther)


def controller_label(name: str) -> str:
    """Return a controller's label: the name of a shipped one, or that of its file."""
    return plain_name(Path(name).stem if name.endswith(".py") else name)


def gains_text(
    gains: Mapping[str, float],
    base: Mapping[str, float],
    *,
    same: str = "gains as now",
    most: int = MOST_NAMES,
) -> str:
    """Return the gains in which a set differs from another, as kp_pitch 180, as a short text.

    Args:
        gains: values by name.
        base: values to compare with, for the same names.
        same: text without a difference.
        most: largest number of named gains.
    """
    other = [name for name, value in gains.items() if name in base and base[name] != value]
    if not other:
        return same
    texts = [f"{name} {gains[name]:.4g}" for name in other[:most]]
    more = len(other) - most
    return ", ".join(texts) + (f" and {more} more" if more > 0 else "")


def gains_list(gains: Mapping[str, float], base: Mapping[str, float]) -> tuple[str, ...]:
    """Return a line for each gain in which a set differs from another, with both values."""
    return tuple(
        f"{name} {value:.6g} instead of {base[name]:.6g}"
        for name, value in gains.items()
        if name in base and base[name] != value
    )


@dataclass(frozen=True)
class Design:
    """A controller and its gains.

    Attributes:
        name: its name on the screen.
        gains: gains to evaluate, by name; for another controller those that all controllers have.
        style: style of its curves.
        colour: number of its colour.
        controller: a controller other than the flying one, with its own gains; "" for the flying
            one.
        short: its differences from the kept gains, as a short text.
        long: the same with a line for each gain, and when it flew.
        predicted: its step response, None if unknown or not requested.
        judged: its margins, None if unknown.
        curves: frequency response of a loop, None if unknown or not requested.
        said: why something is unknown, "" if it is still expected.
    """

    name: str
    gains: Mapping[str, float]
    style: CurveStyle
    colour: int
    controller: str = ""
    short: str = ""
    long: tuple[str, ...] = ()
    predicted: Predicted | None = None
    judged: Judged | None = None
    curves: GangOfFour | None = None
    said: str = ""

    def loop(self, name: str) -> JudgedLoop | None:
        """Return one of its loops, None if it does not exist or is unknown."""
        loops = self.judged.loops if self.judged is not None else ()
        return next((loop for loop in loops if loop.name == name), None)


class Designs(QObject):
    """The existing designs, and when each flew.

    Args:
        flight: the flight whose gains are tuned.
        trial: the gains that are being tried.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """A design changed, appeared or disappeared."""

    def __init__(self, flight: FlightModel, trial: Trial, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._trial = flight, trial
        self._files: list[str] = []  # controllers that have flown since the window was opened
        self._flown: list[tuple[float, str, Mapping[str, float]]] = []
        trial.changed.connect(self._follow)
        trial.gains.state_changed.connect(self._follow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all existing sets of gains, and of the controllers that do not fly."""
        return (*self._sets(), *self.others)

    @property
    def present(self) -> str:
        """The flying controller: name of a shipped one, or path of a file."""
        scenario = self._flight.view.scenario
        return scenario.controller if scenario is not None else SHIPPED[0]

    @property
    def controllers(self) -> tuple[str, ...]:
        """Shipped controllers, and files that have flown, in a fixed order."""
        return (*SHIPPED, *self._files)

    @property
    def others(self) -> tuple[str, ...]:
        """All controllers except the flying one."""
        return tuple(name for name in self.controllers if name != self.present)

    def all(self) -> tuple[Design, ...]:
        """Return all designs, in order; none before a flight has begun."""
        sets = self._sets()
        if not sets:
            return ()
        made = [self._of_gains(name, values) for name, values in sets.items()]
        return (*made, *map(self._of_controller, self.others))

    def begin(self) -> None:
        """Clear the flown gains: another flight begins."""
        self._flown = []
        self.take_over()

    def take_over(self) -> None:
        """Record the flying controller."""
        if self.present not in self.controllers:
            self._files.append(self.present)
        self._follow()

    def gains_of(self, name: str) -> dict[str, float]:
        """Return the values of a set that a gain file has."""
        gains = self._trial.gains
        stored = {KEPT: gains.kept, PROPOSED: gains.proposed_gains, **gains.slots}
        return dict(stored[name]) if name in stored else gains.ordered_gains

    def differs(self, gains: Mapping[str, float]) -> str:
        """Return the differences of a set from the kept gains, as a short text."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_text(gains, kept, same="as kept", most=1)

    def flight_name(self, time: float, gains: Mapping[str, float]) -> str:
        """Return the name of the gains that flew at a simulated time [s], and when that was.

        The name is that of a slot or the kept set with the same gains now, else "tried" with the
        differences from the kept gains; or that of their controller if another one flies now.
        """
        before = [controller for since, controller, _ in self._flown if since <= time]
        controller = before[-1] if before else self.present
        name, note = TRIED, ""
        if controller != self.present:
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
        """Return a line for each gain in which a set differs from the kept gains."""
        kept = controller_gains(self._trial.gains.kept)
        return gains_list(gains, kept) or ("gains as kept",)

    def _sets(self) -> dict[str, dict[str, float]]:
        """Return the controller's gains of each existing set, by its name."""
        gains, flown = self._trial.gains, self._trial.flown
        if not flown:
            return {}
        stored = {KEPT: gains.kept, **gains.slots}
        # filters are not in a gain file: they stay
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
        colour = OTHER_COLOURS[self.controllers.index(name) % len(OTHER_COLOURS)]
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
        if flown and (not self._flown or self._flown[-1][1:] != (self.present, flown)):
            time = view.snapshot.time if view.snapshot is not None else 0.0
            self._flown = [*self._flown[1 - MOST :], (time, self.present, flown)]
        self.changed.emit()

    def _when(self, values: Mapping[str, float]) -> str:
        """Return when gains last flew, in words."""
        end = ""
        for since, controller, gains in reversed(self._flown):
            begun = simulated_text(since, 1)
            if controller == self.present and gains == values:
                return f"flew from {begun} to {end}" if end else f"flies since {begun}"
            end = begun
        return "has not flown"


class DesignAnswers(QObject):
    """Asks about designs, one question of a kind at a time.

    Questions about the flying controller are asked like those of a slider. Those about another
    controller go to the slow process, because it may have to be compiled.

    Args:
        analysis: answers the questions.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._refused: dict[Hashable, str] = {}
        self._designs: tuple[Design, ...] = ()
        self._step: Step | None = None
        self._loop = ""
        self._seen = False
        analysis.refused.connect(self._hear_refusal)
        analysis.answered.connect(self._hear)
        self._followers = {kind: Follower(analysis, kind, self) for kind in KINDS}
        for each in self._followers.values():
            each.answered.connect(lambda *_: self._ask())  # its loops may be known now
        self._rest = single_shot(self._ask, self, REST)

    def clear(self) -> None:
        """Clear all: another flight begins, or another controller flies."""
        self._refused = {}
        for each in self._followers.values():
            each.forget()
        self._rest.start()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible; refused questions are tried again."""
        if seen and not self._seen:
            self._refused = {}
        self._seen = seen
        for each in self._followers.values():
            each.set_seen(seen)
        self._rest.start()

    def follow(self, designs: Sequence[Design], step: Step | None, loop: str = "") -> None:
        """Request the margins of all of these designs from now on, and more.

        Args:
            designs: compared designs.
            step: step to predict for each, None for none.
            loop: loop whose frequency response is drawn, if a design has it; "" for none.
        """
        self._designs, self._step, self._loop = tuple(designs), step, loop
        self._rest.start()

    def known(self, design: Design) -> Design:
        """Return a design with what is known of it, and why something is not."""
        analysis, step = self._analysis, self._step
        said = (self._refused.get(key_of(each), "") for each in self._wanted(design))
        return replace(
            design,
            judged=analysis.known(_question(design, None)),
            predicted=analysis.known(_question(design, step)) if step is not None else None,
            curves=analysis.known(_question(design, self._loop)) if self._loop else None,
            said=next(filter(None, said), ""),
        )

    @property
    def missing(self) -> tuple[Design, ...]:
        """Designs with answers that are still expected."""
        return tuple(each for each in self._designs if self._open(each))

    def _wanted(self, design: Design) -> list[Question]:
        """Return the questions about a design."""
        about: list[About] = [None] if self._step is None else [None, self._step]
        judged: Judged | None = self._analysis.known(_question(design, None))
        if judged is not None and self._loop in [loop.name for loop in judged.loops]:
            about.append(self._loop)
        return [_question(design, each) for each in about]

    def _open(self, design: Design) -> list[Question]:
        """Return the questions that are neither answered nor refused."""
        unknown = (each for each in self._wanted(design) if self._analysis.known(each) is None)
        return [each for each in unknown if key_of(each) not in self._refused]

    def _ask(self) -> None:
        """Ask all open questions, one of each kind at a time."""
        opened = [each for design in self._designs for each in self._open(design)]
        for kind, follower in self._followers.items():
            follower.ask(*(each for each in opened if type(each) is kind))

    def _hear(self, question: Question, _: object) -> None:
        if isinstance(question, KINDS):
            self.changed.emit()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, KINDS):
            self._refused[key_of(question)] = said
            self.changed.emit()


def _question(design: Design, about: About) -> Question:
    question: Judge | Predict | DrawFrequency = Judge(design.gains)
    if isinstance(about, Step):
        question = Predict(design.gains, about)
    elif about is not None:
        question = DrawFrequency(design.gains, about)
    return AskOther(design.controller, question) if design.controller else question
