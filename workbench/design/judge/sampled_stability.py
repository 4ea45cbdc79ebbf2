"""The slowest rate of the control law, from the sampled loop at increasing control periods."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.loop_response import (
    INTEGRATOR,
    closed_poles,
    growth_rate,
    spectral_radius,
)
from workbench.design.judge.modes import natural_poles
from workbench.design.linear.operating_point import HOVER, OperatingPoint
from workbench.gains.gains import flight_gains
from workbench.scenario.scenario import SLOWEST, Scenario

if TYPE_CHECKING:
    from workbench.design.linear.study import LinearStudy

SAFE_PHASE = math.radians(30.0)
"""Smallest phase margin of all loops at a safe rate [rad]."""
COARSE = (1, 2, 4, 8, 12, 16, 24, 32, 40, 48, 64)
"""Periods tried first, in physics steps; then the limit between two of them is searched."""
SLOW = 0.05
"""Natural frequency below which modes are those of heading and position [rad/s]."""


@dataclass(frozen=True)
class RateSample:
    """The closed loop at one control period.

    Attributes:
        period: [s].
        spectral_radius: largest |z| of a pole, without integrators that have no effect.
        stable: whether no mode grows.
        phase_margin: smallest of all loops [rad], 0 where unstable.
        growth: largest growth rate of a mode [1/s], negative if it decays; modes slower than
            `SLOW`, of heading and position, are left out. NaN if there are no others.
    """

    period: float
    spectral_radius: float
    stable: bool
    phase_margin: float
    growth: float


@dataclass(frozen=True)
class SlowestRate:
    """The slowest rates of the control law with its gains.

    Attributes:
        stable_period: longest control period with a stable loop [s]; NaN if none.
        safe_period: longest control period with a phase margin of `SAFE_PHASE` in every loop [s];
            NaN if none.
        samples: all periods tried, in order.
    """

    stable_period: float
    safe_period: float
    samples: tuple[RateSample, ...]

    @property
    def at_limit(self) -> bool:
        """Whether the loop is still stable at the longest period of a scenario."""
        return self.stable_period == self.samples[-1].period


def slowest_rate(
    scenario: Scenario | None = None,
    *,
    point: OperatingPoint = HOVER,
    settings: Mapping[str, float] | None = None,
    study: "LinearStudy | None" = None,
) -> SlowestRate:
    """Return the slowest rates of the law, to the resolution of the physics step.

    Args:
        scenario: its vehicle and physics step are used.
        point: where to linearise.
        settings: parameter values.
        study: of the same scenario, to reuse it.

    Raises:
        WorkbenchError: if the vehicle cannot be read, or cannot fly at the point.
    """
    scenario = scenario or Scenario()
    if study is None:
        from workbench.design.linear.study import LinearStudy  # loads Drake; figures do not need it

        study = LinearStudy(scenario)
    most = math.floor(SLOWEST["control_period"] / scenario.rates.physics_step + 1e-9)
    samples: dict[int, RateSample] = {}

    def sample(steps: int) -> RateSample:
        if steps not in samples:
            samples[steps] = rate_sample(study, steps, point, settings)
        return samples[steps]

    def longest(holds: Callable[[RateSample], bool]) -> float:
        good, bad = 0, most + 1
        for steps in (*(n for n in COARSE if n < most), most):
            if not holds(sample(steps)):
                bad = steps
                break
            good = steps
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if holds(sample(middle)) else (good, middle)
        return good * scenario.rates.physics_step if good else math.nan

    return SlowestRate(
        stable_period=longest(lambda found: found.stable),
        safe_period=longest(lambda found: found.phase_margin >= SAFE_PHASE),
        samples=tuple(samples[steps] for steps in sorted(samples)),
    )


def rate_sample(
    study: "LinearStudy",
    steps: int,
    point: OperatingPoint = HOVER,
    settings: Mapping[str, float] | None = None,
) -> RateSample:
    """Return the closed loop with a control period given in physics steps."""
    slowed = copy.deepcopy(study.scenario)
    slowed.rates.control_period = steps * slowed.rates.physics_step
    gains = flight_gains(study.vehicle, slowed.vehicle.gains, settings, study.controller)
    model = study.like(slowed).sampled(point, gains)
    loops, poles = judge_loops(model), closed_poles(model)
    stable = growth_rate(poles, model.period) < INTEGRATOR
    natural = natural_poles(poles, model.period)
    growths = natural.real[np.abs(natural) > SLOW]
    return RateSample(
        period=model.period,
        spectral_radius=spectral_radius(poles),
        stable=stable,
        phase_margin=min(
            (margins.phase_margin for loop in loops for margins in (loop.actuator, loop.error)),
            default=math.inf if stable else 0.0,
        ),
        growth=float(growths.max()) if len(growths) else math.nan,
    )
