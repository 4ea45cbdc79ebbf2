"""Finds the gains of one loop that bring a pole to a place, and says what is in the way."""

from workbench.analysis.questions import MovePole
from workbench.analysis.replies import PoleMoved
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.control.controller import Controller
from workbench.design.judge.pole_placing import Placed, PolePlacer, state_shares
from workbench.design.linear.model import LinearModel

HOLDERS = (
    (("speed_",), "rotor lag"),
    (("command_",), "delay"),
    (("filtered_", "derivative_lowpass", "setpoint_lowpass", "gyro_", "accel_"), "filters"),
    (("imu_", "wdot_", "vdot_"), "the hold between updates"),
    (("estimated_",), "the estimator"),
)
"""How names of states begin, and what they belong to, in words."""


def move_pole(subject: Subject, question: MovePole, _: Work) -> Working:
    """Answer which gains bring it there, or the nearest."""
    placer = _placer(subject, question)
    yield None
    found = placer.place(question.place)
    names = subject.asked_names(question.gains)
    yield PoleMoved(
        asked=question,
        gains={names.get(name, name): value for name, value in found.gains.items()},
        pole=found.pole,
        reached=found.reached,
        said="" if found.reached else _said(subject, question, found),
    )


def _placer(subject: Subject, question: MovePole) -> PolePlacer:
    """Return what moves the pole; while only its place changes, it is the same."""
    gains = subject.gains(question.gains)
    linked = subject.linked(question.linked)
    loop = subject.table.controller.loop(question.loop)
    made = subject.placer
    key = (loop, gains, linked, question.pole)
    if made is None or made[0] != key:
        placer = PolePlacer(subject.model, loop.gains, gains, subject.table, question.pole, linked)
        made = subject.placer = key, placer
    return made[1]


def _said(subject: Subject, question: MovePole, found: Placed) -> str:
    """Return what is in the way of a pole."""
    name = question.loop.replace("_", " ")
    law = subject.table.controller
    model = subject.model({**subject.gains(question.gains), **found.gains})
    if found.unmoved:
        return f"No gain of {name} moves this pole: it is of {_holder(law, model, found.pole)}."
    if found.limit:
        row = subject.table.find(found.limit)
        at_least = abs(found.gains[row.name] - row.minimum) < 1e-6 * row.maximum
        end = "smallest" if at_least else "largest"
        return f"As near as it goes: {row.name} is at its {end} value."
    if len(law.loop(question.loop).gains) == 1:
        return f"As near as it goes: {name} has one gain, which moves it along one line."
    holder = _holder(law, model, found.pole)
    return f"As near as the gains of {name} bring it: it is of {holder}, too."


def _holder(law: Controller, model: LinearModel, pole: complex) -> str:
    """Return what takes most part in a pole, in words."""
    remembered = {state.name for state in law.memory}
    shares: dict[str, float] = {}
    for name, share in zip(model.state_names, state_shares(model, pole), strict=True):
        words = next((each for begins, each in HOLDERS if name.startswith(begins)), "another loop")
        if name in remembered:
            words = "what the law remembers"
        shares[words] = shares.get(words, 0.0) + share
    return max(shares, key=lambda words: shares[words])
