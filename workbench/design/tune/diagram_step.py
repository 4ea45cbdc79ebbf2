"""A step flown on the full diagram, anywhere: for laws of which there is no machine code."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.step_response import HOVER, fly_step
from workbench.scenario.scenario import Scenario


class FlownStep(NamedTuple):
    """Response from the edge on (M) [m/s, rad/s], largest rotor use, and when it was lost [s]."""

    response: np.ndarray
    peak_rotor_use: float
    diverged_at: float


@dataclass(frozen=True)
class DiagramStep:
    """The flight of one set of gains; see `executor.Task`.

    Attributes:
        scenario: its vehicle, varied, controller and rates.
        gains: parameter values by name.
        axis: of the step.
        amplitude: of its command [m/s, rad/s].
        duration: flown after its edge [s].
        velocity: of the steady flight before it, in W (3) [m/s].
    """

    scenario: Scenario
    gains: Mapping[str, float]
    axis: str
    amplitude: float
    duration: float
    velocity: tuple[float, float, float] = HOVER

    def with_scenario(self, scenario: Scenario) -> Self:
        """Return the same flight with the files of that scenario."""
        return dataclasses.replace(self, scenario=scenario)

    @property
    def samples(self) -> int:
        """M: one each control period, the edge included."""
        return round(self.duration / self.scenario.rates.control_period) + 1

    def run(self) -> FlownStep:
        """Fly it; a response that breaks off stays at 0."""
        response = np.zeros(self.samples)
        rates = dataclasses.replace(
            self.scenario.rates, record_period=self.scenario.rates.control_period
        )
        try:
            flown = fly_step(
                self.axis,
                self.amplitude,
                duration=self.duration,
                scenario=dataclasses.replace(self.scenario, rates=rates),
                settings=self.gains,
                velocity=self.velocity,
            )
        except FlightBrokenError:
            return FlownStep(response, np.inf, 0.0)
        values = flown.response[: response.size]
        response[: values.size] = values
        return FlownStep(response, flown.peak_rotor_use, flown.diverged_at)
