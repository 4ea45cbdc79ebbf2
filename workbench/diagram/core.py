"""The flight core: plant, rotors and law; continuous for design, and sampled as it flies."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import DiscreteTimeDelay

from workbench.diagram.airframe import Airframe, add_airframe, add_airframe_in_air
from workbench.parameters import parameters_of
from workbench.plant.description import Description
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle
from workbench.scenario import Rates
from workbench.systems.acceleration_estimate import make_acceleration_estimate
from workbench.systems.air.continuous_drag import ContinuousDrag, ContinuousDrag_
from workbench.systems.cascade import Gains
from workbench.systems.controller import CascadedController_
from workbench.systems.flight_computer import FlightComputer, FlightComputer_
from workbench.systems.rotor_lag import make_continuous_lag

STATE_DELAY = "state_delay"
"""Name of the system that lets the law see the state late, where there is one."""


def make_flight_core(
    description: Description, vehicle: Vehicle, gains: Mapping[str, float]
) -> Diagram:
    """Return plant, rotors, drag and controller as one continuous diagram.

    It converts to AutoDiffXd, and `Linearize` of it is exact. The law knows `vehicle`; what flies
    is `description`, which may be another, see `plant.variation`.

    Input ports: reference (8) and guidance (22), see `systems.cascade`; wind (3), the velocity of
    the air in W [m/s], still where nothing is connected.
    Output ports: state (13), thrusts (n) [N], speeds (n) [rad/s].
    """
    builder = DiagramBuilder()
    airframe, lag = _add_continuous_vehicle(builder, description, vehicle, gains)
    estimate = builder.AddNamedSystem("acceleration_estimate", make_acceleration_estimate())
    controller = builder.AddNamedSystem(
        "controller",
        CascadedController_[float](
            vehicle=vehicle, gains=Gains(**parameter_values("controller", gains))
        ),
    )
    builder.Connect(airframe.state, estimate.get_input_port())
    builder.Connect(airframe.state, controller.GetInputPort("state"))
    builder.Connect(estimate.get_output_port(), controller.GetInputPort("acceleration"))
    builder.Connect(controller.get_output_port(), lag.get_input_port())
    for name in ("reference", "guidance"):
        builder.ExportInput(controller.GetInputPort(name), name)
    air = builder.GetSubsystemByName("air")
    builder.ExportInput(air.GetInputPort("wind"), "wind")
    builder.ExportOutput(airframe.state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(lag.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("flight_core")
    return diagram


def make_vehicle_core(
    description: Description, vehicle: Vehicle, gains: Mapping[str, float]
) -> Diagram:
    """Return plant, rotors and drag without a controller as one continuous diagram.

    Input port: commands (n) of the rotors' speeds [rad/s]. Output ports: state (13), thrusts (n)
    [N], speeds (n) [rad/s]. It converts to AutoDiffXd.
    """
    builder = DiagramBuilder()
    airframe, lag = _add_continuous_vehicle(builder, description, vehicle, gains)
    builder.ExportInput(lag.get_input_port(), "commands")
    builder.ExportOutput(airframe.state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(lag.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("vehicle_core")
    return diagram


def _add_continuous_vehicle(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
) -> tuple[Airframe, Diagram]:
    """Add plant, rotor lag and drag, connected; `wind` of the system `air` is left open."""
    airframe, wrench = add_airframe_in_air(
        builder, description.undrawn(), vehicle, physics_step=0.0
    )
    lag = builder.AddSystem(make_continuous_lag(description.rotors))
    builder.Connect(lag.GetOutputPort("thrusts"), airframe.thrusts)
    air = add_drag(builder, airframe.state, lag.GetOutputPort("speeds"), vehicle, gains)
    builder.Connect(air.get_output_port(), wrench)
    return airframe, lag


def add_drag(
    builder: DiagramBuilder,
    state: OutputPort,
    speeds: OutputPort,
    vehicle: Vehicle,
    gains: Mapping[str, float],
) -> ContinuousDrag:
    """Add the drag of body and rotors, named `air`, in air that stands still."""
    drag = builder.AddNamedSystem(
        "air",
        ContinuousDrag_[float](
            vehicle=vehicle, drag_area=gains["drag_area"], air_density=gains["air_density"]
        ),
    )
    builder.Connect(state, drag.GetInputPort("state"))
    builder.Connect(speeds, drag.GetInputPort("speeds"))
    return drag


def add_sampled_core(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
) -> tuple[Airframe, FlightComputer]:
    """Add the same core as it flies: discrete plant, sampled controller, rotors held with it.

    There is no air around it.
    """
    airframe = add_airframe(builder, description, vehicle, physics_step=rates.physics_step)
    return airframe, add_computer(builder, airframe, description.rotors, vehicle, gains, rates)


def add_computer(
    builder: DiagramBuilder,
    airframe: Airframe,
    rotors: Sequence[Rotor],
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
    control_delay: int = 0,
) -> FlightComputer:
    """Add the sampled controller with the rotors, and connect the airframe.

    Args:
        builder: of the diagram.
        airframe: what flies.
        rotors: its own.
        vehicle: as the law knows it.
        gains: parameter values by name.
        rates: periods of what is sampled.
        control_delay: control periods by which the law sees the state late; the system
            `STATE_DELAY` remembers it.
    """
    computer = builder.AddNamedSystem(
        "controller",
        FlightComputer_[float](
            vehicle=vehicle,
            gains=Gains(**parameter_values("controller", gains)),
            period=rates.control_period,
            rotors=rotors,
        ),
    )
    state = airframe.state
    if control_delay:
        # sampling itself is the first period: what it puts out at an update is what it held before
        late = builder.AddNamedSystem(
            STATE_DELAY, DiscreteTimeDelay(rates.control_period, control_delay - 1, state.size())
        )
        builder.Connect(state, late.get_input_port())
        state = late.get_output_port()
    builder.Connect(state, computer.GetInputPort("state"))
    builder.Connect(computer.GetOutputPort("thrusts"), airframe.thrusts)
    return computer


def parameter_values(system: str, gains: Mapping[str, float]) -> dict[str, Any]:
    """Return one system's parameters by name."""
    return {row.name: gains[row.name] for row in parameters_of(system)}
