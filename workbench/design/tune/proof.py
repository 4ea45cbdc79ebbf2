"""The proof: the gains flown on the full diagram, and the numbers of those flights."""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from workbench.design.step_response import StepResponse, fly_step
from workbench.design.tune.case import NOMINAL, Case
from workbench.design.tune.measure import Step
from workbench.design.tune.metric import STEP
from workbench.design.tune.requirement import Requirement
from workbench.scenario import Scenario


@dataclass(frozen=True)
class Proof:
    """What the full diagram says.

    Attributes:
        flights: each with its case.
        values: of the requirements that were flown.
    """

    flights: tuple[tuple[Case, StepResponse], ...]
    values: tuple[tuple[Requirement, float], ...]

    @property
    def missed(self) -> list[tuple[Requirement, float]]:
        """What is not as required, with its value."""
        return [(required, value) for required, value in self.values if not required.met(value)]


def flights_to_fly(
    required: Sequence[Requirement], reserves: Mapping[Requirement, float]
) -> list[tuple[Case, str]]:
    """Return every axis with a wish, and of all corners the one with the least to spare."""
    steps = [each for each in required if each.wish.metric.kind == STEP]
    found = [(NOMINAL, axis) for axis in dict.fromkeys(each.wish.subject for each in steps)]
    corners = [each for each in steps if each.case != NOMINAL]
    if corners:
        worst = min(corners, key=lambda each: reserves[each])
        found.append((worst.case, worst.wish.subject))
    return found


def prove(
    scenario: Scenario,
    gains: Mapping[str, float],
    steps: Mapping[str, Step],
    required: Sequence[Requirement],
    flights: Sequence[tuple[Case, str]],
    progress: Callable[[float], None] | None = None,
) -> Proof:
    """Fly gains on the full diagram and compare with what is required of those flights.

    Args:
        scenario: its vehicle and rates.
        gains: parameter values that are not the scenario's own.
        steps: of the axes.
        required: what is required; those of other flights are passed over.
        flights: case and axis of each.
        progress: called with the flown share, 0 .. 1.
    """
    flown = []
    values = []
    for done, (case, axis) in enumerate(flights):
        varied = copy.deepcopy(scenario)
        varied.vehicle.variation = case.variation
        step = steps[axis]
        response = fly_step(
            axis, step.amplitude, duration=step.duration, scenario=varied, settings=gains
        )
        flown.append((case, response))
        for each in required:
            wish = each.wish
            if (each.case, wish.subject, wish.metric.kind) == (case, axis, STEP):
                values.append((each, _value(response, wish.metric.name)))
        if progress:
            progress((done + 1) / len(flights))
    return Proof(tuple(flown), tuple(values))


def _value(response: StepResponse, metric: str) -> float:
    """Return a metric of a flown step."""
    if metric == "peak_rotor_use":
        return response.peak_rotor_use
    return float(getattr(response.metrics, metric))
