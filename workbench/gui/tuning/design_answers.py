"""What is known of the designs that are compared, and what is still to be asked about them."""

from collections.abc import Sequence

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
from workbench.gui.analysis import Analysis
from workbench.gui.errands import single_shot
from workbench.gui.tuning.designs import Design, Key
from workbench.gui.tuning.follower import Follower

MOST = 128
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


class DesignAnswers(QObject):
    """Asks about designs, one question of a kind at a time, and remembers the answers.

    Gains of the controller that flies are asked about as those of a slider are. Another controller
    is asked about in the slow process: it may have to be compiled.

    Args:
        analysis: who answers.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """Something else is known now."""

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
        """Ask only while somebody looks; what was refused is tried again."""
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
        for old in unwanted[: max(0, len(self._known) - MOST)]:
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
