"""The analyst for screens: they ask questions, and answers arrive as signals."""

from collections.abc import Hashable, Mapping
from concurrent.futures import Future
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.analysis.analyst import Analyst
from workbench.analysis.questions import (
    AskOther,
    DrawFrequency,
    Fork,
    Judge,
    JudgePlantInput,
    Pin,
    PlanMeasurement,
    Predict,
    Question,
    Tune,
    Weigh,
)
from workbench.analysis.replies import Searched
from workbench.control.controller import Controller
from workbench.gui.errands import Answers, Errands
from workbench.gui.notices import Notices
from workbench.ipc.worker_process import SupersededError
from workbench.scenario.scenario import Scenario

ASKED_ONCE = (PlanMeasurement, Fork, Weigh, Tune, Pin)
"""Questions that are asked one by one: a notice says why one has no answer. The others are asked in
a stream while a slider moves, and their card shows the reason."""
REMEMBERED = (Judge, JudgePlantInput, DrawFrequency, Predict, AskOther)
"""Questions whose answers are remembered, because several cards ask them again and again."""
MOST_ANSWERS = 512
"""Number of remembered answers."""
NOBODY = "there is nothing to judge yet: open a scenario first"


class Analysis(QObject):
    """Asks the analyst about gains of the flying vehicle.

    Args:
        notices: takes refusals, except those of questions in streams.
        parent: the Qt parent; this object is deleted with it.
    """

    answered = pyqtSignal(object, object)
    """A question, and its reply."""
    searched = pyqtSignal(object)
    """A `Searched`: the progress of tuning."""
    preparing = pyqtSignal(str)
    """The analyst's preparations before an answer, as compiling."""
    refused = pyqtSignal(object, str)
    """A question that cannot be answered, and the reason."""

    _progressed = pyqtSignal(object, object)

    def __init__(self, notices: Notices, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._notices = notices
        self._answers = Answers(notices.warn, self)
        self._analyst: Analyst | None = None
        self._controller: Controller | None = None
        self._token = object()
        self._errands = Errands()
        self._known: dict[Hashable, Any] = {}
        queued = Qt.ConnectionType.QueuedConnection  # called in a thread of the analyst
        self._progressed.connect(self._show_progress, queued)  # pyrefly: ignore[bad-argument-count]

    @property
    def pids(self) -> tuple[int | None, ...]:
        """Process IDs of the quick, slow and searching process, None before they start."""
        return self._analyst.pids if self._analyst is not None else (None,) * 3

    def begin(
        self,
        scenario: Scenario,
        settings: Mapping[str, float],
        controller: Controller | None = None,
    ) -> None:
        """Evaluate another vehicle from now on; earlier questions are dropped.

        No process starts before the first question. If scenario and settings are unchanged, nothing
        is dropped unless the analyst has given up.

        Args:
            scenario: the flown scenario.
            settings: all live parameters at the start.
            controller: the scenario's controller, as its file was read.
        """
        present = self._analyst
        if present is not None:
            same = (present.scenario, present.settings) == (scenario, dict(settings))
            same &= controller is self._controller
            if same and not present.has_given_up:
                return
            self._errands.do(present.close)
        self._controller = controller
        self.forget()
        token = self._token = object()
        self._analyst = Analyst(
            scenario, settings, lambda progress: self._progressed.emit(token, progress)
        )

    def warm_up(self) -> None:
        """Start the answering processes, as when a screen that uses them is shown."""
        if self._analyst is not None:
            self._analyst.warm_up()

    def ask(self, question: Question) -> None:
        """Ask a question; the answer arrives by `answered`, or by `refused`.

        Of each kind the newest question counts: an older one that still waits is dropped silently.
        One in progress is answered.
        """
        analyst = self._analyst
        if analyst is None:
            self._refuse(question, NOBODY)
            return
        analyst.ask(question).add_done_callback(lambda done: self._hear(analyst, question, done))

    def known(self, question: Question) -> Any:
        """Return the remembered answer to a question, None while unknown."""
        answer = self._known.pop(key_of(question), None)
        if answer is not None:  # what is used last is forgotten last
            self._known[key_of(question)] = answer
        return answer

    def forget(self) -> None:
        """Forget all answers: another vehicle flies."""
        self._known.clear()

    def tell(self, question: Question, reply: object) -> None:
        """Remember an answer, and tell everybody."""
        if isinstance(question, REMEMBERED):
            self._known[key_of(question)] = reply
            if len(self._known) > MOST_ANSWERS:
                del self._known[next(iter(self._known))]
        self.answered.emit(question, reply)

    def stop(self) -> None:
        """End a search soon, and keep its best result."""
        if self._analyst is not None:
            self._analyst.stop()

    def close(self) -> None:
        """End the analyst's processes, and wait until they are gone; must be the last call."""
        self._answers.close()
        analyst, self._analyst = self._analyst, None
        if analyst is not None:
            analyst.close()
        self._errands.close()

    def _hear(self, analyst: Analyst, question: Question, done: "Future[Any]") -> None:
        """Pass an answer on, from any thread; a dropped question has none."""
        if not isinstance(done.exception(), SupersededError):
            self._answers.expect(
                done,
                lambda reply: self._show(analyst, question, reply),
                lambda said: self._show_refusal(analyst, question, said),
            )

    def _show(self, analyst: Analyst, question: Question, reply: object) -> None:
        if analyst is self._analyst:
            self.tell(question, reply)

    def _show_refusal(self, analyst: Analyst, question: Question, said: str) -> None:
        if analyst is self._analyst:
            self._refuse(question, said)

    def _show_progress(self, token: object, progress: Searched | str) -> None:
        if token is not self._token:
            return
        if isinstance(progress, str):
            self.preparing.emit(progress)
        else:
            self.searched.emit(progress)

    def _refuse(self, question: Question, said: str) -> None:
        """Report why there is no answer."""
        self.refused.emit(question, said)
        if isinstance(question, ASKED_ONCE):
            self._notices.warn(said)


class Follower(QObject):
    """Asks questions of one kind that change often, one at a time, while its card is visible.

    Args:
        analysis: takes the questions.
        kind: kind of the questions.
        parent: the Qt parent; this object is deleted with it.
    """

    answered = pyqtSignal(object, object)
    """The last question, and its reply."""
    refused = pyqtSignal(str)
    """Why there is no reply."""
    preparing = pyqtSignal(str)
    """Preparations before the expected answer, as compiling."""

    def __init__(
        self, analysis: Analysis, kind: type[Question], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._kind = kind
        self._seen = False
        self.forget()
        analysis.answered.connect(self._hear)
        analysis.refused.connect(self._hear_refusal)
        analysis.preparing.connect(self._hear_preparing)

    @property
    def is_waiting(self) -> bool:
        """Whether an answer is expected."""
        return self._asked is not None

    def ask(self, *questions: Question) -> None:
        """Ask questions in turn, unless their answers are known; they replace those that wait."""
        self._wanted = [*questions]
        self._send()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._seen = seen
        self._send()

    def forget(self) -> None:
        """Drop questions: another flight begins."""
        self._wanted: list[Question] = []
        self._asked: Question | None = None
        self._last: Question | None = None

    def _send(self) -> None:
        while self._seen and self._wanted and self._asked is None:
            question = self._wanted.pop(0)
            if question != self._last and self._analysis.known(question) is None:
                self._asked = question
                self._analysis.ask(question)

    def _hear(self, question: Question, reply: object) -> None:
        if not isinstance(question, self._kind):
            return
        asked, self._asked = self._asked, None
        if asked is not None and question == asked:
            self._last = asked
            self.answered.emit(question, reply)
        elif asked is not None and not self._wanted:
            self._wanted = [asked]  # another asker's question may have replaced ours
        self._send()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if not isinstance(question, self._kind) or self._asked is None:
            return
        asked, self._asked = self._asked, None
        if question == asked:
            self.refused.emit(said)
        elif not self._wanted:
            self._wanted = [asked]
        self._send()

    def _hear_preparing(self, said: str) -> None:
        if self.is_waiting:
            self.preparing.emit(said)


def key_of(part: object) -> Hashable:
    """Return a question, or a part of one, as the key of a dictionary."""
    if isinstance(part, Question):
        return type(part), *map(key_of, vars(part).values())
    return frozenset(part.items()) if isinstance(part, Mapping) else part
