"""What a run is to do: wishes made whole, vehicles to fly, gains to change, where to begin."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import Triple
from workbench.design.metrics import STEP
from workbench.design.step_response import HOVER
from workbench.design.tune.case import NOMINAL, Case, Robustness, corners
from workbench.design.tune.default_wishes import (
    completed,
    default_wishes,
    guarded_quantities,
    guards,
    softened,
    wished_quantities,
)
from workbench.design.tune.measure import Instruments, Quantity, Step
from workbench.design.tune.problem import FlownProblem, quantity
from workbench.design.tune.requirement import requirements
from workbench.design.tune.telling import Telling
from workbench.design.tune.twins import mirrored, symmetric
from workbench.design.tune.variables import Variables, loops_for, variables_for
from workbench.design.tune.wish import GUARD, Wish, merged
from workbench.design.tune.wish_file import Wishes
from workbench.gains.gains import rule_gains
from workbench.scenario.axes import find_axis
from workbench.scenario.scenario import Scenario

SHORTEST, LONGEST = 3.0, 20.0
RULE_SETTLINGS = 3.0
"""A step is flown so many times as long as it takes to settle with the rule's gains, within these
[s]."""
RISES, SETTLINGS = 4.0, 2.0
"""And so many times what is wished of its rise and settling."""


@dataclass(frozen=True)
class Plan:
    """A run, before it begins.

    Attributes:
        scenario: its vehicle and rates.
        settings: parameter values that were given.
        wishes: all of them.
        problem: with all its requirements, in all cases.
        starts: points (n) to begin at: the rule's gains, then the given ones.
        at_rule: values of all requirements (R) with the rule's gains.
        remarks: what the run leaves out.
    """

    scenario: Scenario
    settings: Mapping[str, float]
    wishes: tuple[Wish, ...]
    problem: FlownProblem
    starts: tuple[np.ndarray, ...]
    at_rule: np.ndarray
    remarks: tuple[str, ...]


def make_plan(
    scenario: Scenario,
    wishes: Wishes,
    settings: Mapping[str, float],
    *,
    separate: bool,
    velocity: Triple = HOVER,
    telling: Telling | None = None,
) -> Plan:
    """Return what a run is to do.

    Args:
        scenario: its vehicle and rates.
        wishes: what is wished for.
        settings: parameter values that the run starts from.
        separate: whether x and y, roll and pitch may differ on a symmetric vehicle.
        velocity: of the steady flight that is tuned for, in W (3) [m/s].
        telling: tells of progress.

    Raises:
        WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
    """
    tell = (telling or Telling()).prepare
    tell("reading the vehicle", 0.0)
    instruments = Instruments(scenario, settings, velocity)
    law, base = instruments.controller, instruments.base
    rule = base | {
        name: value
        for name, value in rule_gains(instruments.vehicle, law).items()
        if any(name in loop.gains for loop in law.loops)
    }
    tell("flying the rule's gains, compiled: up to a minute if this machine never did", 0.1)
    instruments.steps = _steps(instruments, wishes, rule)
    tied = not separate and symmetric(law, rule, wishes.wishes)
    asked = mirrored(law, wishes.wishes) if tied else list(wishes.wishes)
    if wishes.defaults:
        quantities = wished_quantities(law)
        usual = requirements(quantities, [NOMINAL], wishes.robustness)
        reached = instruments.measure([rule], [quantity(each) for each in usual])[0]
        asked = completed(asked, default_wishes(quantities, reached.tolist()))
    asked = merged(asked)
    if not asked:
        raise WorkbenchError("nothing is wished for: give a --wish, or leave --no-defaults out")
    variables = variables_for(
        law, [wish.subject for wish in asked], tied=tied, flown_set=instruments.flown_set
    )
    kept = _guards(instruments, asked, variables, rule, base)
    asked += kept
    cases, remarks = _flyable(instruments, corners(wishes.robustness), tell)
    problem = FlownProblem(
        instruments, variables, base, requirements(asked, [NOMINAL, *cases], wishes.robustness)
    )
    tell(f"flying the rule's gains with {len(cases) + 1} vehicles", 0.6)
    problem = problem.demanding(softened(problem.requirements, problem.measured([rule])[0]))
    tell("flying what the requirements came to", 0.9)
    return Plan(
        scenario=scenario,
        settings=dict(settings),
        wishes=tuple(wish for wish in asked if wish.origin != GUARD),
        problem=problem,
        starts=(variables.point(rule), variables.point(base)),
        at_rule=problem.measured([rule])[0],
        remarks=tuple(remarks),
    )


def _steps(instruments: Instruments, wishes: Wishes, rule: Mapping[str, float]) -> dict[str, Step]:
    """Return the steps to fly, long enough for the vehicle and for what is wished."""
    asked = {wish.subject for wish in wishes.wishes}
    asked |= {"x", "y"} if asked & {"x", "y"} else set()  # one stands for both, see `mirrored`
    steps = {}
    for axis, amplitude in wishes.steps:
        if axis not in asked and not wishes.defaults:
            continue
        limit = instruments.base[find_axis(axis).limit]
        if abs(amplitude) > limit:
            amplitude = math.copysign(limit, amplitude)
        longest = max(
            [
                {"rise_time": RISES, "settling_time": SETTLINGS}.get(wish.metric.name, 0.0)
                * wish.bound
                for wish in wishes.wishes
                if wish.subject == axis
            ],
            default=0.0,
        )
        instruments.steps = {axis: Step(amplitude, LONGEST)}
        settling = Quantity(NOMINAL, STEP, axis, "settling_time")
        slow = RULE_SETTLINGS * float(instruments.measure([rule], [settling])[0, 0])
        steps[axis] = Step(amplitude, min(LONGEST, max(SHORTEST, slow, longest)))
    return steps


def _guards(
    instruments: Instruments,
    asked: Sequence[Wish],
    variables: Variables,
    rule: Mapping[str, float],
    base: Mapping[str, float],
) -> list[Wish]:
    """Return what keeps the loops that nobody asked about and that the search may change."""
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
    sought = [quantity(each) for each in requirements(quantities, [NOMINAL], Robustness())]
    if not sought:
        return []
    reached, present = instruments.measure([rule, base], sought)
    return guards(reached.tolist(), present.tolist(), quantities)


def _flyable(
    instruments: Instruments, cases: list[Case], tell: Callable[[str, float], None]
) -> tuple[list[Case], list[str]]:
    """Return the cases that can hover at all, and a remark on each other."""
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
