"""From wishes to gains: the plan, the search, the proof, and the result."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import compress

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.law_program import not_repeatable_error
from workbench.design.linear.operating_point import Triple
from workbench.design.linear_step import DecayTimes
from workbench.design.step_metrics import STEP_NUMBERS, StepMetrics, step_duration
from workbench.design.step_response import REST_VELOCITY_M_S
from workbench.design.tune.case import VehicleCase
from workbench.design.tune.conflict import Unmet, conflicts
from workbench.design.tune.evaluation import (
    Budget,
    SearchEndedError,
    TuneCandidate,
)
from workbench.design.tune.measure import Responses, TuneStep
from workbench.design.tune.proof import case_metrics
from workbench.design.tune.requirement import (
    Requirement,
    shortfall,
)
from workbench.design.tune.solver import Solution, Solver
from workbench.design.tune.tuning import (
    ProgressListener,
    ProgressReporter,
    Tuning,
    WishResult,
    worst_of_each,
)
from workbench.design.tune.tuning_plan import TuningPlan, make_plan
from workbench.design.tune.variables import (
    counterparts,
    loop_of,
)
from workbench.design.tune.wish import (
    DEFAULT_ORIGIN,
    Wishes,
    group_members,
)
from workbench.gains.gain_choice import make_profile
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

DEFAULT_EVALUATIONS = 600
"""Default number of candidates of a run."""


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
        scenario: Scenario | Setup | None = None,
        wishes: Wishes | None = None,
        *,
        settings: Mapping[str, float] | None = None,
        separate: bool = False,
        evaluations: int = DEFAULT_EVALUATIONS,
        seconds: float = math.inf,
        seed: int = 0,
        velocity: Triple = REST_VELOCITY_M_S,
    ) -> None:
        self._setup = make_setup(scenario, settings).without_dropped_loads()
        self._controller = self._setup.controller
        if self._controller.program:
            raise not_repeatable_error(self._controller.name)
        if self._setup.variation != Variation():
            raise WorkbenchError(
                "tuning varies the vehicle on its own: leave the variation out, or say how far it "
                "goes under 'robustness' in a wishes file"
            )
        self._wishes = wishes or Wishes()
        for wish in self._wishes.wishes:
            group_members(wish.subject, wish.metric, self._controller)
        self._separate = separate
        self._velocity = velocity
        if any(velocity):
            self._refuse_hold()
        self._seed = seed
        self._budget = Budget(evaluations, seconds)
        self._plan: TuningPlan | None = None

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
        """Name of the vehicle."""
        return self._setup.vehicle.name

    def stop(self) -> None:
        """End the search soon; the best candidate so far is kept, checked and flown."""
        self._budget.told = True

    def prepare(self, listener: ProgressListener | None = None) -> None:
        """Fly the vehicle and those near it with the law's own gains: on the diagram for minutes.

        Args:
            listener: see `run`, which prepares what is not prepared.

        Raises:
            WorkbenchError: see `run`.
        """
        self._plan = make_plan(
            self._setup,
            self._wishes,
            separate=self._separate,
            velocity=self._velocity,
            telling=ProgressReporter(listener),
        )

    def run(self, listener: ProgressListener | None = None) -> Tuning:
        """Return the result.

        Args:
            listener: called with progress and the best candidate so far.

        Raises:
            WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
        """
        if self._plan is None:
            self.prepare(listener)
        assert self._plan
        plan, telling = self._plan, ProgressReporter(listener)
        found = Solver(plan, self._budget, self._seed, telling).solve()
        if not found.proved:
            found = self._without_defaults(plan, found, telling)
        unmet = Unmet() if found.best.met else self._unmet(plan, found, telling)
        if unmet.nearest is not None:
            found = _nearest_reported(plan, found, unmet.nearest)
        telling.finish("flying the steps for the report")
        return self._tuning(plan, found, unmet)

    def _without_defaults(
        self, plan: TuningPlan, found: Solution, telling: ProgressReporter
    ) -> Solution:
        """Return gains that meet what was wished and not all defaults; else the given solution."""
        whole = plan.problem
        kept = [each.wish.origin != DEFAULT_ORIGIN for each in whole.requirements]
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

    def _unmet(self, plan: TuningPlan, found: Solution, telling: ProgressReporter) -> Unmet:
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

    def _tuning(self, plan: TuningPlan, found: Solution, unmet: Unmet) -> Tuning:
        """Return the result of the run."""
        problem = plan.problem
        gains = {**problem.base, **found.gains}
        before = problem.measured([problem.base])[0]
        axes = dict.fromkeys(wish.subject for wish in plan.wishes if wish.is_flown)
        cases = dict.fromkeys(required.case for required in problem.requirements)
        decay_times = DecayTimes(plan.setup, problem.instruments.point.velocity)
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
                measured[axis, case] = _measured_metrics(flown, step, decays, case)
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
                problem.instruments.vehicle, gains, _gains_origin(plan), self._controller
            ),
            proof=found.proof,
            conflicts=unmet.measured(required, [result.after for result in results]),
            shortfalls=_shortfalls(results, found.smallest),
            remarks=(*plan.remarks, *withheld),
            responses=responses,
            evaluations=self._budget.spent,
            stopped=self._budget.stopped,
        )


def _nearest_reported(plan: TuningPlan, found: Solution, nearest: TuneCandidate) -> Solution:
    """Return the solution with the gains and values reported in conflicts."""
    whole = plan.problem
    gains = whole.variables.rounded(nearest.point)
    values = whole.measured([{**whole.base, **gains}])[0]
    return dataclasses.replace(found, gains=gains, values=values, best=nearest)


def _measured_metrics(
    flown: Responses, step: TuneStep, decays: Sequence[float], case: VehicleCase
) -> list[StepMetrics | None]:
    """Return the metrics of steps, each as long as `workbench step` flies it; None if lost."""
    found: list[StepMetrics | None] = []
    for response, decay, lost in zip(flown.response, decays, flown.diverged, strict=True):
        kept = flown.time <= step_duration(decay) + 1e-9
        metrics = case_metrics(flown.time[kept], response[kept], step.amplitude, decay, case)
        found.append(None if lost else metrics)
    return found


def _results(
    plan: TuningPlan,
    measured: Mapping[tuple[str, VehicleCase], list[StepMetrics | None]],
    before: np.ndarray,
    after: np.ndarray,
) -> tuple[tuple[WishResult, ...], list[str]]:
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
        if name in STEP_NUMBERS:
            for place, each in enumerate(steps):
                values[place] = getattr(each, name) if each else values[place]
        found.append(WishResult(required, *map(float, values)))
    said = [
        f"numbers of the {axis} step {when}, {case}, are withheld: {each.withheld}"
        for place, when in enumerate(("before", "after"))
        for (axis, case), steps in measured.items()
        if (each := steps[place]) and each.withheld
    ]
    return tuple(found), said


def _shortfalls(
    results: Sequence[WishResult], smallest: Mapping[Requirement, float]
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


def _best_of(result: WishResult, smallest: Mapping[Requirement, float]) -> float:
    """Return the best value reached, with the gains found or by another candidate."""
    known = smallest.get(result.required, result.after)
    better = max if result.required.wish.at_least else min
    return better(known, result.after)


def tune(
    wishes: Wishes | None = None,
    scenario: Scenario | Setup | None = None,
    *,
    settings: Mapping[str, float] | None = None,
    evaluations: int = DEFAULT_EVALUATIONS,
    seed: int = 0,
    velocity: Triple = REST_VELOCITY_M_S,
    listener: ProgressListener | None = None,
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


def _gains_origin(plan: TuningPlan) -> str:
    """Return the origin of tuned gains, for their file."""
    wished = [str(wish) for wish in plan.wishes if wish.is_written]
    for_what = "; ".join(wished) if wished else "the wishes that follow from the vehicle"
    point = plan.problem.instruments.point
    return f"tuned for {for_what}{f', at {point.label}' if any(point.velocity) else ''}"
