"""Stability of the hover with given gains, and the gains of one loop for a margin or a pole.

Margins, poles, and stable ranges of gains describe the stability. The gains of a loop come with a
sentence about what limits them.
"""

from collections.abc import Mapping

from workbench.analysis.queries import (
    DrawFrequency,
    Judge,
    JudgePlantInput,
    PlanMeasurement,
)
from workbench.analysis.replies import Judged, JudgedLoop
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.control.loop import loop_label
from workbench.design.judge.gang_of_four import gang_of_four
from workbench.design.judge.loop_judgement import growing_loops, hover_margins, opened_to_steer
from workbench.design.judge.loop_measurement import loop_injection
from workbench.design.judge.margins import LoopMargins
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.judge.phase_budget import PHASE_BUDGET_PARTS
from workbench.design.judge.pole_loops import located_poles
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING_POINT, HOVER_POINT

PhaseByCause = tuple[tuple[str, float], ...]
"""Phase by the name of its cause [rad]."""


def judge_gains(subject: AnalysedVehicle, question: Judge, _: Work) -> Working:
    """Compute the stability with given gains.

    Poles are those of the sampled loop that flies, in continuous terms, s = ln(z) / period, while
    the place is held: then every gain affects some of them.
    """
    holding = subject.model(subject.gains(question.gains))
    steering = opened_to_steer(holding)
    margins = hover_margins(holding)
    stable = all(each.stable for each in margins.values())
    steered = () if stable else growing_loops(steering)
    held = () if stable or steered else growing_loops(holding)
    growing = steered + held
    turned = (
        _phase_by_cause(subject, (steering, holding), margins, question.gains) if stable else {}
    )
    joints = [name for name, _ in subject.study.vehicle.small_joint_signals]
    located = located_poles(holding, joints)
    yield Judged(
        loops=tuple(
            JudgedLoop(
                **vars(margins[each.name]),
                name=each.name,
                growing=each.name in growing,
                turned=turned.get(each.name, ()),
            )
            for each in holding.loops
        ),
        poles=located.values,
        stable=stable,
        said=_instability_text(steered, held),
        pole_loops=located.loops,
        pole_joints=located.joints,
    )


def judge_plant_input(subject: AnalysedVehicle, question: JudgePlantInput, _: Work) -> Working:
    """Compute the disk margin of simultaneous force and moments, as `workbench judge` does."""
    gains = subject.linear_gains(question.gains)
    found = []
    for point in (HOVER_POINT, HOLDING_POINT):
        found.append(multiloop_margin(subject.study.plant_input(point, gains)).disk_margin)
        yield None
    yield tuple(found)


def draw_frequency(subject: AnalysedVehicle, question: DrawFrequency, _: Work) -> Working:
    """Compute the frequency response of one loop, of the model that margins are computed with.

    For a loop that holds a place, the place is held; for all others the pilot steers.
    """
    loop = subject.controller.loop(question.loop)
    holding = subject.model(subject.gains(question.gains))
    yield gang_of_four(holding if loop.hold else opened_to_steer(holding), loop, question.cut)


def plan_measurement(subject: AnalysedVehicle, question: PlanMeasurement, _: Work) -> Working:
    """Plan the injection that a loop tolerates, by a model of the flight."""
    loop = subject.controller.loop(question.loop)
    gains, point = subject.linear_gains(question.gains), HOLDING_POINT if loop.hold else HOVER_POINT
    model = subject.study.sampled(point, gains)
    yield loop_injection(model, loop, subject.study.vehicle, question.cut), loop.hold


def _phase_by_cause(
    subject: AnalysedVehicle,
    models: tuple[LinearModel, LinearModel],
    margins: Mapping[str, LoopMargins],
    asked: Mapping[str, float],
) -> dict[str, PhaseByCause]:
    """Return the causes of phase lag and lead of each loop."""
    crossovers = {name: each.crossover for name, each in margins.items()}
    gains = subject.linear_gains(asked)
    return {
        budget.loop: tuple((part, getattr(budget, part)) for part in PHASE_BUDGET_PARTS)
        for model in models
        for budget in subject.phases.budgets(model, crossovers, gains)
    }


def _instability_text(steered: tuple[str, ...], held: tuple[str, ...]) -> str:
    """Return a sentence about what is unstable, "" if all is stable."""
    if steered:
        return f"unstable: a mode grows through {_joined_names(steered)}"
    return (
        f"holding the position is unstable: a mode grows through {_joined_names(held)}"
        if held
        else ""
    )


def _joined_names(names: tuple[str, ...]) -> str:
    words = [loop_label(name) for name in names]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
