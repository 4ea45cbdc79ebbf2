"""The analyst for screens: they ask questions, and answers arrive as signals."""

from collections.abc import Hashable, Iterable, Mapping
from concurrent.futures import Future
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.analysis.analyst import Analyst
from workbench.analysis.questions import (
    Fork,
    Pin,
    PlanMeasurement,
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
MOST_ANSWERS = 128
"""Number of remembered answers to questions of a kind."""
NOBODY = "there is nothing to judge yet: open a scenario first"


class Answered(QObject):
    """Passes on the answers to one kind of question."""

    signal = pyqtSignal(object)


class Analysis(QObject):
    """Asks the analyst about gains of the flying vehicle.

    Args:
        notices: takes refusals, except those of questions in streams.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        answers: signal for the answers to each kind of question.
    """

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
        self.answers = {kind: Answered(self).signal for kind in Question.__subclasses__()}
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
        token = self._token = object()
        self._analyst = Analyst(
            scenario, settings, lambda progress: self._progressed.emit(token, progress)
        )

    def warm_up(self) -> None:
        """Start the answering processes, as when a screen that uses them is shown."""
        if self._analyst is not None:
            self._analyst.warm_up()

    def ask(self, question: Question) -> None:
        """Ask a question; the answer arrives by the signal of its kind, or by `refused`.

        Of each kind the newest question counts: an older one that still waits is dropped silently.
        One in progress is answered; a reply contains its question.
        """
        analyst = self._analyst
        if analyst is None:
            self._refuse(question, NOBODY)
            return
        analyst.ask(question).add_done_callback(lambda done: self._hear(analyst, question, done))

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
            self.answers[type(question)].emit(reply)

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
    """Asks questions of one kind that change often, one at a time: the newest is next.

    Args:
        analysis: takes the questions.
        kind: kind of the questions.
        parent: the Qt parent; this object is deleted with it.
    """

    answered = pyqtSignal(object)
    """The reply to the last question."""
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
        self._wanted: Question | None = None
        self.forget()
        analysis.answers[kind].connect(self._hear)
        analysis.refused.connect(self._hear_refusal)
        analysis.preparing.connect(self._hear_preparing)

    @property
    def is_waiting(self) -> bool:
        """Whether an answer is expected."""
        return self._asked is not None

    def ask(self, question: Question) -> None:
        """Ask a question; it replaces one that still waits."""
        self._wanted = question
        self._send()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._seen = seen
        self._send()

    def forget(self) -> None:
        """Drop questions and answers: another flight begins."""
        self._wanted = None
        self._asked: Question | None = None
        self._last: Question | None = None

    def _send(self) -> None:
        question = self._wanted
        if not self._seen or question is None or self._asked is not None:
            return
        self._wanted = None
        if question == self._last:
            return
        self._asked = question
        self._analysis.ask(question)

    def _hear(self, reply: Any) -> None:
        asked, self._asked = self._asked, None
        if asked is not None and reply.asked == asked:
            self._last = asked
            self.answered.emit(reply)
        elif asked is not None and self._wanted is None:
            self._wanted = asked  # another asker's question may have replaced ours
        self._send()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if not isinstance(question, self._kind) or self._asked is None:
            return
        asked, self._asked = self._asked, None
        if question == asked:
            self.refused.emit(said)
        elif self._wanted is None:
            self._wanted = asked
        self._send()

    def _hear_preparing(self, said: str) -> None:
        if self.is_waiting:
            self.preparing.emit(said)


class Memory(Follower):
    """A follower that remembers the answers to questions of its kind, whoever asked them."""

    def forget(self) -> None:
        """Drop questions and answers: another flight begins."""
        super().forget()
        self._answers: dict[Hashable, Any] = {}

    def known(self, question: Question) -> Any:
        """Return the answer to a question, None while unknown."""
        answer = self._answers.pop(key_of(question), None)
        if answer is not None:  # what is used last is forgotten last
            self._answers[key_of(question)] = answer
        return answer

    def ask_first(self, questions: Iterable[Question]) -> None:
        """Ask the first of these questions whose answer is unknown."""
        question = next((each for each in questions if self.known(each) is None), None)
        if question is not None:
            self.ask(question)

    def _hear(self, reply: Any) -> None:
        self._answers[key_of(reply.asked)] = reply
        if len(self._answers) > MOST_ANSWERS:
            del self._answers[next(iter(self._answers))]
        super()._hear(reply)


def key_of(part: object) -> Hashable:
    """Return a question, or a part of one, as the key of a dictionary."""
    if isinstance(part, Question):
        return type(part), *map(key_of, vars(part).values())
    return frozenset(part.items()) if isinstance(part, Mapping) else part
