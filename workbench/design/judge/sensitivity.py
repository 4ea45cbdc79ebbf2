"""How much every number of a step changes with every gain: exact, by derivatives carried in flight.

The step is flown on the continuous flight core: the law without its sample time, in still air.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.judge.carried_flight import CarriedFlight, fly_carried
from workbench.design.judge.hermite import Carried, Curve
from workbench.design.metrics import FLOWN
from workbench.design.step_response import LEAST_DURATION
from workbench.scenario.axes import AXES
from workbench.scenario.scenario import Scenario

METRICS = tuple(metric.name for metric in FLOWN)
SETTLED = 0.02
"""The band of the settling time, as share of the steady state; python-control's."""
NOTHING = 1e-6
"""A metric that is smaller, in its unit or percent, is rounding, and counts as 0."""


@dataclass(frozen=True)
class Sensitivity:
    """One metric of a step, and what the gains do to it.

    Attributes:
        metric: its name, as in `StepMetrics`.
        value: of the continuous flight; times are not rounded to samples.
        derivatives: by each gain, by name, in the metric's unit per the gain's.
        elasticities: percent that the metric changes per percent of the gain; NaN where the
            metric is 0.
    """

    metric: str
    value: float
    derivatives: dict[str, float]
    elasticities: dict[str, float]


def step_sensitivity(
    axis: str,
    amplitude: float,
    *,
    duration: float = 3.0,
    heading: float = 0.0,
    scenario: Scenario | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[Sensitivity, ...]:
    """Return what every parameter of the controller does to every metric of a step from hover.

    Arguments are those of `fly_step`, and the yaw of the drone at the start, `heading` [rad].

    Raises:
        WorkbenchError: if axis, amplitude or duration make no step.
    """
    if axis not in AXES:
        raise unknown_name("axis", axis, AXES)
    if not LEAST_DURATION <= duration < np.inf or not 0.0 < abs(amplitude) < np.inf:
        raise WorkbenchError(
            f"a step of {amplitude:g} over {duration:g} s cannot be measured: give it an amplitude "
            f"that is not 0 and {LEAST_DURATION:g} s or more"
        )
    flight = fly_carried(
        axis,
        amplitude,
        duration=duration,
        heading=heading,
        scenario=scenario,
        settings=settings,
        progress=progress,
    )
    return flight_sensitivity(flight)


def flight_sensitivity(flight: CarriedFlight) -> tuple[Sensitivity, ...]:
    """Return the sensitivities of a flown step."""
    found = carried_metrics(flight.response, flight.amplitude)
    uses = [curve.highest()[0] for curve in flight.rotor_use]
    found["peak_rotor_use"] = max(uses, key=lambda use: use.value)
    return tuple(_sensitivity(name, found[name], flight.gains) for name in METRICS)


def carried_metrics(response: Curve, command: float) -> dict[str, Carried]:
    """Return python-control's step metrics of a curve, with their derivatives, by name."""
    sign = float(np.sign(command))
    curve = response.scaled(sign)
    steady = curve.end
    peak, peak_time = curve.highest()
    lowest, _ = curve.scaled(-1.0).highest()
    overshoot = (peak - steady) / steady
    band = [curve.last_crossing(steady.scaled(1.0 + side * SETTLED)) for side in (-1.0, 1.0)]
    settled = max((time for time in band if np.isfinite(time.value)), key=lambda time: time.value)
    short = 1.0 - steady.value / abs(command)
    error = steady.scaled(-np.sign(short) * 100.0 / abs(command))
    return {
        "rise_time": curve.first_crossing(steady.scaled(0.9))
        - curve.first_crossing(steady.scaled(0.1)),
        "settling_time": settled,
        "overshoot": overshoot.scaled(100.0),
        "undershoot": (lowest / steady).scaled(100.0),
        "peak": peak,
        "peak_time": peak_time,
        "steady_state_value": steady.scaled(sign),
        "steady_state_error": Carried(100.0 * abs(short), error.by_gain),
    }


def _sensitivity(metric: str, found: Carried, gains: Mapping[str, float]) -> Sensitivity:
    """Return a metric's sensitivity by name."""
    value = found.value if abs(found.value) >= NOTHING else 0.0
    derivatives = dict(zip(gains, found.by_gain.tolist(), strict=True))
    return Sensitivity(
        metric=metric,
        value=value,
        derivatives=derivatives,
        elasticities={
            name: gains[name] * slope / value if value else float("nan")
            for name, slope in derivatives.items()
        },
    )
