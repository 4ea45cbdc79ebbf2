"""Measure sets of gains: flown steps, margins and noise, for several vehicles."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.control.loop import Loop
from workbench.design.executor.executor import InThisProcess, Task, all_cores
from workbench.design.judge.loop_response import closed_poles, growth_rate
from workbench.design.judge.margins import all_margins
from workbench.design.judge.noise import noise_effects
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING_POINT, OperatingPoint, Triple
from workbench.design.linear.retuned import Models, retuned_models
from workbench.design.linear.study import LinearStudy
from workbench.design.linear_step import linear_step
from workbench.design.metrics import LOOP_KIND, ROTORS_KIND, STEP_KIND
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.sensor_set import why_not_compiled
from workbench.design.step_response import REST_VELOCITY_M_S, STEP_START_HEIGHT_M, fly_step
from workbench.design.tune.case import VehicleCase
from workbench.design.tune.flight_numbers import SEARCHED_NUMBERS, flight_numbers
from workbench.design.tune.noise_amplification import noise_amplification
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import loop_of
from workbench.design.tune.wish import ATTITUDE_METRICS, ATTITUDE_SUBJECTS, Wish
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup

Gains = Mapping[str, float]
Numbers = dict[str, np.ndarray]
"""The values of N sets of gains (N) by the name of a wish, such as x.rise_time."""
_UNSTABLE_COMMAND_RATIO = 100.0
"""Effect of noise on commands, relative to their mean, that counts as unstable."""
MARGIN_PER_GROWTH_S = -0.1
"""Margin of an unstable loop per unit of its growth rate [s]."""
ATTITUDE_STEP_S = 1.5
"""Duration of a step of an attitude [s]; afterwards drag has an effect due to the speed."""
DIVERGED_RESPONSE_RATIO = 100.0
"""Response, relative to its command, from which on a step counts as diverged."""


def _diagram_step(
    scenario: Scenario, gains: Gains, axis: str, step: "TuneStep", velocity: Triple
) -> tuple[np.ndarray, float, float]:
    """Return the response (M) of a step, the largest rotor use, and the time of a loss.

    A response that breaks off continues at 0.

    Args:
        scenario: its vehicle, varied, controller and rates.
        gains: parameter values by name.
        axis: of the step.
        step: its amplitude and duration.
        velocity: of the steady flight before it, in W (3) [m/s].
    """
    response = np.zeros(_sample_count(scenario, step))
    try:
        flown = fly_step(
            axis,
            step.amplitude,
            duration=step.duration,
            scenario=scenario,
            settings=gains,
            velocity=velocity,
        )
    except FlightBrokenError:
        return response, np.inf, 0.0
    values = flown.response[: response.size]
    response[: values.size] = values
    return response, flown.peak_rotor_use, flown.diverged_at


def _sample_count(scenario: Scenario, step: "TuneStep") -> int:
    """Return the number of samples M: one for each control period, including the edge."""
    return round(step.duration / scenario.rates.control_period) + 1


@dataclass(frozen=True)
class TuneStep:
    """A step to fly: amplitude [m/s, rad/s] and duration [s]."""

    amplitude: float
    duration: float


class Instruments:
    """The instruments: compiled rollouts and linear models, made once for each vehicle.

    Args:
        setup: the vehicle, its gains and rates.
        velocity: of the steady flight for the judgement and before steps, in W (3) [m/s].

    Raises:
        WorkbenchError: if the vehicle cannot be read.
    """

    def __init__(
        self,
        setup: Setup,
        velocity: Triple = REST_VELOCITY_M_S,
    ) -> None:
        self._setup = setup
        self.point = OperatingPoint(velocity=velocity)
        self._studies: dict[VehicleCase, LinearStudy] = {}
        self._models: dict[tuple[VehicleCase, OperatingPoint], Models] = {}
        self._engines: dict[VehicleCase, RolloutEngine] = {}
        self.vehicle, self.controller, self.base = setup.vehicle, setup.controller, setup.values
        self.steps: dict[str, TuneStep] = {}

    @property
    def flown_set(self) -> int | None:
        """The active set of scheduled gains, or that of the largest weight; None without a
        schedule.
        """
        schedule = self.controller.schedule
        if schedule is None:
            return None
        value = schedule.value(
            height=STEP_START_HEIGHT_M,
            velocity=self.point.velocity,
            payload=self.base["known_payload_mass"],
        )
        return schedule.nearest(value)

    def models(self, case: VehicleCase, point: OperatingPoint) -> Models:
        """Return the linear models of a case.

        Raises:
            WorkbenchError: if it cannot fly like that.
        """
        if (case, point) not in self._models:
            self._models[case, point] = retuned_models(self._study(case), point, self.base)
        return self._models[case, point]

    def _study(self, case: VehicleCase) -> LinearStudy:
        if case not in self._studies:
            self._studies[case] = LinearStudy(self._setup.varied(case.variation))
        return self._studies[case]

    @cached_property
    def compiles(self) -> bool:
        """Whether flights of steps are compiled."""
        return self.controller.compiles and not why_not_compiled(self._setup)

    def _engine(self, case: VehicleCase) -> RolloutEngine:
        if case not in self._engines:
            self._engines[case] = RolloutEngine.of(self._setup.varied(case.variation))
        return self._engines[case]

    def responses(
        self, gains: Sequence[Gains], axis: str, case: VehicleCase, duration: float | None = None
    ) -> "Responses":
        """Return flown steps of an axis, compiled if possible, else on the diagram.

        Args:
            gains: N sets of all parameter values.
            axis: of the step.
            case: the vehicle.
            duration: flown after the edge [s]; None for that of the search.
        """
        step = self.steps[axis]
        step = step if duration is None else replace(step, duration=duration)
        if not self.compiles:
            return self._flown_on_the_diagram(gains, axis, step, case)
        flown = self._engine(case).fly(
            gains, axis, step.amplitude, duration=step.duration, velocity=self.point.velocity
        )
        response = flown.response
        if any(self.point.velocity):
            response = response - response[:, :1]
        return Responses(flown.time, response, flown.peak_rotor_use, flown.diverged_at)

    def _flown_on_the_diagram(
        self, gains: Sequence[Gains], axis: str, step: "TuneStep", case: VehicleCase
    ) -> "Responses":
        scenario = self._study(case).scenario
        velocity = self.point.velocity
        tasks = [
            Task(scenario, _diagram_step, (dict(each), axis, step, velocity)) for each in gains
        ]
        # a process starts in seconds, as long as a step flies
        executor = all_cores() if len(tasks) > 1 else InThisProcess()
        flown = dict(executor.run(tasks))
        found = zip(*(flown[index] for index in range(len(tasks))), strict=True)
        time = scenario.rates.control_period * np.arange(_sample_count(scenario, step))
        return Responses(time, *map(np.array, found))

    def measure(self, gains: Sequence[Gains], required: Sequence[Requirement]) -> np.ndarray:
        """Return the values (N, R) that requirements bound, of N sets of all parameter values.

        Sets may differ from the base in the gains of the loops.

        A diverged flight or an unstable loop has infinite values, or a negative margin that
        measures the instability.
        """
        values = np.full((len(gains), len(required)), math.nan)
        for case in dict.fromkeys(each.case for each in required):
            asked = {each.wish.name: each.wish for each in required if each.case == case}.values()
            found: Numbers = {}
            for subject in dict.fromkeys(w.subject for w in asked if w.metric.kind == STEP_KIND):
                measured = (
                    self._attitude_numbers if subject in ATTITUDE_SUBJECTS else self._step_numbers
                )
                found |= measured(gains, subject, case)
            held = [w for w in asked if w.metric.kind == LOOP_KIND and self.holds(w.subject)]
            free = [w for w in asked if w.metric.kind != STEP_KIND and w not in held]
            for point, some in ((self.point, free), (HOLDING_POINT, held)):
                if some:
                    found |= self._loop_numbers(gains, some, case, point)
            for index, each in enumerate(required):
                if each.case == case:
                    values[:, index] = found[each.wish.name]
        return values

    def holds(self, subject: str) -> bool:
        """Return whether a loop or loop point exists only while a position is held."""
        loop = loop_of(self.controller, subject)
        return loop is not None and loop.hold

    def _step_numbers(self, gains: Sequence[Gains], axis: str, case: VehicleCase) -> Numbers:
        """Return all metrics of the step of an axis."""
        flown = self.responses(gains, axis, case)
        numbers = flight_numbers(
            flown.time, flown.response, self.steps[axis].amplitude, flown.diverged
        )
        use = np.where(flown.diverged, math.inf, flown.peak_rotor_use)
        found = {f"{axis}.{name}": getattr(numbers, name) for name in SEARCHED_NUMBERS}
        return found | {f"{axis}.peak_rotor_use": use}

    def _attitude_numbers(self, gains: Sequence[Gains], angle: str, case: VehicleCase) -> Numbers:
        """Return the metrics of a step of an attitude, by the linear model.

        The velocity loops are open, so only the angle is commanded.
        """
        models = self.models(case, self.point)
        rows = [attitude_step(models(each), angle) for each in gains]
        response = np.array(rows)
        time = models(gains[0]).period * np.arange(response.shape[1])
        grows = ~(np.abs(response).max(axis=1) < DIVERGED_RESPONSE_RATIO)
        numbers = flight_numbers(time, response, 1.0, grows)
        return {f"{angle}.{name}": getattr(numbers, name) for name in ATTITUDE_METRICS}

    def _loop_numbers(
        self,
        gains: Sequence[Gains],
        wishes: Sequence[Wish],
        case: VehicleCase,
        point: OperatingPoint,
    ) -> Numbers:
        """Return numbers of the linear model at an operating point."""
        models, study = self.models(case, point), self._study(case)
        rows = [_model_numbers(models(each), wishes) for each in gains]
        found = dict(zip((wish.name for wish in wishes), np.array(rows).T, strict=True))
        for wish in wishes:
            if wish.metric.name == "command_noise":
                found[wish.name] = np.array([command_noise(study, point, each) for each in gains])
        return found


@dataclass(frozen=True)
class Responses:
    """Flown steps of one axis.

    Attributes:
        time: (M) from the command's edge on [s].
        response: (N, M) [m/s, rad/s].
        peak_rotor_use: (N) largest share of its speed limit at which any rotor ran.
        diverged_at: (N) time when a flight diverged [s], NaN if it did not.
    """

    time: np.ndarray
    response: np.ndarray
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray

    @property
    def diverged(self) -> np.ndarray:
        """Whether each flight diverged (N)."""
        return np.isfinite(self.diverged_at)


def _model_numbers(model: LinearModel, wishes: Sequence[Wish]) -> list[float]:
    """Return the numbers of one model that wishes bound."""
    loops = list(dict.fromkeys(w.subject for w in wishes if w.metric.kind == LOOP_KIND))
    points = [cut_point(model, loop) for loop in loops]
    margins = dict(zip(loops, all_margins(model, points), strict=True)) if loops else {}
    found = []
    for wish in wishes:
        if wish.metric.name == "command_noise":
            found.append(math.nan)  # computed from a model with the noise of each sensor
        elif wish.metric.kind == ROTORS_KIND:
            found.append(noise_amplification(model))
        elif margins[wish.subject].stable:
            found.append(float(getattr(margins[wish.subject], wish.metric.name)))
        elif wish.metric.name == "peak_sensitivity":
            found.append(math.inf)
        else:
            found.append(MARGIN_PER_GROWTH_S * growth_rate(closed_poles(model), model.period))
    return found


def attitude_step(model: LinearModel, angle: str) -> np.ndarray:
    """Return the response (M) of an angle, roll or pitch, to a command of 1, sample by sample.

    Args:
        model: sampled, of hover; the loops outside of those of attitude are opened here.
        angle: roll or pitch.
    """
    outer: dict[str, Loop] = {}
    for loop in model.loops:
        if loop.axis in ("x", "y", "z") and not loop.hold:
            outer.setdefault(loop.axis, loop)
    around = [
        loop.point("actuator") for loop in outer.values() if loop.name not in ATTITUDE_SUBJECTS
    ]
    (error,) = [loop.error for loop in model.loops if loop.name == angle]
    samples = round(ATTITUDE_STEP_S / model.period) + 1
    response = linear_step(model.opened(around), error, angle, samples)
    # the sign of an error depends on the source of the law
    return response * math.copysign(1.0, response[np.abs(response).argmax()])


def cut_point(model: LinearModel, subject: str) -> str:
    """Return the loop point of the cut: at the actuator side, which all of its law passes through.

    Args:
        model: that has it.
        subject: a loop, or the loop point itself.
    """
    found = [loop.point("actuator") for loop in model.loops if loop.name == subject]
    return found[0] if found else subject


def command_noise(study: LinearStudy, point: OperatingPoint, gains: Gains) -> float:
    """Return the rms of rotor commands due to sensor noise, over their mean [1].

    It is that of the most affected rotor, see `noise_effects`, and infinite for an unstable loop.
    """
    *_, every = noise_effects(study, point, gains)
    return every.worst_command if every.worst_command < _UNSTABLE_COMMAND_RATIO else math.inf
