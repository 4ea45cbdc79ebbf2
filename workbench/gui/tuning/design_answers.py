"""Questions about designs and their answers, one question of a kind at a time."""

from collections.abc import Hashable, Sequence
from dataclasses import replace

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import (
    DrawFrequency,
    Judge,
    OtherControllerQuery,
    Predict,
    Query,
    RequestedStep,
)
from workbench.analysis.replies import Judged
from workbench.gui.analysis import SETTLING_MS, Analysis, QueryStream, query_key
from workbench.gui.errands import single_shot
from workbench.gui.tuning.designs import Design

QuestionSubject = RequestedStep | str | None
"""Subject of a question: a step, the curves of a loop by name, or None for the margins."""
DESIGN_QUESTION_KINDS: tuple[type[Query], ...] = (
    Judge,
    Predict,
    DrawFrequency,
    OtherControllerQuery,
)


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
        self._step: RequestedStep | None = None
        self._loop = ""
        self._seen = False
        analysis.refused.connect(self._hear_refusal)
        analysis.answered.connect(self._hear)
        self._streams = {kind: QueryStream(analysis, self) for kind in DESIGN_QUESTION_KINDS}
        for each in self._streams.values():
            each.answered.connect(lambda *_: self._ask())  # its loops may be known now
        self._rest = single_shot(self._ask, self, SETTLING_MS)

    def clear(self) -> None:
        """Clear all: another flight begins, or another controller flies."""
        self._refused = {}
        for each in self._streams.values():
            each.forget()
        self._rest.start()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible; refused questions are tried again."""
        if seen and not self._seen:
            self._refused = {}
        self._seen = seen
        for each in self._streams.values():
            each.set_seen(seen)
        self._rest.start()

    def follow(self, designs: Sequence[Design], step: RequestedStep | None, loop: str = "") -> None:
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
        said = (self._refused.get(query_key(each), "") for each in self._wanted(design))
        return replace(
            design,
            judged=analysis.known(_design_question(design, None)),
            predicted=analysis.known(_design_question(design, step)) if step is not None else None,
            curves=analysis.known(_design_question(design, self._loop)) if self._loop else None,
            said=next(filter(None, said), ""),
        )

    @property
    def missing(self) -> tuple[Design, ...]:
        """Designs with answers that are still expected."""
        return tuple(each for each in self._designs if self._open(each))

    def _wanted(self, design: Design) -> list[Query]:
        """Return the questions about a design."""
        about: list[QuestionSubject] = [None] if self._step is None else [None, self._step]
        judged: Judged | None = self._analysis.known(_design_question(design, None))
        if judged is not None and self._loop in [loop.name for loop in judged.loops]:
            about.append(self._loop)
        return [_design_question(design, each) for each in about]

    def _open(self, design: Design) -> list[Query]:
        """Return the questions that are neither answered nor refused."""
        unknown = (each for each in self._wanted(design) if self._analysis.known(each) is None)
        return [each for each in unknown if query_key(each) not in self._refused]

    def _ask(self) -> None:
        """Ask all open questions, one of each kind at a time."""
        opened = [each for design in self._designs for each in self._open(design)]
        for kind, stream in self._streams.items():
            stream.ask(*(each for each in opened if type(each) is kind))

    def _hear(self, question: Query, _: object) -> None:
        if isinstance(question, DESIGN_QUESTION_KINDS):
            self.changed.emit()

    def _hear_refusal(self, question: Query, said: str) -> None:
        if isinstance(question, DESIGN_QUESTION_KINDS):
            self._refused[query_key(question)] = said
            self.changed.emit()


def _design_question(design: Design, about: QuestionSubject) -> Query:
    question: Judge | Predict | DrawFrequency = Judge(design.gains)
    if isinstance(about, RequestedStep):
        question = Predict(design.gains, about)
    elif about is not None:
        question = DrawFrequency(design.gains, about)
    return OtherControllerQuery(design.controller, question) if design.controller else question
