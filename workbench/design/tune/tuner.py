"""From wishes to gains."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import not_repeatable
from workbench.design.linear.operating_point import Triple
from workbench.design.response_metrics import AT_THE_END, FROM_REST, response_metrics
from workbench.design.step_response import HOVER
from workbench.design.tune.case import NOMINAL, Case
from workbench.design.tune.conflict import Unmet, conflicts
from workbench.design.tune.evaluation import (
    Budget,
    Candidate,
    Evaluation,
    Problem,
    SearchEndedError,
)
from workbench.design.tune.measure import Responses
from workbench.design.tune.plan import Plan, make_plan
from workbench.design.tune.proof import Proof, flights_to_fly, prove
from workbench.design.tune.requirement import Requirement, shortfall
from workbench.design.tune.search import ENOUGH, find
from workbench.design.tune.tuning import Listener, Result, Telling, Tuning
from workbench.design.tune.variables import counterparts, loop_of
from workbench.design.tune.wish import Wish, Wishes, members
from workbench.gains.gains import make_profile
from workbench.plant.loading import make_vehicle
from workbench.plant.variation import Variation
from workbench.scenario.configured import read_configured
from workbench.scenario.scenario import Scenario, at_own_period, flown_controller

ROUNDS = 6
"""So often the search goes back: to a corner that it left out, or to what the proof has shown."""
EVALUATIONS = 600
"""Candidates that a run may look at, if not told otherwise."""


@dataclass(frozen=True)
class Solution:
    """Where a search has ended.

    Attributes:
        gains: those that were searched.
        values: of all requirements of the plan (R).
        proof: None if the wishes are not met, or the full diagram does not agree.
        problem: the last that was searched.
        best: its best candidate.
        smallest: of each requirement that gave way, the best value of a candidate that met all
            others.
    """

    gains: Mapping[str, float]
    values: np.ndarray
    proof: Proof | None
    problem: Problem
    best: Candidate
    smallest: Mapping[Requirement, float]


class Solver:
    """Solves one plan.

    Args:
        plan: what to do.
        budget: of all its searches.
        seed: of what is tried where no start leads to a solution.
        telling: tells of progress.
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
        """Return gains that meet all requirements, or the best that there are."""
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
            reserve = float(each.reserves(np.array([value]))[0])
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
        """Note how far each requirement that gave way was met by who met all others."""
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
        """Return the gains of a candidate with few digits, or with all where those are needed."""
        rounded = problem.variables.rounded(best.point)
        values = problem.measured([{**problem.base, **rounded}])[0]
        pairs = zip(problem.requirements, values, strict=True)
        if best.met and not all(required.met(value) for required, value in pairs):
            return problem.variables.gains(best.point)
        return rounded

    def _proof(self, whole: Problem, gains: Mapping[str, float], values: np.ndarray) -> Proof:
        """Return what the full diagram says of gains."""
        reserves = {
            required: float(required.reserves(np.array([value]))[0])
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
    """Return the problem with what the full diagram had more than the instruments added."""
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
        wishes: what is wished for; without, what follows from the vehicle.
        settings: parameter values that the run starts from.
        separate: whether x and y, roll and pitch may differ on a symmetric vehicle.
        evaluations: candidates that it may look at.
        seconds: that it may search.
        seed: of what is tried where no start leads there; equal seeds give equal runs.
        velocity: of the steady flight that is tuned for, in W (3) [m/s]: loops are judged there,
            and steps begin from it. Of scheduled gains, those of the set that flies there change.

    Raises:
        WorkbenchError: if the scenario varies the vehicle, which the search does on its own, or a
            wish is about what its controller has not.
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
        law = flown_controller(self._scenario)
        if law.program:
            raise not_repeatable(law.name)
        if self._scenario.vehicle.variation != Variation():
            raise WorkbenchError(
                "tuning varies the vehicle on its own: leave the variation out, or say how far it "
                "goes under 'robustness' in a wishes file"
            )
        self._wishes = wishes or Wishes()
        self._controller = flown_controller(self._scenario)
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
        """Refuse wishes about a held place, of which a flight on the way has none."""
        for wish in self._wishes.wishes:
            loop = loop_of(self._controller, wish.subject)
            if loop is not None and loop.hold:
                raise WorkbenchError(
                    f"{wish}: a place is held in hover only: leave the wish out, or tune in hover"
                )

    @property
    def vehicle(self) -> str:
        """Name of the vehicle.

        Raises:
            WorkbenchError: if it cannot be read.
        """
        return make_vehicle(read_configured(self._scenario.vehicle)).name

    def stop(self) -> None:
        """End the search soon; the best that was found so far is kept, checked and flown."""
        self._budget.told = True

    def run(self, listener: Listener | None = None) -> Tuning:
        """Return what is found.

        Args:
            listener: hears of progress and of the best so far.

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
        unmet = Unmet() if found.best.met else self._unmet(plan, found, telling)
        if unmet.nearest is not None:
            found = _nearest_reported(plan, found, unmet.nearest)
        telling.finish("flying the steps for the report")
        return self._tuning(plan, found, unmet)

    def _unmet(self, plan: Plan, found: Solution, telling: Telling) -> Unmet:
        """Return what stands against what; nothing if the run was stopped.

        It takes thousands of flights, so nobody would wait for it where each flies on the diagram.
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
        """Return all that is known at the end."""
        problem = plan.problem
        gains = {**problem.base, **found.gains}
        before = problem.measured([problem.base])[0]
        axes = dict.fromkeys(wish.subject for wish in plan.wishes if wish.is_flown)
        cases = dict.fromkeys(required.case for required in problem.requirements)
        responses = {
            (axis, case): problem.instruments.responses([problem.base, gains], axis, case)
            for axis in axes
            for case in cases
        }
        results, withheld = _results(plan, responses, before, found.values)
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
    """Return a solution whose gains and values are those that a conflict tells of."""
    whole = plan.problem
    gains = whole.variables.rounded(nearest.point)
    values = whole.measured([{**whole.base, **gains}])[0]
    return dataclasses.replace(found, gains=gains, values=values, best=nearest)


def _results(
    plan: Plan,
    responses: Mapping[tuple[str, Case], Responses],
    before: np.ndarray,
    after: np.ndarray,
) -> tuple[tuple[Result, ...], list[str]]:
    """Return all requirements before and after, without the numbers of steps that did not settle.

    Returns:
        They, and why numbers are withheld, a sentence each.
    """
    steps = plan.problem.instruments.steps
    settled: dict[tuple[str, Case], list[bool]] = {}
    for (axis, case), each in responses.items():
        metrics = response_metrics(each.time, each.response, steps[axis].amplitude)
        settled[axis, case] = metrics.settled(float(each.time[-1])).tolist()
    found = []
    for required, old, new in zip(plan.problem.requirements, before, after, strict=True):
        wish = required.wish
        known = [True, True]
        if wish.is_flown and wish.metric.name in (*FROM_REST, *AT_THE_END):
            known = settled[wish.subject, required.case]
        first, last = (
            float(value) if kept else math.nan
            for value, kept in zip((old, new), known, strict=True)
        )
        found.append(Result(required, first, last))
    said = []
    for place, when in enumerate(("before", "after")):
        for (axis, case), flags in settled.items():
            if not flags[place] and not responses[axis, case].diverged[place]:
                said.append(
                    f"numbers of the {axis} step {when}, {case}, are withheld: it has not settled "
                    f"within {steps[axis].duration:.3g} s"
                )
    return tuple(found), said


def _shortfalls(
    results: Sequence[Result], smallest: Mapping[Requirement, float]
) -> tuple[str, ...]:
    """Return what is kept of defaults that gave way: a sentence for the worst case of each wish."""
    worst: dict[Wish, Result] = {}
    for result in results:
        required = result.required
        if required.widened is None or required.meets_unwidened(result.after):
            continue
        known = worst.get(required.wish)
        if known is None or result.reserve < known.reserve:
            worst[required.wish] = result
    return tuple(
        shortfall(each.required, each.after, _best_of(each, smallest)) for each in worst.values()
    )


def _best_of(result: Result, smallest: Mapping[Requirement, float]) -> float:
    """Return the best value that was reached: by the gains found, or by another candidate."""
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
    """Return gains that meet wishes, or which wish stands against which.

    Args:
        wishes: as `wishes_for` makes them of texts; without, what follows from the vehicle.
        scenario: its vehicle and rates.
        settings: parameter values that the run starts from.
        evaluations: candidates that it may look at.
        seed: equal seeds give equal runs.
        velocity: of the steady flight that is tuned for, in W (3) [m/s].
        listener: hears of progress and of the best so far.

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
    """Return where tuned gains come from, for their file."""
    wished = [str(wish) for wish in plan.wishes if wish.is_written]
    for_what = "; ".join(wished) if wished else "the wishes that follow from the vehicle"
    point = plan.problem.instruments.point
    return f"tuned for {for_what}{f', at {point.label}' if any(point.velocity) else ''}"
