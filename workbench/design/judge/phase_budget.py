"""The phase budget of a loop: law, filters, estimator, delay, hold and rotors."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.judge.loop_judgement import LoopJudgement
from workbench.design.linear.model import FILTER_PARAMETERS, LinearModel
from workbench.design.linear.operating_point import OperatingPoint
from workbench.estimation.settings import TRUTH

if TYPE_CHECKING:
    from workbench.design.linear.study import LinearStudy

PHASE_BUDGET_PARTS = ("law", "filters", "estimator", "delay", "hold", "rotors")
"""In the order of output."""

FILTER_SWITCHES = (*FILTER_PARAMETERS, "accel_lowpass")
"""Parameters that switch filters on; the last one's matters to estimators alone."""


@dataclass(frozen=True)
class PhaseBudget:
    """The contributions to the phase of an open loop at its crossover; angles in rad.

    They add up to the phase of L, which is the phase margin minus pi.

    Attributes:
        loop: its name; it is cut at its actuator.
        crossover: highest frequency at which abs(L) is 1 [rad/s].
        law: the rest: the law with a rigid body and instantaneous rotors.
        filters: of gyro, accelerometer, setpoint and acceleration: the loop with them over that
            without.
        estimator: the loop with the estimate over that with the true motion.
        delay: -w T of sensing and of commands.
        hold: -w T / 2 of the control period, as commands are held.
        rotors: -atan(w tau), with the mean of their time constants in flight.
    """

    loop: str
    crossover: float
    law: float
    filters: float
    estimator: float
    delay: float
    hold: float
    rotors: float

    @property
    def phase(self) -> float:
        """Phase of L at the crossover [rad]."""
        return sum(getattr(self, part) for part in PHASE_BUDGET_PARTS)


class PhaseStudy:
    """Computes phase budgets of a vehicle for any gains.

    Args:
        study: of the vehicle.
    """

    def __init__(self, study: "LinearStudy") -> None:
        self._study = study
        self._on_truth = study
        if study.scenario.is_estimated:
            scenario = dataclasses.replace(study.scenario, estimator=TRUTH)
            self._on_truth = study.like(scenario)

    def budgets(
        self,
        model: LinearModel,
        crossovers: Mapping[str, float],
        gains: Mapping[str, float] | None = None,
    ) -> tuple[PhaseBudget, ...]:
        """Return the budget of each loop with a crossover.

        Args:
            model: sampled, of the closed loop, from this study and with these gains.
            crossovers: of loops by name [rad/s]; NaN for a loop without one.
            gains: parameter values by name that differ from the scenario's.

        Raises:
            WorkbenchError: if it cannot fly with these gains.
        """
        study, point = self._study, model.trim.point
        unfiltered = {**(gains or {}), **dict.fromkeys(FILTER_SWITCHES, 0.0)}
        filtering = any(
            (gains or study.gains).get(name, study.gains[name]) for name in FILTER_SWITCHES
        )
        plain = study.sampled(point, unfiltered) if filtering else model
        true = plain
        if self._on_truth is not study:
            true = self._on_truth.sampled(point, self._of_truth(unfiltered))
        rates, lag = study.scenario.rates, self._rotor_lag(point, gains)
        delays = study.setup.variation.delays(rates.physics_step, rates.control_period)
        late = (delays.sensing + delays.command) * rates.physics_step
        found = []
        for loop in model.loops:
            frequency = crossovers.get(loop.name, math.nan)
            if loop.hold != point.hold or math.isnan(frequency):
                continue
            whole, some, few = (
                _response(each, loop.point("actuator"), frequency) for each in (model, plain, true)
            )
            parts = {
                "filters": float(np.angle(whole / some)),
                "estimator": float(np.angle(some / few)),
                "delay": -frequency * late,
                "hold": -0.5 * frequency * rates.control_period,
                "rotors": -math.atan(frequency * lag),
            }
            phase = float(np.angle(whole))
            if phase > 0.5 * math.pi:  # below -180 degrees
                phase -= 2.0 * math.pi
            law = phase - sum(parts.values())
            found.append(PhaseBudget(loop.name, frequency, law, **parts))
        return tuple(found)

    def _of_truth(self, gains: Mapping[str, float]) -> dict[str, float]:
        """Return those values that also exist in a flight on the true motion."""
        table = self._on_truth.controller.table
        return {name: value for name, value in gains.items() if name in table}

    def _rotor_lag(self, point: OperatingPoint, gains: Mapping[str, float] | None) -> float:
        """Return the mean time constant of the rotors in a flight [s]."""
        vehicle = self._on_truth.bare_vehicle(point, self._of_truth(gains or {}))
        places = [
            place for place, name in enumerate(vehicle.state_names) if name.startswith("speed_")
        ]
        return float(np.mean(-1.0 / np.diagonal(vehicle.A)[places]))


def phase_budgets(
    study: "LinearStudy",
    steering: LinearModel,
    holding: LinearModel | None,
    loops: tuple[LoopJudgement, ...],
    gains: Mapping[str, float] | None = None,
) -> tuple[PhaseBudget, ...]:
    """Return the budgets of judged loops, in order; see `PhaseStudy.budgets`."""
    studied = PhaseStudy(study)
    crossovers = {judged.loop: judged.actuator.crossover for judged in loops}
    found = studied.budgets(steering, crossovers, gains)
    return found + (studied.budgets(holding, crossovers, gains) if holding else ())


def _response(model: LinearModel, point: str, frequency: float) -> complex:
    """Return L of a loop cut at a point, at a frequency [rad/s]."""
    A, b, c = model.cut(point)
    z = np.exp(1j * frequency * model.period)
    return complex(-c @ np.linalg.solve(z * np.eye(len(A)) - A, b))
