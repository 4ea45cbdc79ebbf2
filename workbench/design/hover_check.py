"""Check how a vehicle flies: ten seconds of hover, and a step on every axis."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.flier import Flier, FlierFlight
from workbench.design.metrics import Demand
from workbench.design.step_response import (
    STEP_START_HEIGHT_M,
    USUAL_STEPS,
    StepResponse,
    fly_step,
    step_flier,
)
from workbench.scenario.scenario import Scenario, ScenarioStart

if TYPE_CHECKING:
    from workbench.session.recording import Recording
    from workbench.setup import Setup

HOVER_DURATION_S = 10.0
"""[s]"""
NUDGE_SPEED = 0.002
NUDGE_RATE = 0.0002
"""Initial speed of a hover along and about every axis [m/s, rad/s], to reveal instability.

It causes a drift of a few millimetres, small compared to the limit.
"""
MAX_HOVER_DRIFT_M = 0.05
"""Limit of the drift in hover [m]."""
MAX_HOVER_TILT_RAD = math.radians(0.5)
"""Limit of the tilt in hover [rad]."""
MAX_CHECK_OVERSHOOT_PCT = 15.0
"""Limit of the overshoot of a step [%]."""
MAX_CHECK_ERROR_PCT = 10.0
"""Limit of the steady-state error of a step [%]: a step without a response has no overshoot."""
_STEP_METRIC_LIMITS = (
    ("overshoot", MAX_CHECK_OVERSHOOT_PCT),
    ("steady_state_error", MAX_CHECK_ERROR_PCT),
)


@dataclass(frozen=True)
class HoverReport:
    """How well a vehicle hovers and responds to steps.

    Attributes:
        hover: the ten seconds.
        drift: (N) distance from the place where it began [m].
        tilt: (N) angle between body z and its initial direction [rad].
        steps: along x, y, z and in yaw.
        exchange: statistics of the exchange with a program that ran the law, over all flights, see
            `Session.exchange`.
        ended: why that program ended in one of the flights, else "".
    """

    hover: "Recording"
    drift: np.ndarray
    tilt: np.ndarray
    steps: tuple[StepResponse, ...]
    exchange: Mapping[str, float] = field(default_factory=dict)
    ended: str = ""

    @property
    def rotor_use(self) -> float:
        """Largest share of its speed limit at which any rotor ran while hovering, 0 .. 1."""
        return float(self.hover.rotor_use.max())

    @property
    def demands(self) -> list[Demand]:
        """Return all demands, in the order of the flights."""
        found = [
            Demand("hover", "drift", "m", float(self.drift.max()), MAX_HOVER_DRIFT_M),
            Demand("hover", "tilt", "rad", float(self.tilt.max()), MAX_HOVER_TILT_RAD),
        ]
        for step in self.steps:
            metrics, name = step.metrics, f"{step.axis} step"
            for quantity, limit in _STEP_METRIC_LIMITS:
                value = getattr(metrics, quantity)
                why = metrics.withheld if math.isnan(value) else ""
                found.append(Demand(name, quantity, "%", value, limit, why))
        return found


def check_hover(
    scenario: "Scenario | Setup | None" = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> HoverReport:
    """Fly ten seconds of hover and four steps, each from hover.

    Args:
        scenario: its vehicle and rates are used.
        settings: parameter values for all flights.
        progress: called with the share flown of all flights, 0 .. 1.

    Raises:
        WorkbenchError: if the vehicle cannot be flown.
    """
    from workbench.setup import make_setup  # loads Drake

    setup = make_setup(scenario, settings)
    flights = 1 + len(USUAL_STEPS)
    done = 0

    def report(share: float) -> None:
        if progress:
            progress((done + share) / flights)

    flown = _fly_hover(setup, report)
    hover, steps = flown.recording, []
    flier = step_flier(setup, flights=len(USUAL_STEPS))
    for axis, amplitude in USUAL_STEPS:
        done += 1
        steps.append(
            fly_step(
                axis,
                amplitude,
                scenario=setup,
                progress=report,
                flier=flier,
            )
        )
    up = hover.z_axis_W
    across = np.linalg.norm(np.cross(up, up[0]), axis=1)
    exchanges = [flown.exchange, *(step.exchange for step in steps)]
    endings = (flown.ended, *(step.ended for step in steps))
    return HoverReport(
        hover=hover,
        drift=np.linalg.norm(hover.p_WB - hover.p_WB[0], axis=1),
        tilt=np.arctan2(across, up @ up[0]),
        steps=tuple(steps),
        exchange={name: sum(each[name] for each in exchanges) for name in flown.exchange},
        ended=next(filter(None, endings), ""),
    )


def _fly_hover(setup: "Setup", progress: Callable[[float], None]) -> FlierFlight:
    """Fly the ten seconds, begun with rotors at hover speed and a nudge."""
    start = ScenarioStart(
        position=[0.0, 0.0, STEP_START_HEIGHT_M],
        velocity=[NUDGE_SPEED] * 3,
        angular_velocity=[NUDGE_RATE] * 3,
    )
    flight = replace(
        setup.scenario, start=start, figure_eight=None, script=[], duration=HOVER_DURATION_S
    )
    return Flier(setup.with_scenario(flight), flights=1 + len(USUAL_STEPS)).fly(progress)
