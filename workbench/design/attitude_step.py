"""Fly a step of a setpoint of attitude or rate from hover, and measure its response.

The loops outside are open meanwhile: the drone follows the setpoint, and speeds up sideways. Air
that passes the rotors turns it slowly back, so a response never stands still: it counts as settled
by the samples alone, not by the decay of all modes of the linear model.

A drone that wind tilts hovers until it is at rest, and its setpoint steps from that of the hover.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.flier import DIAGRAM, Flier
from workbench.design.flown_step import STEP_EDGE_S, FlownStep
from workbench.design.linear_step import DecayTimes, linear_attitude_step
from workbench.design.steady_drift import hover_until
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
from workbench.session.drift import HOVER_LOOK_S, MAX_HOVER_S

if TYPE_CHECKING:
    from workbench.session.recording import Recording
    from workbench.session.session import Session
    from workbench.setup import Setup

USUAL_ATTITUDE_STEP_S, USUAL_RATE_STEP_S = 1.5, 0.75
"""Time for which a step is flown without a duration of the user's [s]."""

LEVEL_LOOK_S = 0.5
"""Time before a step in which a hover is level or tilted [s]."""


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
        recording: the whole flight; the setpoint steps at `edge`.
        metrics: of the response from the edge on.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        coupling: deviations of the other angles; that of the commanded one is 0. NaN, as the
            metrics, if the flight was lost before the edge.
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
    from workbench.design.lost import find_loss
    from workbench.setup import make_setup

    row = find_attitude_axis(axis)
    size = row.amplitude if amplitude is None else amplitude
    check_amplitude(size)
    setup = make_setup(recorded_each_update(scenario), settings)
    row.check(setup.controller)
    most = setup.values["max_tilt"]
    duration = usual_duration(row, size, most) if duration is None else duration
    check_duration(duration)
    row.check_tilt(size, duration, most)
    flight = replace(scenario_before_step(duration, setup.scenario), script=[])
    session = Flier(setup.with_scenario(flight), fly_on=DIAGRAM).session
    show = progress or (lambda share: None)
    longest = STEP_EDGE_S + MAX_HOVER_S + duration
    hover, rests = _hover_before(session, row, abs(size), lambda: show(session.time / longest))
    edge = session.time
    row.check_tilt(size, duration, most, hover)
    session.do(row.action(size + hover))
    slices = math.ceil(duration / HOVER_LOOK_S)
    for index in range(slices):
        session.tick(duration / slices)
        show((edge + (longest - edge) * (index + 1) / slices) / longest)
    recording = session.recording()
    after = recording.between(edge, np.inf)
    loss, use = find_loss(recording), float(after.rotor_use.max())
    if loss and loss.time <= edge:
        coupling = AttitudeCoupling(math.nan, math.nan, math.nan)
        metrics = StepMetrics(peak_rotor_use=use, withheld="the flight was lost before the step")
    else:
        coupling = _coupling(row, after)
        metrics = step_metrics(
            after.time - edge,
            response_to_setpoint(row, after),
            size,
            rests=rests,
            peak_rotor_use=use,
        )
    return AttitudeResponse(
        axis=axis,
        amplitude=size,
        edge=edge,
        recording=recording,
        metrics=metrics,
        peak_rotor_use=use,
        coupling=coupling,
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


def _hover_before(
    session: "Session", row: AttitudeAxis, size: float, progress: Callable[[], None]
) -> tuple[float, bool]:
    """Hover to the edge of a step: for `STEP_EDGE_S`, or until a drone that tilts is at rest.

    Args:
        session: at its start.
        row: axis of the step.
        size: of the step [rad] or [rad/s], positive.
        progress: called as it flies for longer.

    Returns:
        The setpoint of the hover [rad], and whether the drone is at rest; it may be lost, else.
    """
    from workbench.design.lost import find_loss
    from workbench.session.hover_attitude import attitude_unrest, hover_attitude, least_level_angle

    start = session.snapshot().roll_pitch_yaw
    session.tick(STEP_EDGE_S)
    late = session.recording().between(STEP_EDGE_S - LEVEL_LOOK_S, np.inf)
    angles = [each.moved(late.q_WB, late.w_WB) for each in ATTITUDE_ROWS if not each.is_rate]
    tilts = [abs(angle.mean() - start[each]) for each, angle in enumerate(angles)]
    if max(tilts) <= least_level_angle(session, size):
        return 0.0, True
    lost = False

    def is_over() -> bool:
        nonlocal lost
        lost = find_loss(session.recording()) is not None
        return lost or attitude_unrest(session, size) < 1.0

    rests = hover_until(session, is_over, STEP_EDGE_S + MAX_HOVER_S, progress=progress)
    if lost:
        return 0.0, False
    return hover_attitude(session, row, size).setpoint, rests


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
