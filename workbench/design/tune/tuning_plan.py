"""What a tuning does: its requirements, its guards and the steps that it flies."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import Triple
from workbench.design.linear_step import DecayTimes
from workbench.design.step_metrics import step_duration
from workbench.design.step_response import REST_VELOCITY_M_S
from workbench.design.tune.case import NOMINAL_CASE, Robustness, VehicleCase, robustness_corners
from workbench.design.tune.evaluation import Problem
from workbench.design.tune.measure import Instruments, TuneStep
from workbench.design.tune.requirement import (
    completed_wishes,
    default_wishes,
    guard_wishes,
    guarded_quantities,
    requirements,
    softened_requirements,
    wished_quantities,
)
from workbench.design.tune.tuning import ProgressReporter
from workbench.design.tune.variables import (
    Variables,
    loops_for,
    mirrored_wishes,
    symmetric,
    variables_for,
)
from workbench.design.tune.wish import GUARD_ORIGIN, Wish, Wishes, merged_wishes
from workbench.gains.gain_choice import rule_gains
from workbench.scenario.axes import find_axis
from workbench.setup import Setup

MAX_SEARCH_STEP_S = 20.0
"""Longest duration of a step in the search [s]."""
RISE_TIMES_PER_STEP, SETTLING_TIMES_PER_STEP = 4.0, 2.0
"""Duration of a step, as multiples of the wished rise time and settling time."""


@dataclass(frozen=True)
class TuningPlan:
    """The plan of a run.

    Attributes:
        setup: the vehicle, its rates and given parameter values.
        wishes: all of them.
        problem: with all its requirements, in all cases.
        starts: initial points (n): the rule's gains, then the given ones.
        at_rule: values of all requirements (R) with the rule's gains.
        remarks: on omissions of the run.
    """

    setup: Setup
    wishes: tuple[Wish, ...]
    problem: Problem
    starts: tuple[np.ndarray, ...]
    at_rule: np.ndarray
    remarks: tuple[str, ...]


def make_plan(
    setup: Setup,
    wishes: Wishes,
    *,
    separate: bool,
    velocity: Triple = REST_VELOCITY_M_S,
    telling: ProgressReporter | None = None,
) -> TuningPlan:
    """Return the plan of a run.

    Args:
        setup: the vehicle, its rates and initial parameter values.
        wishes: to meet.
        separate: whether gains of x and y, roll and pitch may differ on a symmetric vehicle.
        velocity: of the steady flight to tune for, in W (3) [m/s].
        telling: reports progress.

    Raises:
        WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
    """
    tell = (telling or ProgressReporter()).prepare
    instruments = Instruments(setup, velocity)
    law, base = instruments.controller, instruments.base
    rule = dict(base) | {
        name: value
        for name, value in rule_gains(instruments.vehicle, law).items()
        if any(name in loop.gains for loop in law.loops)
    }
    compiled = "compiled: up to a minute the first time on this machine"
    how = compiled if instruments.compiles else "on the diagram, so it takes minutes"
    tell(f"flying the law's own gains, {how}", 0.1)
    instruments.steps = _planned_steps(setup, instruments, wishes, rule)
    tied = not separate and symmetric(law, rule, wishes.wishes)
    asked = mirrored_wishes(law, wishes.wishes) if tied else list(wishes.wishes)
    if wishes.defaults:
        quantities = wished_quantities(law)
        usual = requirements(quantities, [NOMINAL_CASE], wishes.robustness)
        reached = instruments.measure([rule], usual)[0]
        asked = completed_wishes(asked, default_wishes(quantities, reached.tolist()))
    asked = merged_wishes(asked)
    if not asked:
        raise WorkbenchError("there are no wishes: give a --wish, or leave --no-defaults out")
    variables = variables_for(
        law, [wish.subject for wish in asked], tied=tied, flown_set=instruments.flown_set
    )
    kept = _guards(instruments, asked, variables, rule, base)
    asked += kept
    cases, remarks = _flyable(instruments, robustness_corners(wishes.robustness), tell)
    problem = Problem(
        instruments, variables, base, requirements(asked, [NOMINAL_CASE, *cases], wishes.robustness)
    )
    tell(f"flying the law's own gains with {len(cases) + 1} vehicles", 0.6)
    problem = problem.demanding(
        softened_requirements(problem.requirements, problem.measured([rule])[0])
    )
    tell("flying the result", 0.9)
    return TuningPlan(
        setup=setup,
        wishes=tuple(wish for wish in asked if wish.origin != GUARD_ORIGIN),
        problem=problem,
        starts=(variables.point(rule), variables.point(base)),
        at_rule=problem.measured([rule])[0],
        remarks=tuple(remarks),
    )


def _planned_steps(
    setup: Setup, instruments: Instruments, wishes: Wishes, rule: Mapping[str, float]
) -> dict[str, TuneStep]:
    """Return the steps to fly, long enough for the vehicle and the wishes."""
    asked = {wish.subject for wish in wishes.wishes}
    asked |= (
        {"x", "y"} if asked & {"x", "y"} else set()
    )  # one represents both, see `mirrored_wishes`
    steps = {}
    decay_times = DecayTimes(setup, instruments.point.velocity)
    for axis, amplitude in wishes.steps:
        if axis not in asked and not wishes.defaults:
            continue
        limit = instruments.base[find_axis(axis).limit]
        if abs(amplitude) > limit:
            amplitude = math.copysign(limit, amplitude)
        longest = max(
            [
                {"rise_time": RISE_TIMES_PER_STEP, "settling_time": SETTLING_TIMES_PER_STEP}.get(
                    wish.metric.name, 0.0
                )
                * wish.bound
                for wish in wishes.wishes
                if wish.subject == axis
            ],
            default=0.0,
        )
        slow = step_duration(decay_times.of(axis, rule))
        steps[axis] = TuneStep(amplitude, min(MAX_SEARCH_STEP_S, max(slow, longest)))
    return steps


def _guards(
    instruments: Instruments,
    asked: Sequence[Wish],
    variables: Variables,
    rule: Mapping[str, float],
    base: Mapping[str, float],
) -> list[Wish]:
    """Return the guards of loops without a written wish that the search may change."""
    searched = {name for group in variables.groups for name in group}
    quantities = [
        wish
        for wish in guarded_quantities(instruments.controller, asked)
        if not (any(instruments.point.velocity) and instruments.holds(wish.subject))
        and any(
            name in searched
            for loop in loops_for(instruments.controller, wish.subject)
            for name in loop.gains
        )
    ]
    if not quantities:
        return []
    sought = requirements(quantities, [NOMINAL_CASE], Robustness())
    reached, present = instruments.measure([rule, base], sought)
    return guard_wishes(reached.tolist(), present.tolist(), quantities)


def _flyable(
    instruments: Instruments, cases: list[VehicleCase], tell: Callable[[str, float], None]
) -> tuple[list[VehicleCase], list[str]]:
    """Return the cases that can hover, and a remark on each of the others."""
    found, remarks = [], []
    for index, case in enumerate(cases):
        tell(f"linear model of vehicle {index + 1} of {len(cases)}", 0.2 + 0.4 * index / len(cases))
        try:
            instruments.models(case, instruments.point)
        except WorkbenchError as error:
            remarks.append(f"left out: {case}: {error}")
        else:
            found.append(case)
    return found, remarks
