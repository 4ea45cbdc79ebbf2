"""Check how a vehicle flies: ten seconds of hover, and a step on every axis."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.flier import Flier, Flown
from workbench.design.metrics import Demand
from workbench.design.step_response import (
    START_HEIGHT,
    STEPS,
    StepResponse,
    fly_step,
    step_flier,
)
from workbench.scenario.scenario import Scenario, Start

if TYPE_CHECKING:
    from workbench.session.recording import Recording

HOVER_DURATION = 10.0
"""[s]"""
NUDGE_SPEED = 0.002
NUDGE_RATE = 0.0002
"""Initial speed of a hover along and about every axis [m/s, rad/s], to reveal instability.

It causes a drift of a few millimetres, small compared to the limit.
"""
DRIFT = 0.05
"""Limit of the drift in hover [m]."""
TILT = math.radians(0.5)
"""Limit of the tilt in hover [rad]."""
OVERSHOOT = 15.0
"""Limit of the overshoot of a step [%]."""
STEADY_STATE_ERROR = 10.0
"""Limit of the steady-state error of a step [%]: a step without a response has no overshoot."""
_DEMANDED = (("overshoot", OVERSHOOT), ("steady_state_error", STEADY_STATE_ERROR))


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
            Demand("hover", "drift", "m", float(self.drift.max()), DRIFT),
            Demand("hover", "tilt", "rad", float(self.tilt.max()), TILT),
        ]
        for step in self.steps:
            metrics, name = step.metrics, f"{step.axis} step"
            for quantity, limit in _DEMANDED:
                value = getattr(metrics, quantity)
                why = metrics.withheld if math.isnan(value) else ""
                found.append(Demand(name, quantity, "%", value, limit, why))
        return found


def check_hover(
    scenario: Scenario | None = None,
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
    scenario = scenario or Scenario()
    flights = 1 + len(STEPS)
    done = 0

    def report(share: float) -> None:
        if progress:
            progress((done + share) / flights)

    flown = _hover(scenario, settings, report)
    hover, steps = flown.recording, []
    flier = step_flier(scenario, settings, len(STEPS))
    for axis, amplitude in STEPS:
        done += 1
        steps.append(
            fly_step(
                axis,
                amplitude,
                scenario=scenario,
                settings=settings,
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


def _hover(
    scenario: Scenario, settings: Mapping[str, float] | None, progress: Callable[[float], None]
) -> Flown:
    """Fly the ten seconds, begun with rotors at hover speed and a nudge."""
    flight = copy.deepcopy(scenario)
    flight.start = Start(
        position=[0.0, 0.0, START_HEIGHT],
        velocity=[NUDGE_SPEED] * 3,
        angular_velocity=[NUDGE_RATE] * 3,
    )
    flight.figure_eight = None
    flight.script = []
    flight.duration = HOVER_DURATION
    return Flier(flight, settings, flights=1 + len(STEPS)).fly(progress)
