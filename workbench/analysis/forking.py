"""How a flight goes on from a checkpoint, each branch with gains or a controller of its own."""

from workbench.analysis.predicting import step_numbers
from workbench.analysis.questions import Fork
from workbench.analysis.replies import Forked, StepNumbers
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.branches import FlownBranch
from workbench.scenario.axes import AXES


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
    yield Forked(flown, tuple(_numbers(question, branch) for branch in flown))


def _numbers(question: Fork, branch: FlownBranch) -> StepNumbers | None:
    """Return the metrics of a branch's step, which goes on top of what was asked for before."""
    step, checkpoint = question.step, question.checkpoint
    if step is None or branch.lost:
        return None
    before = (*checkpoint.velocity, checkpoint.yaw_rate)[AXES.index(step.axis)]
    return step_numbers(
        branch.time - checkpoint.time,
        branch.response(step.axis) - before,
        step.amplitude,
        float(branch.rotor_use.max()),
    )
