"""From wishes to gains."""

import math
from collections.abc import Mapping

from workbench.configured import read_configured
from workbench.design.tune.conflict import Conflict, conflicts
from workbench.design.tune.evaluation import Budget, SearchEndedError
from workbench.design.tune.measure import Responses
from workbench.design.tune.metric import STEP
from workbench.design.tune.plan import Plan, make_plan
from workbench.design.tune.solver import Listener, Solution, Solver
from workbench.design.tune.tuning import Result, Tuning
from workbench.design.tune.wish import DEFAULT
from workbench.design.tune.wish_file import Wishes
from workbench.errors import WorkbenchError
from workbench.gains import make_profile
from workbench.plant.loading import make_vehicle
from workbench.plant.variation import Variation
from workbench.scenario import Scenario

EVALUATIONS = 600
"""Candidates that a run may look at, if not told otherwise."""


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

    Raises:
        WorkbenchError: if the scenario varies the vehicle, which the search does on its own.
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
    ) -> None:
        self._scenario = scenario or Scenario()
        if self._scenario.vehicle.variation != Variation():
            raise WorkbenchError(
                "tuning varies the vehicle on its own: leave the variation out, or say how far it "
                "goes under 'robustness' in a wishes file"
            )
        self._wishes = wishes or Wishes()
        self._settings = dict(settings or {})
        self._separate = separate
        self._seed = seed
        self._budget = Budget(evaluations, seconds)

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
        plan = make_plan(self._scenario, self._wishes, self._settings, separate=self._separate)
        found = Solver(plan, self._budget, self._seed, listener).solve()
        against = [] if found.best.met else self._conflicts(plan, found)
        return self._tuning(plan, found, against)

    def _conflicts(self, plan: Plan, found: Solution) -> list[Conflict]:
        """Return what stands against what; nothing if the run was stopped."""
        try:
            return conflicts(found.problem, [found.best.point, *plan.starts], self._budget)
        except SearchEndedError:
            return []

    def _tuning(self, plan: Plan, found: Solution, against: list[Conflict]) -> Tuning:
        """Return all that is known at the end."""
        problem = plan.problem
        gains = {**problem.base, **found.gains}
        before = problem.measured([problem.base])[0]
        axes = dict.fromkeys(w.subject for w in plan.wishes if w.metric.kind == STEP)
        cases = dict.fromkeys(required.case for required in problem.requirements)
        responses: dict[tuple[str, object], Responses] = {
            (axis, case): problem.instruments.responses([problem.base, gains], axis, case)
            for axis in axes
            for case in cases
        }
        return Tuning(
            vehicle=problem.instruments.vehicle.name,
            wishes=plan.wishes,
            steps=problem.instruments.steps,
            results=tuple(
                Result(required, float(old), float(new))
                for required, old, new in zip(
                    problem.requirements, before, found.values, strict=True
                )
            ),
            before={name: problem.base[name] for name in found.gains},
            gains=found.gains,
            profile=make_profile(problem.instruments.vehicle, gains, _origin(plan)),
            proof=found.proof,
            conflicts=tuple(against),
            remarks=plan.remarks,
            responses=responses,  # type: ignore[arg-type]
            evaluations=self._budget.spent,
            stopped=self._budget.stopped,
        )


def tune(
    wishes: Wishes | None = None,
    scenario: Scenario | None = None,
    *,
    settings: Mapping[str, float] | None = None,
    evaluations: int = EVALUATIONS,
    seed: int = 0,
    listener: Listener | None = None,
) -> Tuning:
    """Return gains that meet wishes, or which wish stands against which.

    Args:
        wishes: as `wishes_for` makes them of texts; without, what follows from the vehicle.
        scenario: its vehicle and rates.
        settings: parameter values that the run starts from.
        evaluations: candidates that it may look at.
        seed: equal seeds give equal runs.
        listener: hears of progress and of the best so far.

    Raises:
        WorkbenchError: if the wishes contradict each other, or the vehicle cannot be flown.
    """
    tuner = Tuner(scenario, wishes, settings=settings, evaluations=evaluations, seed=seed)
    return tuner.run(listener)


def _origin(plan: Plan) -> str:
    """Return where tuned gains come from, for their file."""
    wished = [str(wish) for wish in plan.wishes if wish.origin != DEFAULT]
    for_what = "; ".join(wished) if wished else "the wishes that follow from the vehicle"
    return f"tuned for {for_what}"
