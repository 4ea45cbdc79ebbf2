"""What a run is to do: wishes made whole, vehicles to fly, gains to change, where to begin."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.linear.operating_point import Triple
from workbench.design.metrics import STEP, find_metric
from workbench.design.step_response import HOVER
from workbench.design.tune.case import NOMINAL, Case, Robustness, corners
from workbench.design.tune.evaluation import Problem, quantity
from workbench.design.tune.measure import Instruments, Quantity, Step
from workbench.design.tune.requirement import Requirement, requirements
from workbench.design.tune.tuning import Telling
from workbench.design.tune.variables import (
    Variables,
    loop_of,
    loops_for,
    mirrored,
    symmetric,
    variables_for,
)
from workbench.design.tune.wish import DEFAULT, GUARD, Wish, Wishes, merged
from workbench.gains.gains import rule_gains
from workbench.scenario.axes import AXES, find_axis
from workbench.scenario.scenario import Scenario

OVERSHOOT = 5.0
STEADY_STATE_ERROR = 5.0
"""Most [%]."""
PHASE_MARGIN = math.radians(40.0)
DISK_MARGIN = 0.6
"""Least."""
SLOWER = 1.3
"""A rise may take so many times as long as with the rule's gains."""
ROOM = 0.9
"""Where the rule's gains do not reach a limit, it is what they reach, and so much room."""
DIGITS = 3
SHORTEST, LONGEST = 3.0, 20.0
RULE_SETTLINGS = 3.0
"""A step is flown so many times as long as it takes to settle with the rule's gains, within these
[s]."""
RISES, SETTLINGS = 4.0, 2.0
"""And so many times what is wished of its rise and settling."""


def wished_quantities(law: Controller) -> list[Wish]:
    """Return the default wishes with the limits that any good flight keeps.

    The loops are those that are closed while a pilot steers.

    Args:
        law: whose loops.
    """
    limits = {
        "rise_time": math.inf,
        "overshoot": OVERSHOOT,
        "steady_state_error": STEADY_STATE_ERROR,
    }
    wishes = [
        Wish(axis, find_metric(name), False, limit)
        for axis in AXES
        for name, limit in limits.items()
    ]
    margins = {"phase_margin": PHASE_MARGIN, "disk_margin": DISK_MARGIN}
    wishes += [
        Wish(loop.name, find_metric(name), True, least)
        for loop in law.loops
        if not loop.hold
        for name, least in margins.items()
    ]
    return wishes


def default_wishes(quantities: Sequence[Wish], reached: Sequence[float]) -> list[Wish]:
    """Return the default wishes for a vehicle.

    Args:
        quantities: see `wished_quantities`.
        reached: value of each with the rule's gains.
    """
    found = []
    for wish, value in zip(quantities, reached, strict=True):
        bound = wish.bound
        if wish.metric.name == "rise_time":
            bound = SLOWER * value
        elif not Requirement(wish, NOMINAL, bound).met(value):
            bound = _with_room(wish, value)
        if math.isfinite(bound) and wish.metric.minimum <= bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=float(f"{bound:.{DIGITS}g}")))
    return found


def completed(wishes: Sequence[Wish], defaults: Sequence[Wish]) -> list[Wish]:
    """Return wishes and those defaults whose number nobody has a wish about."""
    named = {wish.name for wish in wishes}
    return [*wishes, *(wish for wish in defaults if wish.name not in named)]


def guards(
    reached: Sequence[float], present: Sequence[float], quantities: Sequence[Wish]
) -> list[Wish]:
    """Return wishes that keep the margins of loops which nobody asked about.

    Each keeps 90 % of the smaller of what it has now and what it has with the rule's gains: a loop
    that is slow now has more than it needs, and must not stay slow for it. One that a wished step
    goes through keeps no more than the usual margins.

    Args:
        reached: value of each quantity with the rule's gains.
        present: and with the gains that the run starts from.
        quantities: see `guarded_quantities`.
    """
    found = []
    for wish, rule, now in zip(quantities, reached, present, strict=True):
        bound = min(wish.bound, ROOM * min(rule, now))
        if wish.metric.minimum < bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=bound))
    return found


def guarded_quantities(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return the margins of loops that no written wish names, with the most that is kept of them.

    Args:
        law: whose loops.
        wishes: all of them; where a default limits a loop that a wished step goes through, that
            will do.
    """
    usual = {"phase_margin": PHASE_MARGIN, "disk_margin": DISK_MARGIN}
    known = {wish.name for wish in wishes}
    asked = [wish.subject for wish in wishes if wish.is_written]
    named = {loop.name for loop in (loop_of(law, each) for each in asked) if loop}
    through = {loop.name for loop in law.loops if not loop.hold and loop.axis in asked}
    found = []
    for loop in (loop.name for loop in law.loops if loop.name not in named):
        for name, least in usual.items():
            bound = least if loop in through else math.inf
            wish = Wish(loop, find_metric(name), True, bound, GUARD)
            if loop not in through or wish.name not in known:
                found.append(wish)
    return found


def softened(required: Sequence[Requirement], reached: np.ndarray) -> list[Requirement]:
    """Return requirements, those of default wishes in corners no harder than the rule manages.

    Args:
        required: by all wishes in all cases (R).
        reached: their values with the rule's gains (R).
    """
    found = []
    for requirement, value in zip(required, reached, strict=True):
        wish = requirement.wish
        if wish.origin == DEFAULT and requirement.case != NOMINAL and not requirement.met(value):
            bound = _with_room(wish, float(value))
            if not math.isfinite(bound) or (wish.at_least and bound <= 0.0):
                continue
            requirement = dataclasses.replace(requirement, bound=bound, widened=requirement.bound)
        found.append(requirement)
    return found


def _with_room(wish: Wish, value: float) -> float:
    """Return a limit that a value keeps."""
    return ROOM * value if wish.at_least else value / ROOM


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
    problem: Problem
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
    problem = Problem(
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
