"""A step flown with its derivatives by the gains carried along, on the continuous flight core."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator_
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError
from workbench.control.controller import DEFAULT, load_controller
from workbench.control.guidance import Guidance, Reference
from workbench.design.judge.hermite import Curve
from workbench.design.step_response import START_HEIGHT
from workbench.diagram.core import make_flight_core
from workbench.gains.gains import flight_gains
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import laden, payload_of
from workbench.plant.placing import body_state
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.axes import AXES
from workbench.scenario.configured import read_configured
from workbench.scenario.scenario import Scenario

STEP = 1 / 128
"""Of the integrator, Runge-Kutta of third order, and between the samples of the curves [s]."""
_RATE = {"x": 10, "y": 11, "z": 12, "yaw": 9}
"""Place of an axis' velocity in the plant's state."""
_BODY = 13


@dataclass(frozen=True)
class CarriedFlight:
    """A step from hover, as curves that carry derivatives by the gains.

    Attributes:
        axis: x, y, z or yaw.
        amplitude: of the command, given at time 0 [m/s or rad/s].
        gains: what the derivatives are by, in order: name and value.
        response: velocity along the axis [m/s], or yaw rate [rad/s].
        rotor_use: of every rotor, as share of its speed limit.
    """

    axis: str
    amplitude: float
    gains: dict[str, float]
    response: Curve
    rotor_use: tuple[Curve, ...]


def fly_carried(
    axis: str,
    amplitude: float,
    *,
    duration: float,
    heading: float = 0.0,
    scenario: Scenario | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> CarriedFlight:
    """Fly a step with derivatives by all parameters of the controller.

    Arguments are those of `fly_step`, and the yaw of the drone at the start, `heading` [rad].

    Raises:
        WorkbenchError: if the scenario varies the vehicle, or the law does not know its payload:
            the flight begins in a known hover.
    """
    config = (scenario or Scenario()).vehicle
    if config.variation != Variation():
        raise WorkbenchError(
            "sensitivities are those of the vehicle as its controller knows it: leave the "
            "variation out"
        )
    description = read_configured(config)
    vehicle = make_vehicle(description)
    controller = load_controller(scenario.controller if scenario else DEFAULT)
    if controller.designed:
        raise WorkbenchError(
            f"sensitivities need derivatives, and {controller.name} designs numbers of its gains: "
            "sweep them instead"
        )
    values = flight_gains(vehicle, config.gains, settings, controller)
    payload = payload_of(values)
    if payload.payload_mass != payload.known_payload_mass:
        raise WorkbenchError(
            "sensitivities are those of the vehicle as its controller knows it: set "
            f"known_payload_mass to payload_mass, {payload.payload_mass:g} kg"
        )
    gains = {row.name: values[row.name] for row in controller.parameters}
    core = make_flight_core(controller, description, vehicle, values)
    start = _hover(core, laden(vehicle, payload), heading)
    simulator = _prepared(core.ToAutoDiffXd(), start, axis, amplitude, list(gains.values()))
    count = round(duration / STEP)
    states, rates = [], []
    for index in range(count + 1):
        simulator.AdvanceTo(index * STEP)
        context = simulator.get_context()
        states.append(context.get_continuous_state_vector().CopyToVector())
        rates.append(simulator.get_system().EvalTimeDerivatives(context).CopyToVector())
        if progress:
            progress(index / count)
    time = STEP * np.arange(count + 1)
    state, rate = np.array(states), np.array(rates)
    rotors = range(_BODY, _BODY + len(vehicle.rotors))
    return CarriedFlight(
        axis=axis,
        amplitude=amplitude,
        gains=gains,
        response=_curve(time, state[:, _RATE[axis]], rate[:, _RATE[axis]], len(gains)),
        rotor_use=tuple(
            _curve(time, state[:, place] / limit, rate[:, place] / limit, len(gains))
            for place, limit in zip(
                rotors, (rotor.max_rot_velocity for rotor in vehicle.rotors), strict=True
            )
        ),
    )


def _hover(core: Diagram, vehicle: Vehicle, heading: float) -> np.ndarray:
    """Return the core's state (13 + n + 3) in hover with a yaw [rad]."""
    root = core.CreateDefaultContext()
    frame = thrust_frame(vehicle)
    state: np.ndarray = root.get_continuous_state_vector().CopyToVector()
    state[:_BODY] = body_state(
        p_WB=[0.0, 0.0, START_HEIGHT],
        roll_pitch_yaw=frame.roll_pitch_yaw([0.0, 0.0, heading]),
        v_WB=[0.0, 0.0, 0.0],
        w_WB=[0.0, 0.0, 0.0],
    )
    state[_BODY : _BODY + len(vehicle.rotors)] = frame.hover_speeds
    return state


def _prepared(core: Any, start: np.ndarray, axis: str, amplitude: float, gains: list[float]) -> Any:
    """Return a Simulator at hover with the command just given."""
    root = core.CreateDefaultContext()
    root.SetContinuousState(start)
    controller = core.GetSubsystemByName("controller").GetMyMutableContextFromRoot(root)
    carried = InitializeAutoDiff(np.array(gains)).ravel()
    controller.get_mutable_numeric_parameter(0).SetFromVector(carried)
    reference = np.zeros(len(Reference._fields))
    reference[AXES.index(axis)] = amplitude
    # as in flight, the place is held until a pilot steers; turning in place goes on holding it
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, START_HEIGHT)
    core.GetInputPort("reference").FixValue(root, reference)
    core.GetInputPort("guidance").FixValue(root, np.array(hold))
    simulator = Simulator_[AutoDiffXd](core, root)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", STEP)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.Initialize()
    return simulator


def _curve(time: np.ndarray, values: np.ndarray, slopes: np.ndarray, count: int) -> Curve:
    """Return a curve of AutoDiffXd values (N) and their derivatives by time (N)."""
    return Curve(
        time=time,
        value=ExtractValue(values).ravel(),
        slope=ExtractValue(slopes).ravel(),
        value_by_gain=_gradient(values, count),
        slope_by_gain=_gradient(slopes, count),
    )


def _gradient(values: np.ndarray, count: int) -> np.ndarray:
    """Return the derivatives (N, g) of AutoDiffXd values (N), of which some may carry none."""
    rows: np.ndarray = ExtractGradient(values.reshape(-1, 1))
    return rows if rows.shape[1] else np.zeros((len(values), count))
