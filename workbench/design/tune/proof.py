"""The proof: flights on the full diagram with the gains, and their metrics."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.flier import DIAGRAM
from workbench.design.metrics import STEP_KIND
from workbench.design.step_metrics import StepMetrics, step_metrics
from workbench.design.step_response import REST_VELOCITY_M_S, StepResponse, fly_step
from workbench.design.tune.case import NOMINAL_CASE, VehicleCase
from workbench.design.tune.measure import TuneStep
from workbench.design.tune.requirement import Requirement
from workbench.setup import Setup


@dataclass(frozen=True)
class Proof:
    """The results on the full diagram.

    Attributes:
        flights: each with its case.
        values: of the requirements on these flights.
    """

    flights: tuple[tuple[VehicleCase, StepResponse], ...]
    values: tuple[tuple[Requirement, float], ...]

    @property
    def missed(self) -> list[tuple[Requirement, float]]:
        """The requirements that are not met, with their values."""
        return [(required, value) for required, value in self.values if not required.met(value)]


def flights_to_fly(
    required: Sequence[Requirement], reserves: Mapping[Requirement, float]
) -> list[tuple[VehicleCase, str]]:
    """Return the flights for each axis with a wish: as described, and in the worst corners."""
    steps = [each for each in required if each.wish.is_flown]
    found = [(NOMINAL_CASE, each.wish.subject) for each in steps]
    for wish in dict.fromkeys(each.wish for each in steps):
        corners = [each for each in steps if each.wish == wish and each.case != NOMINAL_CASE]
        if corners:
            found.append((min(corners, key=lambda each: reserves[each]).case, wish.subject))
    return list(dict.fromkeys(found))


def prove_gains(
    setup: Setup,
    gains: Mapping[str, float],
    steps: Mapping[str, TuneStep],
    required: Sequence[Requirement],
    flights: Sequence[tuple[VehicleCase, str]],
    progress: Callable[[str, float], None],
    velocity: Sequence[float] = REST_VELOCITY_M_S,
) -> Proof:
    """Fly gains on the full diagram, and compare with the requirements on those flights.

    Args:
        setup: the vehicle and its rates.
        gains: parameter values that differ from those of the setup.
        steps: of the axes.
        required: all requirements; those on other flights are ignored.
        flights: case and axis of each.
        progress: called with the present flight, and the share flown of all, 0 .. 1.
        velocity: of the steady flight before the steps, in W (3) [m/s].
    """
    flown = []
    values = []
    for done, (case, axis) in enumerate(flights):
        step = steps[axis]
        phase = f"proving on the full diagram: {axis} step {done + 1} of {len(flights)}, {case}"

        def tell(share: float, done: int = done, phase: str = phase) -> None:
            progress(phase, (done + share) / len(flights))

        response = fly_step(
            axis,
            step.amplitude,
            scenario=setup.varied(case.variation),
            settings=gains,
            velocity=velocity,
            progress=tell,
            fly_on=DIAGRAM,
        )
        flown.append((case, response))
        for each in required:
            wish = each.wish
            if (each.case, wish.subject, wish.metric.kind) == (case, axis, STEP_KIND):
                values.append((each, _metric_value(response, wish.metric.name, case)))
    return Proof(tuple(flown), tuple(values))


def _metric_value(response: StepResponse, metric: str, case: VehicleCase) -> float:
    """Return a metric of a flown step; NaN where it has no meaning."""
    if metric == "peak_rotor_use":  # of a lost flight, too
        return response.peak_rotor_use
    if response.loss:
        return math.nan
    numbers = case_metrics(
        response.time, response.response, response.amplitude, response.decay, case
    )
    return float(getattr(numbers, metric))


def case_metrics(
    time: np.ndarray, response: np.ndarray, command: float, decay: float, case: VehicleCase
) -> StepMetrics:
    """Return the metrics of a step of a vehicle, see `step_metrics`.

    In a corner the drone is not what its controller knows. It moves in the hover before the edge,
    so its rise, settling and overshoot are relative to the edge.
    """
    found = step_metrics(time, response, command, decay=decay)
    if case == NOMINAL_CASE:
        return found
    moved = step_metrics(time, response - response[0], command, decay=decay)
    return dataclasses.replace(moved, steady_state_error=found.steady_state_error)
