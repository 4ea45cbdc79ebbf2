"""Fly a step of a load, a force or a torque on a hovering drone, and measure its response."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.response_metrics import LoadMetrics, load_metrics
from workbench.design.step_response import EDGE, START_HEIGHT, check_duration
from workbench.dynamics.air.settings import gust_settings, push_settings
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.loads import GustLoad, Load, find_load
from workbench.scenario.scenario import Action, Push, Scenario, Start

if TYPE_CHECKING:
    from workbench.design.lost import Loss
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.session.recording import Recording

SHARE = 0.1
"""Usual load, as a share of the weight; of a torque, times the rotors' lever."""
CALM = {f"{blow}_{axis}": 0.0 for blow in ("gust", "push", "push_torque") for axis in "xyz"}
"""Parameters without a gust or a push: those of the present flight have other times."""


@dataclass(frozen=True)
class LoadResponse:
    """A flown step of a load.

    Attributes:
        load: name of the axis.
        amplitude: [N] or [N·m].
        recording: the whole flight; the load acts from `EDGE` on.
        metrics: of the response from the edge on.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        exchange: statistics of the exchange with a program that ran the law, see
            `Session.exchange`.
        ended: why that program ended in flight, else "".
    """

    load: str
    amplitude: float
    recording: "Recording"
    metrics: LoadMetrics
    peak_rotor_use: float
    exchange: Mapping[str, float] = field(default_factory=dict)
    ended: str = ""

    @property
    def time(self) -> np.ndarray:
        """Time from the edge on [s]."""
        return self.recording.between(EDGE, np.inf).time - EDGE

    @property
    def response(self) -> np.ndarray:
        """Deviation from the edge on: position [m], angle [rad] or yaw rate [rad/s]."""
        return moved(find_load(self.load), self.recording.between(EDGE, np.inf))

    @property
    def loss(self) -> "Loss | None":
        """When and how the flight was lost, else None; the metrics of a lost flight mean little."""
        from workbench.design.lost import find_loss

        return find_loss(self.recording)


def fly_load_step(
    load: str,
    amplitude: float | None = None,
    *,
    duration: float = 5.0,
    acts: float | None = None,
    scenario: Scenario | None = None,
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
    from workbench.scenario.configured import configured_vehicle
    from workbench.session.session import Session

    row, common = find_load(load), scenario or Scenario()
    vehicle = configured_vehicle(common.vehicle)
    size = usual_load(row, vehicle) if amplitude is None else amplitude
    check_load(load, size)
    check_duration(duration)
    flight = load_scenario(row, size, duration, common, vehicle, acts)
    session = Session(flight, settings)
    with session.programs():
        session.run(progress)
    after = session.recording().between(EDGE, np.inf)
    return LoadResponse(
        load=load,
        amplitude=size,
        recording=session.recording(),
        metrics=load_metrics(after.time - EDGE, moved(row, after)),
        peak_rotor_use=float(after.rotor_use.max()),
        exchange=session.exchange,
        ended=session.ended,
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
    check_load(load, amplitude)
    check_duration(duration)
    centre = engine.vehicle.p_BoBcm_B
    loaded = _settings(row.action(amplitude, acting_time(row, duration, acts), centre))
    start = start_state(engine.vehicle, Start(roll_pitch_yaw=[0.0, 0.0, heading]))
    flown = engine.fly_from(
        [{**gains, **CALM, **loaded}], start, np.zeros(4), duration=EDGE + duration
    )
    after = flown.time >= EDGE - 1e-9
    states = flown.states[0, after]
    response = row.moved(states[:, 0:4], states[:, 4:7], states[:, 7:10])
    return flown.time[after] - EDGE, response, float(flown.peak_rotor_use[0])


def check_load(load: str, amplitude: float) -> None:
    """Check the load and amplitude of a step.

    Raises:
        WorkbenchError: that says what to give instead.
    """
    find_load(load)
    if not 0.0 < abs(amplitude) < math.inf:
        raise WorkbenchError(f"the amplitude is {amplitude:g}: give it a finite number, and not 0")


def usual_load(load: Load, vehicle: Vehicle) -> float:
    """Return a load that a vehicle withstands easily, in its unit.

    A gust of 5 m/s; a tenth of its weight; of a torque, that at a tenth of the rotors' mean
    distance from the centre of mass, and about yaw at their drag torque's share of thrust.
    """
    if isinstance(load, GustLoad):
        return load.amplitude
    weight = vehicle.mass * GRAVITY
    if any(load.force_W):
        return SHARE * weight
    if load.turns:
        lever = float(np.mean([rotor.moment_constant for rotor in vehicle.rotors]))
    else:
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) - vehicle.p_BoBcm_B
        lever = SHARE * float(np.linalg.norm(hubs, axis=1).mean())
    return SHARE * weight * lever


def load_scenario(
    load: Load,
    amplitude: float,
    duration: float,
    scenario: Scenario,
    vehicle: Vehicle,
    acts: float | None = None,
) -> Scenario:
    """Return the scenario of one step of a load; see `fly_load_step` for the arguments."""
    flight = copy.deepcopy(scenario)
    flight.start = Start(position=[0.0, 0.0, START_HEIGHT])
    flight.figure_eight = None
    flight.duration = EDGE + duration
    flight.rates.record_period = flight.rates.control_period
    action = load.action(amplitude, acting_time(load, duration, acts), vehicle.p_BoBcm_B)
    flight.script = [replace(action, at=EDGE)]
    return flight


def _settings(action: Action) -> dict[str, float]:
    """Return the parameters of a push or a gust that begins at the edge."""
    if action.gust is not None:
        return gust_settings(action.gust.velocity, EDGE, action.gust.duration)
    push = action.push or Push()
    return push_settings(push.force, push.point, EDGE, push.duration, push.torque)


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


def moved(load: Load, recording: "Recording") -> np.ndarray:
    """Return the response to a load (M), from its value at the recording's first sample."""
    return load.moved(recording.q_WB, recording.p_WB, recording.w_WB)
