"""From wishes to gains: the plan, the search, the proof, and the result."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import not_repeatable
from workbench.design.linear.operating_point import Triple
from workbench.design.linear_step import DecayTimes
from workbench.design.response_metrics import NUMBERS, StepMetrics, step_duration
from workbench.design.step_response import HOVER
from workbench.design.tune.case import NOMINAL, Case, Robustness, corners
from workbench.design.tune.conflict import Unmet, conflicts
from workbench.design.tune.evaluation import (
    Budget,
    Candidate,
    Evaluation,
    Problem,
    SearchEndedError,
    quantity,
)
from workbench.design.tune.measure import Instruments, Responses, Step
from workbench.design.tune.proof import Proof, case_metrics, flights_to_fly, prove
from workbench.design.tune.requirement import (
    Requirement,
    completed,
    default_wishes,
    guarded_quantities,
    guards,
    requirements,
    shortfall,
    softened,
    wished_quantities,
)
from workbench.design.tune.search import ENOUGH, find
from workbench.design.tune.tuning import Listener, Result, Telling, Tuning, worst_of_each
from workbench.design.tune.variables import (
    Variables,
    counterparts,
    loop_of,
    loops_for,
    mirrored,
    symmetric,
    variables_for,
)
from workbench.design.tune.wish import DEFAULT, GUARD, Wish, Wishes, members, merged
from workbench.gains.gains import make_profile, rule_gains
from workbench.plant.variation import Variation
from workbench.scenario.axes import find_axis
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import Scenario, at_own_period, flown_controller

ROUNDS = 6
"""Number of repeated searches, with an omitted corner or with the results of the proof."""
EVALUATIONS = 600
"""Default number of candidates of a run."""
LONGEST = 20.0
"""Longest duration of a step in the search [s]."""
RISES, SETTLINGS = 4.0, 2.0
"""Duration of a step, as multiples of the wished rise time and settling time."""


@dataclass(frozen=True)
class Plan:
    """The plan of a run.

    Attributes:
        scenario: its vehicle and rates.
        settings: given parameter values.
        wishes: all of them.
        problem: with all its requirements, in all cases.
        starts: initial points (n): the rule's gains, then the given ones.
        at_rule: values of all requirements (R) with the rule's gains.
        remarks: on omissions of the run.
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
    """Return the plan of a run.

    Args:
        scenario: its vehicle and rates.
        wishes: to meet.
        settings: initial parameter values.
        separate: whether gains of x and y, roll and pitch may differ on a symmetric vehicle.
        velocity: of the steady flight to tune for, in W (3) [m/s].
        telling: reports progress.

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
    tell("flying the law's own gains, compiled: up to a minute the first time on this machine", 0.1)
    instruments.steps = _steps(scenario, instruments, wishes, rule)
    tied = not separate and symmetric(law, rule, wishes.wishes)
    asked = mirrored(law, wishes.wishes) if tied else list(wishes.wishes)
    if wishes.defaults:
        quantities = wished_quantities(law)
        usual = requirements(quantities, [NOMINAL], wishes.robustness)
        reached = instruments.measure([rule], [quantity(each) for each in usual])[0]
        asked = completed(asked, default_wishes(quantities, reached.tolist()))
    asked = merged(asked)
    if not asked:
        raise WorkbenchError("there are no wishes: give a --wish, or leave --no-defaults out")
    variables = variables_for(
        law, [wish.subject for wish in asked], tied=tied, flown_set=instruments.flown_set
    )
    kept = _guards(instruments, asked, variables, rule, base)
    asked += kept
    cases, remarks = _flyable(instruments, corners(wishes.robustness), tell)
    problem = Problem(
        instruments, variables, base, requirements(asked, [NOMINAL, *cases], wishes.robustness)
    )
    tell(f"flying the law's own gains with {len(cases) + 1} vehicles", 0.6)
    problem = problem.demanding(softened(problem.requirements, problem.measured([rule])[0]))
    tell("flying the result", 0.9)
    return Plan(
        scenario=scenario,
        settings=dict(settings),
        wishes=tuple(wish for wish in asked if wish.origin != GUARD),
        problem=problem,
        starts=(variables.point(rule), variables.point(base)),
        at_rule=problem.measured([rule])[0],
        remarks=tuple(remarks),
    )


def _steps(
    scenario: Scenario, instruments: Instruments, wishes: Wishes, rule: Mapping[str, float]
) -> dict[str, Step]:
    """Return the steps to fly, long enough for the vehicle and the wishes."""
    asked = {wish.subject for wish in wishes.wishes}
    asked |= {"x", "y"} if asked & {"x", "y"} else set()  # one represents both, see `mirrored`
    steps = {}
    decay_times = DecayTimes(scenario, instruments.point.velocity)
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
        slow = step_duration(decay_times.of(axis, rule))
        steps[axis] = Step(amplitude, min(LONGEST, max(slow, longest)))
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
    sought = [quantity(each) for each in requirements(quantities, [NOMINAL], Robustness())]
    if not sought:
        return []
    reached, present = instruments.measure([rule, base], sought)
    return guards(reached.tolist(), present.tolist(), quantities)


def _flyable(
    instruments: Instruments, cases: list[Case], tell: Callable[[str, float], None]
) -> tuple[list[Case], list[str]]:
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


@dataclass(frozen=True)
class Solution:
    """The result of a search.

    Attributes:
        gains: the tuned ones.
        values: of all requirements of the plan (R).
        proof: None if the wishes are not met, or the full diagram does not agree.
        problem: of the last search.
        best: its best candidate.
        smallest: for each widened requirement, the best value of a candidate that met all others.
    """

    gains: Mapping[str, float]
    values: np.ndarray
    proof: Proof | None
    problem: Problem
    best: Candidate
    smallest: Mapping[Requirement, float]

    @property
    def proved(self) -> bool:
        """Whether all requirements of the search are met, on the full diagram as well."""
        return self.best.met and self.proof is not None and not self.proof.missed


class Solver:
    """Solves one plan.

    Args:
        plan: of the run.
        budget: of all its searches.
        seed: of random points, for the case that no start leads to a solution.
        telling: reports progress.
    """

    def __init__(
        self, plan: Plan, budget: Budget, seed: int, telling: Telling | None = None
    ) -> None:
        self._plan = plan
        self._budget = budget
        self._seed = seed
        self._telling = telling or Telling()
        self._smallest: dict[Requirement, float] = {}

    def solve(self) -> Solution:
        """Return gains that meet all requirements, or the best ones found."""
        whole = self._plan.problem
        cases = self._first_cases()
        starts = list(self._plan.starts)
        for _ in range(ROUNDS):
            problem = whole.demanding([r for r in whole.requirements if r.case in cases])
            best = self._searched(problem, starts)
            gains = self._tidy(problem, best)
            values = whole.measured([{**whole.base, **gains}])[0]
            found = Solution(gains, values, None, problem, best, self._smallest)
            if not best.met:
                return found
            missed = [
                required
                for required, value in zip(whole.requirements, values, strict=True)
                if not required.met(value)
            ]
            starts = [best.point, *self._plan.starts]
            if missed:
                cases |= {required.case for required in missed}
                continue
            proof = self._proof(whole, gains, values)
            if not proof.missed:
                return dataclasses.replace(found, proof=proof)
            whole = _corrected(whole, proof, values)
        return found

    def _first_cases(self) -> set[Case]:
        """Return the vehicle as described and, for each wish, the corner worst under the rule."""
        required = self._plan.problem.requirements
        values = self._plan.at_rule
        worst: dict[object, tuple[float, Case]] = {}
        for each, value in zip(required, values, strict=True):
            reserve = each.reserve(value)
            if each.case != NOMINAL and reserve < worst.get(each.wish, (np.inf, NOMINAL))[0]:
                worst[each.wish] = (reserve, each.case)
        return {NOMINAL, *(case for _, case in worst.values())}

    def _searched(self, problem: Problem, starts: list[np.ndarray]) -> Candidate:
        """Return the best candidate of a problem."""

        def heard(best: Candidate) -> None:
            self._telling.search(problem, best, self._budget)

        evaluation = Evaluation(problem, self._budget, heard, ENOUGH)
        best = find(evaluation, starts, self._seed)
        self._note_smallest(problem, evaluation.seen)
        return best

    def _note_smallest(self, problem: Problem, seen: list[Candidate]) -> None:
        """Note the best value of each widened requirement among candidates that met all others."""
        reserves = np.array([candidate.reserves for candidate in seen])
        for index, required in enumerate(problem.requirements):
            if required.widened is None:
                continue
            others = np.delete(reserves, index, axis=1)
            good = np.flatnonzero((others >= 0.0).all(axis=1))
            if len(good):
                best = seen[max(good, key=lambda row: reserves[row, index])]
                self._smallest[required] = float(best.values[index])

    def _tidy(self, problem: Problem, best: Candidate) -> dict[str, float]:
        """Return the gains of a candidate with few digits, or with all if needed."""
        rounded = problem.variables.rounded(best.point)
        values = problem.measured([{**problem.base, **rounded}])[0]
        pairs = zip(problem.requirements, values, strict=True)
        if best.met and not all(required.met(value) for required, value in pairs):
            return problem.variables.gains(best.point)
        return rounded

    def _proof(self, whole: Problem, gains: Mapping[str, float], values: np.ndarray) -> Proof:
        """Return the proof of gains on the full diagram."""
        reserves = {
            required: required.reserve(value)
            for required, value in zip(whole.requirements, values, strict=True)
        }
        return prove(
            self._plan.scenario,
            {**self._plan.settings, **gains},
            whole.instruments.steps,
            whole.requirements,
            flights_to_fly(whole.requirements, reserves),
            self._telling.prove,
            whole.instruments.point.velocity,
        )


def _corrected(whole: Problem, proof: Proof, values: np.ndarray) -> Problem:
    """Return the problem, corrected by the differences between full diagram and instruments."""
    measured = dict(zip(whole.requirements, values, strict=True))
    corrections = dict(whole.corrections)
    for required, value in proof.values:
        if np.isfinite(value) and np.isfinite(measured[required]):
            corrections[required] = corrections.get(required, 0.0) + value - measured[required]
    return dataclasses.replace(whole, corrections=corrections)


class Tuner:
    """One run from wishes to gains.

    Args:
        scenario: its vehicle and rates.
        wishes: to meet; None for those that follow from the vehicle.
        settings: initial parameter values.
        separate: whether gains of x and y, roll and pitch may differ on a symmetric vehicle.
        evaluations: largest number of candidates.
        seconds: longest time of the search [s].
        seed: of random points, for the case that no start leads to a solution; equal seeds yield
            equal runs.
        velocity: of the steady flight to tune for, in W (3) [m/s]: loops are judged there, and
            steps begin from it. Of scheduled gains, only the set active there changes.

    Raises:
        WorkbenchError: if the scenario varies the vehicle, which the search does by itself, or a
            wish is about something that its controller does not have.
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        wishes: Wishes | None = None,
        *,
        settings: Mapping[str, float] | None = None,
        separate: bool = False,
        evaluations: int = EVALUATIONS,
        seconds: float = math.inf,
        seed: int = 0,
        velocity: Triple = HOVER,
    ) -> None:
        self._scenario = at_own_period(scenario or Scenario())
        self._controller = flown_controller(self._scenario)
        if self._controller.program:
            raise not_repeatable(self._controller.name)
        if self._scenario.vehicle.variation != Variation():
            raise WorkbenchError(
                "tuning varies the vehicle on its own: leave the variation out, or say how far it "
                "goes under 'robustness' in a wishes file"
            )
        self._wishes = wishes or Wishes()
        for wish in self._wishes.wishes:
            members(wish.subject, wish.metric, self._controller)
        self._settings = dict(settings or {})
        self._separate = separate
        self._velocity = velocity
        if any(velocity):
            self._refuse_hold()
        self._seed = seed
        self._budget = Budget(evaluations, seconds)

    def _refuse_hold(self) -> None:
        """Reject wishes about a held position, as a flight at a velocity has none."""
        for wish in self._wishes.wishes:
            loop = loop_of(self._controller, wish.subject)
            if loop is not None and loop.hold:
                raise WorkbenchError(
                    f"{wish}: the position is held in hover only: leave the wish out, or tune in "
                    "hover"
                )

    @property
    def vehicle(self) -> str:
        """Name of the vehicle.

        Raises:
            WorkbenchError: if it cannot be read.
        """
        return configured_vehicle(self._scenario.vehicle).name

    def stop(self) -> None:
        """End the search soon; the best candidate so far is kept, checked and flown."""
        self._budget.told = True

    def run(self, listener: Listener | None = None) -> Tuning:
        """Return the result.

        Args:
            listener: called with progress and the best candidate so far.

        Raises:
            WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
        """
        telling = Telling(listener)
        plan = make_plan(
            self._scenario,
            self._wishes,
            self._settings,
            separate=self._separate,
            velocity=self._velocity,
            telling=telling,
        )
        found = Solver(plan, self._budget, self._seed, telling).solve()
        if not found.proved:
            found = self._without_defaults(plan, found, telling)
        unmet = Unmet() if found.best.met else self._unmet(plan, found, telling)
        if unmet.nearest is not None:
            found = _nearest_reported(plan, found, unmet.nearest)
        telling.finish("flying the steps for the report")
        return self._tuning(plan, found, unmet)

    def _without_defaults(self, plan: Plan, found: Solution, telling: Telling) -> Solution:
        """Return gains that meet what was wished and not all defaults; else the given solution."""
        whole = plan.problem
        kept = [each.wish.origin != DEFAULT for each in whole.requirements]
        if all(kept) or not any(wish.is_written for wish in plan.wishes):
            return found
        wished = dataclasses.replace(
            plan,
            problem=whole.demanding(list(compress(whole.requirements, kept))),
            starts=(found.best.point, *plan.starts),
            at_rule=plan.at_rule[kept],
        )
        budget = dataclasses.replace(
            self._budget.part(self._budget.evaluations), seconds=self._budget.seconds
        )
        better = Solver(wished, budget, self._seed, telling).solve()
        if not better.proved:
            return found
        values = whole.measured([{**whole.base, **better.gains}])[0]
        return dataclasses.replace(better, values=values)

    def _unmet(self, plan: Plan, found: Solution, telling: Telling) -> Unmet:
        """Return the conflicts; none if the run was stopped.

        It takes thousands of flights, too long if each is on the full diagram.
        """
        if not plan.problem.instruments.compiles:
            return Unmet()
        starts = [found.best.point, *plan.starts]
        try:
            along_x = counterparts(self._controller)
            return conflicts(found.problem, starts, self._budget, along_x, telling.explain)
        except SearchEndedError:
            return Unmet()

    def _tuning(self, plan: Plan, found: Solution, unmet: Unmet) -> Tuning:
        """Return the result of the run."""
        problem = plan.problem
        gains = {**problem.base, **found.gains}
        before = problem.measured([problem.base])[0]
        axes = dict.fromkeys(wish.subject for wish in plan.wishes if wish.is_flown)
        cases = dict.fromkeys(required.case for required in problem.requirements)
        decay_times = DecayTimes(plan.scenario, problem.instruments.point.velocity)
        responses, measured = {}, {}
        for case in cases:
            for axis in axes:
                decays = [
                    decay_times.of(axis, each, case.variation) for each in (problem.base, gains)
                ]
                flown = problem.instruments.responses(
                    [problem.base, gains], axis, case, max(map(step_duration, decays))
                )
                responses[axis, case] = flown
                step = problem.instruments.steps[axis]
                measured[axis, case] = _measured(flown, step, decays, case)
        results, withheld = _results(plan, measured, before, found.values)
        required = [result.required for result in results]
        return Tuning(
            vehicle=problem.instruments.vehicle.name,
            controller=self._controller,
            wishes=plan.wishes,
            steps=problem.instruments.steps,
            results=results,
            before={name: problem.base[name] for name in found.gains},
            gains=found.gains,
            profile=make_profile(
                problem.instruments.vehicle, gains, _origin(plan), self._controller
            ),
            proof=found.proof,
            conflicts=unmet.measured(required, [result.after for result in results]),
            shortfalls=_shortfalls(results, found.smallest),
            remarks=(*plan.remarks, *withheld),
            responses=responses,
            evaluations=self._budget.spent,
            stopped=self._budget.stopped,
        )


def _nearest_reported(plan: Plan, found: Solution, nearest: Candidate) -> Solution:
    """Return the solution with the gains and values reported in conflicts."""
    whole = plan.problem
    gains = whole.variables.rounded(nearest.point)
    values = whole.measured([{**whole.base, **gains}])[0]
    return dataclasses.replace(found, gains=gains, values=values, best=nearest)


def _measured(
    flown: Responses, step: Step, decays: Sequence[float], case: Case
) -> list[StepMetrics | None]:
    """Return the metrics of steps, each as long as `workbench step` flies it; None if lost."""
    found: list[StepMetrics | None] = []
    for response, decay, lost in zip(flown.response, decays, flown.diverged, strict=True):
        kept = flown.time <= step_duration(decay) + 1e-9
        metrics = case_metrics(flown.time[kept], response[kept], step.amplitude, decay, case)
        found.append(None if lost else metrics)
    return found


def _results(
    plan: Plan,
    measured: Mapping[tuple[str, Case], list[StepMetrics | None]],
    before: np.ndarray,
    after: np.ndarray,
) -> tuple[tuple[Result, ...], list[str]]:
    """Return all requirements before and after.

    Args:
        plan: of the run.
        measured: metrics of the steps before and after, by axis and case.
        before: values of the requirements in the search (R).
        after: likewise.

    Returns:
        These, and why numbers are withheld, a sentence each.
    """
    found = []
    for required, *values in zip(plan.problem.requirements, before, after, strict=True):
        name = required.wish.metric.name
        steps = measured.get((required.wish.subject, required.case), [])
        if name in NUMBERS:
            for place, each in enumerate(steps):
                values[place] = getattr(each, name) if each else values[place]
        found.append(Result(required, *map(float, values)))
    said = [
        f"numbers of the {axis} step {when}, {case}, are withheld: {each.withheld}"
        for place, when in enumerate(("before", "after"))
        for (axis, case), steps in measured.items()
        if (each := steps[place]) and each.withheld
    ]
    return tuple(found), said


def _shortfalls(
    results: Sequence[Result], smallest: Mapping[Requirement, float]
) -> tuple[str, ...]:
    """Return a sentence for the worst case of each default that was widened."""
    gave_way = [
        each
        for each in results
        if each.required.widened is not None and not each.required.meets_unwidened(each.after)
    ]
    return tuple(
        shortfall(each.required, each.after, _best_of(each, smallest))
        for each in worst_of_each(gave_way)
    )


def _best_of(result: Result, smallest: Mapping[Requirement, float]) -> float:
    """Return the best value reached, with the gains found or by another candidate."""
    known = smallest.get(result.required, result.after)
    better = max if result.required.wish.at_least else min
    return better(known, result.after)


def tune(
    wishes: Wishes | None = None,
    scenario: Scenario | None = None,
    *,
    settings: Mapping[str, float] | None = None,
    evaluations: int = EVALUATIONS,
    seed: int = 0,
    velocity: Triple = HOVER,
    listener: Listener | None = None,
) -> Tuning:
    """Return gains that meet wishes, or the conflicts between wishes.

    Args:
        wishes: to meet, see `wishes_for`; None for those that follow from the vehicle.
        scenario: its vehicle and rates.
        settings: initial parameter values.
        evaluations: largest number of candidates.
        seed: equal seeds yield equal runs.
        velocity: of the steady flight to tune for, in W (3) [m/s].
        listener: called with progress and the best candidate so far.

    Raises:
        WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
    """
    tuner = Tuner(
        scenario,
        wishes,
        settings=settings,
        evaluations=evaluations,
        seed=seed,
        velocity=velocity,
    )
    return tuner.run(listener)


def _origin(plan: Plan) -> str:
    """Return the origin of tuned gains, for their file."""
    wished = [str(wish) for wish in plan.wishes if wish.is_written]
    for_what = "; ".join(wished) if wished else "the wishes that follow from the vehicle"
    point = plan.problem.instruments.point
    return f"tuned for {for_what}{f', at {point.label}' if any(point.velocity) else ''}"
