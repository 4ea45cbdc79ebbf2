"""How a flight goes on from an instant, each branch with gains of its own."""

from workbench.analyst.questions import Fork
from workbench.analyst.replies import Forked
from workbench.analyst.subject import Subject
from workbench.analyst.work import Work, Working


def fork(subject: Subject, question: Fork, work: Work) -> Working:
    """Answer how the flight goes on from an instant with each branch's values, to the bit."""
    flown = subject.forker.fly(
        question.instant,
        question.branches,
        question.duration,
        question.step,
        lambda: work.stopped,
    )
    work.check()
    yield Forked(flown)
