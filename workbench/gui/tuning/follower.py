"""Asks the analyst no faster than it answers: one question in flight, the newest next."""

from typing import Any

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import Question
from workbench.gui.analysis import Analysis


class Follower(QObject):
    """Keeps the answer to a question that changes often.

    Args:
        analysis: to be asked.
        kind: of the questions.
        parent: the Qt parent; this object is deleted with it.
    """

    answered = pyqtSignal(object)
    """The reply to the question that was asked."""
    refused = pyqtSignal(str)
    """Why there is none."""
    preparing = pyqtSignal(str)
    """What is done before the answer that is waited for, as compiling."""

    def __init__(
        self, analysis: Analysis, kind: type[Question], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._kind = kind
        self._seen = False
        self._wanted: Question | None = None
        self._asked: Question | None = None
        self._known: Question | None = None
        analysis.answers[kind].connect(self._hear)
        analysis.refused.connect(self._hear_refusal)
        analysis.preparing.connect(self._hear_preparing)

    @property
    def is_waiting(self) -> bool:
        """Whether an answer is still to come."""
        return self._asked is not None

    def ask(self, question: Question) -> None:
        """Want the answer to a question; what was wanted before is not any more."""
        self._wanted = question
        self._send()

    def set_seen(self, seen: bool) -> None:
        """Ask only while somebody looks."""
        self._seen = seen
        self._send()

    def forget(self) -> None:
        """Want nothing, and take no answer for known: another flight begins."""
        self._wanted = self._asked = self._known = None

    def _send(self) -> None:
        question = self._wanted
        if not self._seen or question is None or self._asked is not None:
            return
        self._wanted = None
        if question == self._known:
            return
        self._asked = question
        self._analysis.ask(question)

    def _hear(self, reply: Any) -> None:
        asked, self._asked = self._asked, None
        if asked is not None and reply.asked == asked:
            self._known = asked
            self.answered.emit(reply)
        elif asked is not None and self._wanted is None:
            self._wanted = asked  # another's question may have taken the place of ours
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
