"""Fly a step of a setpoint of attitude or rate from hover, and measure its response.

The loops outside are open meanwhile: the drone follows the setpoint, and speeds up sideways. Air
that passes the rotors turns it slowly back, so a response never stands still: it counts as settled
by the samples alone, not by the decay of all modes of the linear model.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.flier import DIAGRAM, Flier
from workbench.design.flown_step import STEP_EDGE_S, FlownStep
from workbench.design.linear_step import DecayTimes, linear_attitude_step
from workbench.design.step_metrics import StepMetrics, step_metrics
from workbench.design.step_response import (
    MIN_STEP_DURATION_S,
    check_amplitude,
    check_duration,
    recorded_each_update,
    scenario_before_step,
    unwrapped_yaw,
)
from workbench.scenario.attitude_axes import ATTITUDE_ROWS, AttitudeAxis, find_attitude_axis
from workbench.scenario.scenario import Scenario

if TYPE_CHECKING:
    from workbench.session.recording import Recording
    from workbench.setup import Setup

USUAL_ATTITUDE_STEP_S, USUAL_RATE_STEP_S = 1.5, 0.75
"""Time for which a step is flown without a duration of the user's [s]."""


@dataclass(frozen=True)
class AttitudeCoupling:
    """The largest deviations of the angles that were not commanded [rad]."""

    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True)
class AttitudeResponse(FlownStep):
    """A flown step of a setpoint of attitude or rate.

    Attributes:
        axis: roll, pitch, roll_rate or pitch_rate.
        amplitude: [rad] or [rad/s].
        recording: the whole flight; the setpoint steps at `STEP_EDGE_S`.
        metrics: of the response from the edge on.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        coupling: deviations of the other angles; that of the commanded one is 0.
    """

    axis: str
    amplitude: float
    metrics: StepMetrics
    peak_rotor_use: float
    coupling: AttitudeCoupling

    @property
    def response(self) -> np.ndarray:
        """Angle [rad] or rate [rad/s] from the edge on, relative to that before."""
        return response_to_setpoint(find_attitude_axis(self.axis), self.after)


def fly_attitude_step(
    axis: str,
    amplitude: float | None = None,
    *,
    duration: float | None = None,
    scenario: "Scenario | Setup | None" = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> AttitudeResponse:
    """Fly one step of a setpoint of attitude or rate and measure it.

    Args:
        axis: roll, pitch, roll_rate or pitch_rate.
        amplitude: [rad] or [rad/s]; None for that of the axis.
        duration: flown after the edge [s]; None for `usual_duration`.
        scenario: its vehicle and rates are used; start and script are the step's own. Or a setup.
        settings: parameter values for this flight.
        progress: called with the flown share, 0 .. 1.

    Raises:
        WorkbenchError: if axis, amplitude or duration are invalid, or the law has no such setpoint.
    """
    from workbench.setup import make_setup

    row = find_attitude_axis(axis)
    size = row.amplitude if amplitude is None else amplitude
    check_amplitude(size)
    setup = make_setup(recorded_each_update(scenario), settings)
    row.check(setup.controller)
    most = setup.values["max_tilt"]
    duration = usual_duration(row, size, most) if duration is None else duration
    check_duration(duration)
    check_tilt(row, size, duration, most)
    flight = attitude_scenario(row, size, duration, setup.scenario)
    flown = Flier(setup.with_scenario(flight), fly_on=DIAGRAM).fly(progress, programs=False)
    after = flown.recording.between(STEP_EDGE_S, np.inf)
    use = float(after.rotor_use.max())
    return AttitudeResponse(
        axis=axis,
        amplitude=size,
        **vars(flown),
        metrics=step_metrics(
            after.time - STEP_EDGE_S,
            response_to_setpoint(row, after),
            size,
            peak_rotor_use=use,
        ),
        peak_rotor_use=use,
        coupling=_coupling(row, after),
    )


def predict_attitude_step(
    models: DecayTimes,
    axis: str,
    amplitude: float,
    duration: float,
    settings: Mapping[str, float] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the response of the linear model to a step of a setpoint of attitude or rate.

    Args:
        models: of the scenario.
        axis: see `fly_attitude_step`.
        amplitude: [rad] or [rad/s].
        duration: after the edge [s].
        settings: parameter values that differ from those of the scenario, by name.

    Returns:
        Times from the edge on (N) [s], and the response (N) [rad] or [rad/s].

    Raises:
        WorkbenchError: if the law has no such setpoint, or there is no linear model.
    """
    model = models.model(settings)
    count = round(duration / model.period) + 1
    return model.period * np.arange(count), amplitude * linear_attitude_step(model, axis, count)


def check_tilt(row: AttitudeAxis, amplitude: float, duration: float, most: float) -> None:
    """Refuse a step that would tilt the drone further than it may.

    Args:
        row: its axis.
        amplitude: [rad] or [rad/s].
        duration: of the setpoint [s].
        most: `max_tilt` [rad].

    Raises:
        WorkbenchError: that says what to give instead.
    """
    tilt = row.largest_tilt(amplitude, duration)
    if tilt > most + 1e-9:
        remedy = "a smaller amplitude or a shorter time" if row.is_rate else "a smaller amplitude"
        during = f" for {duration:g} s" if row.is_rate else ""
        raise WorkbenchError(
            f"a {row.label} of {amplitude:g} {row.unit}{during} would tilt the drone by {tilt:.2f} "
            f"rad, and max_tilt is {most:g} rad: give {remedy}, or raise max_tilt"
        )


def usual_duration(row: AttitudeAxis, amplitude: float, max_tilt: float) -> float:
    """Return how long a step is flown unless the user says so [s].

    Args:
        row: its axis.
        amplitude: [rad] or [rad/s].
        max_tilt: at which a rate ends [rad].
    """
    if row.is_rate:
        return max(MIN_STEP_DURATION_S, min(USUAL_RATE_STEP_S, max_tilt / abs(amplitude)))
    return USUAL_ATTITUDE_STEP_S


def attitude_scenario(
    row: AttitudeAxis, amplitude: float, duration: float, scenario: Scenario
) -> Scenario:
    """Return the scenario of one step; see `fly_attitude_step` for the arguments."""
    flight = scenario_before_step(duration, scenario)
    flight.script = [replace(row.action(amplitude), at=STEP_EDGE_S)]
    return flight


def response_to_setpoint(row: AttitudeAxis, recording: "Recording") -> np.ndarray:
    """Return the response (M), from its value at the recording's first sample."""
    response = row.moved(recording.q_WB, recording.w_WB)
    return response - response[0]


def _coupling(row: AttitudeAxis, after: "Recording") -> AttitudeCoupling:
    angles = {
        each.name: each.moved(after.q_WB, after.w_WB) for each in ATTITUDE_ROWS if not each.is_rate
    }
    angles["yaw"] = unwrapped_yaw(after.q_WB)
    strayed = {name: float(np.abs(x - x[0]).max()) for name, x in angles.items()}
    return AttitudeCoupling(**(strayed | {row.name.removesuffix("_rate"): 0.0}))
