"""Fly a step of a load, a force or a torque on a hovering drone, and measure its response."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.flier import DIAGRAM, Flier
from workbench.design.flown_step import STEP_EDGE_S, FlownStep
from workbench.design.load_metrics import LoadMetrics, load_metrics
from workbench.design.step_response import (
    check_amplitude,
    check_duration,
    recorded_each_update,
    scenario_before_step,
)
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.loads import Load, find_load
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.script import disturbance_settings

if TYPE_CHECKING:
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.session.recording import Recording
    from workbench.setup import Setup

USUAL_LOAD_SHARE = 0.1
"""Usual load, as a share of the weight; of a torque, times the rotors' lever."""
NO_LOAD_PARAMETERS = {
    f"{blow}_{axis}": 0.0 for blow in ("gust", "push", "push_torque") for axis in "xyz"
}
"""Parameters without a gust or a push: those of the present flight have other times."""


@dataclass(frozen=True)
class LoadResponse(FlownStep):
    """A flown step of a load.

    Attributes:
        load: name of the axis.
        amplitude: [N] or [N·m].
        recording: the whole flight; the load acts from `STEP_EDGE_S` on.
        metrics: of the response from the edge on.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
    """

    load: str
    amplitude: float
    metrics: LoadMetrics
    peak_rotor_use: float

    @property
    def response(self) -> np.ndarray:
        """Deviation from the edge on: position [m], angle [rad] or yaw rate [rad/s]."""
        return response_to_load(find_load(self.load), self.after)


def fly_load_step(
    load: str,
    amplitude: float | None = None,
    *,
    duration: float = 5.0,
    acts: float | None = None,
    scenario: "Scenario | Setup | None" = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> LoadResponse:
    """Fly one step of a load on a hovering drone and measure it.

    Args:
        load: force_x, force_y, force_z (in W, at the centre of mass), torque_roll, torque_pitch or
            torque_yaw (in B), gust_x, gust_y or gust_z (in W).
        amplitude: [N], [N·m], or [m/s] at the peak of a gust; None for that of `usual_load`.
        duration: flown from the edge on [s].
        acts: duration of the load [s]; None for the rest of the flight, or for 1 s if it is a gust.
        scenario: its vehicle and rates are used; start and script are the step's own.
        settings: parameter values for this flight.
        progress: called with the flown share, 0 .. 1.

    Raises:
        WorkbenchError: if load, amplitude or duration are invalid, or the step cannot be flown.
    """
    from workbench.setup import make_setup

    row = find_load(load)
    setup = make_setup(recorded_each_update(scenario), settings)
    size = usual_load(row, setup.vehicle) if amplitude is None else amplitude
    check_amplitude(size)
    check_duration(duration)
    flight = load_step_scenario(row, size, duration, setup.scenario, setup.vehicle, acts)
    flown = Flier(setup.with_scenario(flight), fly_on=DIAGRAM).fly(progress)
    after = flown.recording.between(STEP_EDGE_S, np.inf)
    use = float(after.rotor_use.max())
    return LoadResponse(
        load=load,
        amplitude=size,
        **vars(flown),
        metrics=load_metrics(
            after.time - STEP_EDGE_S, response_to_load(row, after), peak_rotor_use=use
        ),
        peak_rotor_use=use,
    )


def predict_load_step(
    engine: "RolloutEngine",
    gains: Mapping[str, float],
    load: str,
    amplitude: float,
    *,
    duration: float,
    acts: float | None = None,
    heading: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the response of a compiled flight to a step of a load in hover.

    Args:
        engine: the one that flies it.
        gains: parameter values by name.
        load: see `fly_load_step`.
        amplitude: see `fly_load_step`.
        duration: see `fly_load_step`.
        acts: see `fly_load_step`.
        heading: yaw of the drone [rad].

    Returns:
        Times from the edge on (N) [s], the response (N), NaN once the drone is lost, and the
        largest share of its speed limit at which any rotor ran.

    Raises:
        WorkbenchError: as `fly_load_step` does.
    """
    from workbench.design.rollout.candidates import start_state

    row = find_load(load)
    check_amplitude(amplitude)
    check_duration(duration)
    centre = engine.vehicle.p_BoBcm_B
    action = row.action(amplitude, acting_time(row, duration, acts), centre)
    loaded = disturbance_settings(action, STEP_EDGE_S)
    start = start_state(engine.vehicle, ScenarioStart(roll_pitch_yaw=[0.0, 0.0, heading]))
    flown = engine.fly_from(
        [{**gains, **NO_LOAD_PARAMETERS, **loaded}],
        start,
        np.zeros(4),
        duration=STEP_EDGE_S + duration,
    )
    after = flown.time >= STEP_EDGE_S - 1e-9
    states = flown.states[0, after]
    response = row.moved(states[:, 0:4], states[:, 4:7], states[:, 7:10])
    return flown.time[after] - STEP_EDGE_S, response, float(flown.peak_rotor_use[0])


def usual_load(load: Load, vehicle: Vehicle) -> float:
    """Return a load that a vehicle withstands easily, in its unit.

    A gust of 5 m/s; a tenth of its weight; of a torque, that at a tenth of the rotors' mean
    distance from the centre of mass, and about yaw at their drag torque's share of thrust.
    """
    if load.is_gust:
        return load.amplitude
    weight = vehicle.mass * GRAVITY
    if any(load.force_W):
        return USUAL_LOAD_SHARE * weight
    if load.turns:
        lever = float(np.mean([rotor.moment_constant for rotor in vehicle.rotors]))
    else:
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) - vehicle.p_BoBcm_B
        lever = USUAL_LOAD_SHARE * float(np.linalg.norm(hubs, axis=1).mean())
    return USUAL_LOAD_SHARE * weight * lever


def load_step_scenario(
    load: Load,
    amplitude: float,
    duration: float,
    scenario: Scenario,
    vehicle: Vehicle,
    acts: float | None = None,
) -> Scenario:
    """Return the scenario of one step of a load; see `fly_load_step` for the arguments."""
    flight = scenario_before_step(duration, scenario)
    action = load.action(amplitude, acting_time(load, duration, acts), vehicle.p_BoBcm_B)
    flight.script = [replace(action, at=STEP_EDGE_S)]
    return flight


def acting_time(load: Load, duration: float, acts: float | None) -> float:
    """Return the duration of a load [s].

    Raises:
        WorkbenchError: if it is not within the flight.
    """
    if acts is None:
        return min(duration, load.longest)
    if not 0.0 < acts <= duration:
        raise WorkbenchError(
            f"a load cannot act for {acts:g} s in {duration:g} s: give it a time within that"
        )
    return acts


def response_to_load(load: Load, recording: "Recording") -> np.ndarray:
    """Return the response to a load (M), from its value at the recording's first sample."""
    return load.moved(recording.q_WB, recording.p_WB, recording.w_WB)
