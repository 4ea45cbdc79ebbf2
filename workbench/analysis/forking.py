"""How a flight goes on from a checkpoint, each branch with gains of its own."""

from workbench.analysis.questions import Fork
from workbench.analysis.replies import Forked
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working


def fork(subject: Subject, question: Fork, work: Work) -> Working:
    """Answer how the flight goes on from a checkpoint with each branch's values, to the bit."""
    flown = subject.forker.fly(
        question.checkpoint,
        question.branches,
        question.duration,
        question.step,
        lambda: work.stopped,
    )
    work.check()
    yield Forked(flown)
