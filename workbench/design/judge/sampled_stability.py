"""The slowest rate of the control law, from the sampled loop at increasing control periods."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.loop_response import closed_poles, growing_poles, spectral_radius
from workbench.design.judge.modes import natural_poles
from workbench.design.linear.operating_point import HOVER_POINT, OperatingPoint
from workbench.scenario.scenario_check import MAX_SCENARIO_PERIODS_S

if TYPE_CHECKING:
    from workbench.design.linear.study import LinearStudy
    from workbench.scenario.scenario import Scenario
    from workbench.setup import Setup

SAFE_PHASE_MARGIN_RAD = math.radians(30.0)
"""Smallest phase margin of all loops at a safe rate [rad]."""
TRIED_PERIOD_STEPS = (1, 2, 4, 8, 12, 16, 24, 32, 40, 48, 64)
"""Periods tried first, in physics steps; then the limit between two of them is searched."""
SLOW_MODE_RAD_S = 0.05
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
            `SLOW_MODE_RAD_S`, of heading and position, are left out. NaN if there are no others.
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
        safe_period: longest control period with a phase margin of `SAFE_PHASE_MARGIN_RAD` in every
            loop [s]; NaN if none.
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
    scenario: "Scenario | Setup | None" = None,
    *,
    point: OperatingPoint = HOVER_POINT,
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
    if study is None:
        from workbench.design.linear.study import LinearStudy  # loads Drake; figures do not need it

        study = LinearStudy(scenario)
    step = study.setup.rates.physics_step
    most = math.floor(MAX_SCENARIO_PERIODS_S["control_period"] / step + 1e-9)
    samples: dict[int, RateSample] = {}

    def sample(steps: int) -> RateSample:
        if steps not in samples:
            samples[steps] = rate_sample(study, steps, point, settings)
        return samples[steps]

    def longest(holds: Callable[[RateSample], bool]) -> float:
        good, bad = 0, most + 1
        for steps in (*(n for n in TRIED_PERIOD_STEPS if n < most), most):
            if not holds(sample(steps)):
                bad = steps
                break
            good = steps
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if holds(sample(middle)) else (good, middle)
        return good * step if good else math.nan

    return SlowestRate(
        stable_period=longest(lambda found: found.stable),
        safe_period=longest(lambda found: found.phase_margin >= SAFE_PHASE_MARGIN_RAD),
        samples=tuple(samples[steps] for steps in sorted(samples)),
    )


def rate_sample(
    study: "LinearStudy",
    steps: int,
    point: OperatingPoint = HOVER_POINT,
    settings: Mapping[str, float] | None = None,
) -> RateSample:
    """Return the closed loop with a control period given in physics steps."""
    rates = study.scenario.rates
    slowed = dataclasses.replace(rates, control_period=steps * rates.physics_step)
    setup = study.setup.with_scenario(dataclasses.replace(study.scenario, rates=slowed))
    model = study.like(setup).sampled(point, settings)
    loops, poles = judge_loops(model), closed_poles(model)
    stable = not growing_poles(poles, model.period).any()
    natural = natural_poles(poles, model.period)
    growths = natural.real[np.abs(natural) > SLOW_MODE_RAD_S]
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
