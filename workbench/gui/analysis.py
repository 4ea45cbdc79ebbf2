"""The analyst for screens: they ask questions, and answers arrive as signals."""

from collections.abc import Hashable, Mapping
from concurrent.futures import Future
from dataclasses import fields, replace
from itertools import count
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.analysis.analyst import Analyst
from workbench.analysis.queries import Query
from workbench.analysis.replies import Searched
from workbench.control.controller import Controller
from workbench.gui.errands import BackgroundTasks, FutureCallbacks
from workbench.gui.notices import Notices
from workbench.ipc.worker_process import SupersededError
from workbench.scenario.scenario import Scenario

SETTLING_MS = 300
"""Gains have settled if they have not changed for this time [ms]: then longer work is asked for."""
MAX_CACHED_RESULTS = 512
"""Number of remembered answers."""
NO_FLIGHT_TO_ANALYSE = "there is nothing to judge yet: open a scenario first"


class Analysis(QObject):
    """Asks the analyst about gains of the flying vehicle.

    Args:
        notices: takes refusals of questions that the user asks once.
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
        self._answers = FutureCallbacks(notices.warn, self)
        self._analyst: Analyst | None = None
        self._controller: Controller | None = None
        self._token = object()
        self._errands = BackgroundTasks()
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
    ) -> bool:
        """Evaluate another vehicle from now on; earlier questions are dropped.

        No process starts before the first question. If scenario and settings are unchanged, nothing
        is dropped unless the analyst has given up.

        Args:
            scenario: the flown scenario.
            settings: all live parameters at the start.
            controller: the scenario's controller, as its file was read.

        Returns:
            Whether earlier questions were dropped.
        """
        present = self._analyst
        if present is not None:
            same = (present.scenario, present.settings) == (scenario, dict(settings))
            same &= controller is self._controller
            if same and not present.has_given_up:
                return False
            self._errands.do(present.close)
        self._controller = controller
        self.forget()
        token = self._token = object()
        self._analyst = Analyst(
            scenario, settings, lambda progress: self._progressed.emit(token, progress)
        )
        return True

    def warm_up(self) -> None:
        """Start the answering processes, as when a screen that uses them is shown."""
        if self._analyst is not None:
            self._analyst.warm_up()

    def ask(self, question: Query) -> None:
        """Ask a question; the answer arrives by `answered`, or by `refused`.

        Of an asker's questions of a kind the newest counts: an older one that still waits is
        dropped silently. One in progress is answered.
        """
        analyst = self._analyst
        if analyst is None:
            self._refuse(question, NO_FLIGHT_TO_ANALYSE)
            return
        analyst.ask(question).add_done_callback(lambda done: self._hear(analyst, question, done))

    def known(self, question: Query) -> Any:
        """Return the remembered answer to a question, None while unknown."""
        if not question.is_kept:
            return None
        answer = self._known.pop(query_key(question), None)
        if answer is not None:  # what is used last is forgotten last
            self._known[query_key(question)] = answer
        return answer

    def forget(self) -> None:
        """Forget all answers: another vehicle flies."""
        self._known.clear()

    def tell(self, question: Query, reply: object) -> None:
        """Remember an answer, and tell everybody."""
        if question.is_kept:
            self._known[query_key(question)] = reply
            if len(self._known) > MAX_CACHED_RESULTS:
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

    def _hear(self, analyst: Analyst, question: Query, done: "Future[Any]") -> None:
        """Pass an answer on, from any thread; a dropped question has none."""
        if not isinstance(done.exception(), SupersededError):
            self._answers.expect(
                done,
                lambda reply: self._show(analyst, question, reply),
                lambda said: self._show_refusal(analyst, question, said),
            )

    def _show(self, analyst: Analyst, question: Query, reply: object) -> None:
        if analyst is self._analyst:
            self.tell(question, reply)

    def _show_refusal(self, analyst: Analyst, question: Query, said: str) -> None:
        if analyst is self._analyst:
            self._refuse(question, said)

    def _show_progress(self, token: object, progress: Searched | str) -> None:
        if token is not self._token:
            return
        if isinstance(progress, str):
            self.preparing.emit(progress)
        else:
            self.searched.emit(progress)

    def _refuse(self, question: Query, said: str) -> None:
        """Report why there is no answer."""
        self.refused.emit(question, said)
        if question.has_notice:
            self._notices.warn(said)


class QueryStream(QObject):
    """One asker's questions to the analyst: one at a time, the newest next.

    Each question that is asked gets one answer or one refusal, unless a newer one replaces it
    before it is asked. An answer that is known, or that another asker gets, is its answer, too.

    Args:
        analysis: takes the questions.
        parent: the Qt parent; this object is deleted with it.
        seen: whether it asks from the beginning, else once its card is visible.
    """

    answered = pyqtSignal(object, object)
    """A question, and its reply."""
    refused = pyqtSignal(str)
    """Why there is no reply."""
    preparing = pyqtSignal(str)
    """Preparations before the expected answer, as compiling."""

    _askers = count(1)

    def __init__(
        self, analysis: Analysis, parent: QObject | None = None, *, seen: bool = False
    ) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._asker = next(self._askers)
        self._seen = seen
        self.forget()
        analysis.answered.connect(self._take_answer)
        analysis.refused.connect(self._take_refusal)
        analysis.preparing.connect(self._show_preparing)

    @property
    def is_waiting(self) -> bool:
        """Whether an answer is expected."""
        return self._asked is not None or (self._seen and bool(self._wanted))

    def ask(self, *questions: Query) -> None:
        """Ask questions in turn; they replace those that wait."""
        self._wanted = [*questions]
        self._send()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._seen = seen
        self._send()

    def forget(self) -> None:
        """Drop questions: another flight begins."""
        self._wanted: list[Query] = []
        self._asked: Query | None = None

    def _send(self) -> None:
        while self._seen and self._wanted and self._asked is None:
            question = replace(self._wanted.pop(0), asker=self._asker)
            known = self._analysis.known(question)
            if known is None:
                self._asked = question
                self._analysis.ask(question)
            else:
                self.answered.emit(question, known)

    def _take_answer(self, question: Query, reply: object) -> None:
        if self._asked is not None and self._asked.same(question):
            self._asked = None
            self.answered.emit(question, reply)
            self._send()

    def _take_refusal(self, question: Query, said: str) -> None:
        if self._asked is not None and self._asked.same(question):
            self._asked = None
            self.refused.emit(said)
            self._send()

    def _show_preparing(self, said: str) -> None:
        if self.is_waiting:
            self.preparing.emit(said)


def query_key(part: object) -> Hashable:
    """Return a question, or a part of one, as the key of a dictionary."""
    if isinstance(part, Query):
        values = (getattr(part, field.name) for field in fields(part) if field.compare)
        return type(part), *map(query_key, values)
    return frozenset(part.items()) if isinstance(part, Mapping) else part
