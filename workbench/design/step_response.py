"""Fly one step of velocity or yaw rate from hover.

An invalid step is rejected before Drake is loaded.
"""

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.flown_step import STEP_EDGE_S, FlownStep, axis_velocity
from workbench.design.steady_drift import fly_from_rest
from workbench.design.step_metrics import (
    USUAL_STEP_S,
    StepMetrics,
    step_duration,
    step_metrics,
)
from workbench.scenario.axes import AXIS_NAMES, find_axis
from workbench.scenario.scenario import Action, Scenario, ScenarioStart
from workbench.session.drift import MAX_HOVER_S, air_moves

if TYPE_CHECKING:
    from workbench.design.flier import Flier
    from workbench.session.recording import Recording
    from workbench.setup import Setup

REST_VELOCITY_M_S = (0.0, 0.0, 0.0)
"""Velocity before a step that begins at rest [m/s]."""
MIN_STEP_DURATION_S = 0.1
MAX_STEP_DURATION_S = 600.0
"""Limit of the duration after the edge of a step [s]."""
STEP_DURATIONS_TEXT = f"{MIN_STEP_DURATION_S:g} s or more, and {MAX_STEP_DURATION_S:g} s at most"
"""Limits of the duration in words."""
STEP_START_HEIGHT_M = 10.0
"""Initial height, enough for a step down [m]."""
USUAL_STEPS = (("x", 1.0), ("y", 1.0), ("z", 1.0), ("yaw", 0.2))
"""The usual steps: axis and amplitude [m/s, rad/s]."""


@dataclass(frozen=True)
class Coupling:
    """The largest deviations of the axes that were not commanded."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True)
class StepResponse(FlownStep):
    """A flown step.

    Attributes:
        axis: x, y, z (velocity in W [m/s]) or yaw (rate [rad/s]).
        amplitude: of the command.
        recording: the whole flight; the command steps at `edge`.
        metrics: of the response from the edge on.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        coupling: deviations of the other axes, [m] and [rad]; that of the commanded one is 0.
        before: velocity or yaw rate at the edge of a step from a steady flight or from a steady
            drift, as in wind; 0 for hover.
        decay: time by which the transient has decayed by the linear model [s], 0 if unknown.
    """

    axis: str
    amplitude: float
    metrics: StepMetrics
    peak_rotor_use: float
    coupling: Coupling
    before: float = 0.0
    decay: float = 0.0

    @property
    def response(self) -> np.ndarray:
        """Velocity or yaw rate from the edge on, relative to that before."""
        return axis_velocity(self.after, self.axis) - self.before


def fly_step(
    axis: str,
    amplitude: float,
    *,
    duration: float | None = None,
    scenario: "Scenario | Setup | None" = None,
    settings: Mapping[str, float] | None = None,
    velocity: Sequence[float] = REST_VELOCITY_M_S,
    progress: Callable[[float], None] | None = None,
    flier: "Flier | None" = None,
    fly_on: str = "",
    decay: float | None = None,
    longest_hover: float | None = None,
) -> StepResponse:
    """Fly one step and measure it.

    A step is flown after `STEP_EDGE_S`. In wind a drone that still moves along the axis then flies
    again: it steers at no speed until it drifts steadily, and steps from there, as those of sweeps
    and searches do. A law without integral action drifts with the wind; its response is relative
    to that. In turbulence nothing is steady: numbers are withheld at once.

    Args:
        axis: x, y, z or yaw.
        amplitude: of the command, [m/s] or [rad/s].
        duration: flown after the edge [s]; None for until it has settled, see `step_duration`.
        scenario: its vehicle and rates are used; start and script are the step's own. Or a setup.
        settings: parameter values for this flight.
        velocity: of the steady flight before the step, in W (3) [m/s].
        progress: called with the flown share, 0 .. 1.
        flier: of another step with the same arguments but axis and amplitude, see `step_flier`,
            to fly again; this saves building the diagram.
        fly_on: without a flier, who flies: see `Flier`.
        decay: decay time of the linear step [s], if known, see `DecayTimes`.
        longest_hover: longest time to become steady [s]; None for `MAX_HOVER_S` in wind, and none
            in still air.

    Raises:
        WorkbenchError: if axis, amplitude or duration are invalid, or the step cannot be flown.
    """
    check_step(axis, amplitude)
    if duration is not None:
        check_duration(duration)
    from workbench.design.flier import Flier
    from workbench.design.linear_step import DecayTimes  # loads Drake
    from workbench.setup import make_setup

    setup = make_setup(recorded_each_update(scenario), settings)
    decay = DecayTimes(setup, velocity).of(axis) if decay is None else decay
    duration = step_duration(decay) if duration is None else duration
    flight = step_scenario(axis, amplitude, duration, setup.scenario, velocity)
    if flier:
        flier.follow(flight.script, flight.duration)
    else:
        flier = Flier(setup.with_scenario(flight), fly_on=fly_on)
    _check_within_limit(flier, axis, amplitude, velocity)
    if longest_hover is None:
        longest_hover = MAX_HOVER_S if air_moves(setup.values) else 0.0
    flown, edge, rests, unsteady = fly_from_rest(
        flier, setup, axis, amplitude, duration, 0.0 if any(velocity) else longest_hover, progress
    )
    after = flown.recording.between(edge, np.inf)
    response = axis_velocity(after, axis)
    begins = velocity if edge == STEP_EDGE_S else after.v_WB[0].tolist()
    before = float(response[0]) if any(begins) else 0.0
    use = float(after.rotor_use.max())
    return StepResponse(
        axis=axis,
        amplitude=amplitude,
        edge=edge,
        **vars(flown),
        metrics=step_metrics(
            after.time - edge,
            response - before,
            amplitude,
            decay=decay,
            rests=rests,
            unsteady=unsteady,
            peak_rotor_use=use,
        ),
        peak_rotor_use=use,
        coupling=coupling(after, axis, begins),
        before=before,
        decay=decay,
    )


def step_flier(scenario: "Scenario | Setup | None" = None, flights: int = 1) -> "Flier":
    """Return what flies steps of several axes one after another, see `fly_step` and `Flier`."""
    from workbench.design.flier import Flier
    from workbench.setup import make_setup

    setup = make_setup(recorded_each_update(scenario))
    flight = step_scenario(AXIS_NAMES[0], 1.0, USUAL_STEP_S, setup.scenario)
    return Flier(setup.with_scenario(flight), flights=flights)


def check_step(axis: str, amplitude: float) -> None:
    """Check axis and amplitude of a step.

    Raises:
        WorkbenchError: that says what to give instead.
    """
    if axis not in AXIS_NAMES:
        raise unknown_name("axis", axis, AXIS_NAMES)
    check_amplitude(amplitude)


def check_amplitude(amplitude: float) -> None:
    """Check the amplitude of a step.

    Raises:
        WorkbenchError: if it is 0 or not finite.
    """
    if not 0.0 < abs(amplitude) < math.inf:
        raise WorkbenchError(f"the amplitude is {amplitude:g}: give it a finite number, and not 0")


def check_duration(duration: float) -> None:
    """Check that a duration [s] is long enough to measure, and short enough to fly.

    Raises:
        WorkbenchError: if it is not.
    """
    if not MIN_STEP_DURATION_S <= duration <= MAX_STEP_DURATION_S:
        raise WorkbenchError(
            f"a step cannot be measured in {duration:g} s: give it {STEP_DURATIONS_TEXT}"
        )


def recorded_each_update(scenario: "Scenario | Setup | None") -> "Scenario | Setup":
    """Return a scenario with what a step records in place of its record period; a setup stays."""
    scenario = scenario or Scenario()
    if not isinstance(scenario, Scenario):
        return scenario
    rates = replace(scenario.rates, record_period=scenario.rates.control_period)
    return replace(scenario, rates=rates)


def scenario_before_step(
    duration: float, scenario: Scenario, velocity: Sequence[float] = REST_VELOCITY_M_S
) -> Scenario:
    """Return the scenario of a step of any kind, whose script is still to come.

    Args:
        duration: after the edge [s].
        scenario: of which vehicle, rates and surroundings are kept; it is not changed.
        velocity: of the steady flight before the step, in W (3) [m/s].
    """
    flight = copy.deepcopy(scenario)
    flight.start = ScenarioStart(position=[0.0, 0.0, STEP_START_HEIGHT_M], velocity=list(velocity))
    flight.figure_eight = None
    flight.duration = STEP_EDGE_S + duration
    flight.rates.record_period = flight.rates.control_period
    return flight


def step_scenario(
    axis: str,
    amplitude: float,
    duration: float,
    scenario: Scenario,
    velocity: Sequence[float] = REST_VELOCITY_M_S,
) -> Scenario:
    """Return the scenario of one step; see `fly_step` for the arguments."""
    flight = scenario_before_step(duration, scenario, velocity)
    command = stepped(axis, amplitude, velocity)
    flight.script = [Action(at=STEP_EDGE_S, velocity=command[:3])]
    if axis == "yaw":
        flight.script = [Action(at=STEP_EDGE_S, yaw_rate=amplitude)]
    if any(velocity):
        flight.script.insert(0, Action(velocity=list(velocity)))
    return flight


def stepped(
    axis: str, amplitude: float, velocity: Sequence[float] = REST_VELOCITY_M_S
) -> list[float]:
    """Return the velocity in W and the yaw rate (4) that a step commands; see `fly_step`."""
    command = [*velocity, 0.0]
    command[AXIS_NAMES.index(axis)] += amplitude
    return command


def axis_command(recording: "Recording", axis: str) -> np.ndarray:
    """Return the command along an axis of W [m/s], or of the yaw rate [rad/s]."""
    return recording.reference[:, AXIS_NAMES.index(axis)]


def axis_acceleration(recording: "Recording", axis: str) -> np.ndarray:
    """Return the acceleration along an axis of W [m/s²], or about z [rad/s²]."""
    if axis == "yaw":
        return recording.wdot_WB[:, 2]
    return recording.vdot_WB[:, AXIS_NAMES.index(axis)]


def axis_force(recording: "Recording", axis: str) -> np.ndarray:
    """Return the force or torque along an axis, as defined in the paper.

    For z the total rotor thrust [N]; for x and y the horizontal component of the rotor thrust
    along the axis [N]; for yaw the torque about body z [N·m].
    """
    if axis == "yaw":
        return recording.moment_B[:, 2]
    if axis == "z":
        return recording.total_thrust
    return recording.force_W[:, AXIS_NAMES.index(axis)]


def _check_within_limit(
    flier: "Flier", axis: str, amplitude: float, velocity: Sequence[float]
) -> None:
    """Reject a step that exceeds the command limits, as its metrics would have no meaning."""
    row = find_axis(axis)
    for v_x, v_y, v_z, _ in ([*velocity, 0.0], stepped(axis, amplitude, velocity)):
        if any(velocity) and math.hypot(v_x, v_y) > flier.get("max_speed"):
            raise WorkbenchError(
                f"a level speed of {math.hypot(v_x, v_y):g} m/s cannot be flown: step from a "
                "slower flight, or raise max_speed"
            )
        if any(velocity) and abs(v_z) > flier.get("max_climb_rate"):
            raise WorkbenchError(
                f"a climb of {v_z:g} m/s cannot be flown: step from a slower one, or raise "
                "max_climb_rate"
            )
    most = flier.get(row.limit)
    if not 0.0 < abs(amplitude) <= most:
        raise WorkbenchError(
            f"a step of {amplitude:g} {row.unit} along {axis} cannot be flown: use an amplitude "
            f"within ±{most:g} and not 0, or raise {row.limit}"
        )


def coupling(
    after: "Recording", axis: str, velocity: Sequence[float] = REST_VELOCITY_M_S
) -> Coupling:
    """Return the largest excursions of the axes that were not commanded.

    Args:
        after: the flight from the edge on.
        axis: the commanded one; "" includes all of them.
        velocity: of the steady flight, in W (3) [m/s].
    """
    yaw = unwrapped_yaw(after.q_WB)
    p_WB = after.p_WB - np.outer(after.time - after.time[0], velocity)
    strayed = {
        name: float(np.abs(values - values[0]).max())
        for name, values in zip(AXIS_NAMES, (*p_WB.T, yaw), strict=True)
    }
    strayed |= {axis: 0.0} if axis else {}
    return Coupling(**strayed)


def unwrapped_yaw(q_WB: np.ndarray) -> np.ndarray:
    """Return the yaw angles of orientations (N, 4) without jumps, (N) [rad]."""
    w, x, y, z = q_WB.T
    return np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
