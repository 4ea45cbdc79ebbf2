"""A step by the linear model and in flight."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.judge.loop_response import closed_poles, growing_poles
from workbench.design.linear.model import LinearModel
from workbench.design.linear_step import STEP_INPUTS, STEP_OUTPUTS, decay_time, linear_step
from workbench.design.lost import find_loss
from workbench.design.step_metrics import StepMetrics, step_duration, step_metrics
from workbench.design.step_response import fly_step
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup

if TYPE_CHECKING:
    from workbench.design.flier import Flier

PAPER_STEPS = (("x", 2.0), ("y", 2.0), ("z", 1.0), ("yaw", 0.2))
"""Axes and amplitudes of the steps in the paper [m/s, rad/s]."""
THRUST_WINDOW_S = 1.0
"""Time after a step in which its thrusts are evaluated [s]."""


@dataclass(frozen=True)
class StepPair:
    """A step from hover, by the linear model and in flight.

    Attributes:
        axis: x, y, z or yaw.
        amplitude: of the command [m/s or rad/s].
        time: (N) from the command on [s].
        linear_response: (N), of the linear model.
        flown_response: (N); empty if the flight broke off or was lost.
        linear: metrics of the linear model; None if a mode of the model grows.
        flown: metrics of the flight; None if it broke off or was lost.
        broken: why the flight broke off or was lost, or "".
    """

    axis: str
    amplitude: float
    time: np.ndarray
    linear_response: np.ndarray
    flown_response: np.ndarray
    linear: StepMetrics | None
    flown: StepMetrics | None
    broken: str = ""

    @property
    def difference(self) -> float:
        """Largest distance between the two responses, as share of the amplitude."""
        if self.flown is None or self.linear is None:
            return float("nan")
        gap = np.abs(self.linear_response - self.flown_response).max()
        return float(gap / abs(self.amplitude))


def step_pair(
    model: LinearModel,
    axis: str,
    amplitude: float,
    *,
    scenario: Scenario | Setup,
    settings: Mapping[str, float] | None = None,
    flier: "Flier | None" = None,
    progress: Callable[[float], None] | None = None,
) -> StepPair:
    """Return a step of a sampled model in hover, and the flown one.

    Args:
        model: of the same scenario and settings, while the pilot steers.
        axis: x, y, z or yaw.
        amplitude: of the command [m/s or rad/s].
        scenario: as for `fly_step`.
        settings: as for `fly_step`.
        flier: as for `fly_step`.
        progress: as for `fly_step`.

    Raises:
        WorkbenchError: as `fly_step`.
    """
    decay = decay_time(model, axis)
    time = model.period * np.arange(round(step_duration(decay) / model.period) + 1)
    flown, broken = None, ""
    try:
        flight = fly_step(
            axis,
            amplitude,
            duration=step_duration(decay),
            scenario=scenario,
            settings=settings,
            flier=flier,
            decay=decay,
            progress=progress,
        )
    except FlightBrokenError as error:
        broken = str(error)
    else:
        loss = find_loss(flight.recording)
        broken = loss.sentence if loss else ""
        if not broken:
            flown, time = flight, flight.time
    response = amplitude * linear_step(model, STEP_INPUTS[axis], STEP_OUTPUTS[axis], len(time))
    dies_out = not growing_poles(closed_poles(model), model.period).any()
    return StepPair(
        axis=axis,
        amplitude=amplitude,
        time=time,
        linear_response=response,
        flown_response=flown.response if flown else np.zeros(0),
        linear=step_metrics(time, response, amplitude, decay=decay) if dies_out else None,
        flown=flown.metrics if flown else None,
        broken=broken,
    )


def saturating_step(model: LinearModel, axis: str, vehicle: Vehicle) -> float:
    """Return the size of the step at which the first rotor reaches its largest thrust.

    By the linear model, from hover [m/s or rad/s]; infinite if the step needs no thrust.

    Args:
        model: sampled, while the pilot steers.
        axis: x, y, z or yaw.
        vehicle: the one flown.
    """
    frame = thrust_frame(vehicle)
    most = np.array([rotor.max_thrust for rotor in frame.rotors]) - frame.hover_thrusts
    samples = round(THRUST_WINDOW_S / model.period)
    share = 0.0
    for rotor, room in enumerate(most):
        thrust = linear_step(model, STEP_INPUTS[axis], f"thrust_{rotor + 1}", samples)
        if room > 0.0:
            share = max(share, float(np.abs(thrust).max()) / room)
    return 1.0 / share if share else math.inf
