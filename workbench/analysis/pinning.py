"""Writes what was tuned as a regression that later flights are held to."""

from workbench.analysis.questions import Pin
from workbench.analysis.replies import Pinned
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.pin import pin_step


def pin(subject: Subject, question: Pin, work: Work) -> Working:
    """Answer where the spec and its baseline are; what was written is green."""
    step = question.step
    found = pin_step(
        question.path,
        subject.scenario,
        subject.flown_gains(question.gains),
        step.axis,
        step.amplitude,
        duration=step.duration,
        margins=question.margins,
        overwrite=question.overwrite,
        progress=work.check,
    )
    loops = f" and the margins of {found.loops} loops" if found.loops else ""
    said = (
        f"{found.limits} numbers and {found.curves} curves of a step along {step.axis}{loops} are "
        "held to what they are now"
    )
    yield Pinned(found.spec, found.baseline, said)
