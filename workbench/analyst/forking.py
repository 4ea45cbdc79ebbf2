"""How a flight goes on from an instant, each branch with gains of its own."""

from workbench.analyst.questions import Fork
from workbench.analyst.replies import Flown, Forked
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
    yield Forked(
        tuple(
            Flown(
                name=each.name,
                time=each.time,
                velocity=each.velocity,
                yaw_rate=each.yaw_rate,
                position=each.position,
                tilt=each.tilt,
                rotor_use=each.rotor_use,
                lost=each.lost,
            )
            for each in flown
        )
    )
