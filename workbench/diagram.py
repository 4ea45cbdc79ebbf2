"""The only file that wires rooms together: the flight core, and the workbench around it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    LinearSystem,
    LogVectorOutput,
    Multiplexer,
    VectorLogSink,
)
from pydrake.trajectories import PiecewisePolynomial

from workbench.parameters import parameters_of
from workbench.plant.description import Description
from workbench.plant.multibody import add_plant
from workbench.plant.vehicle import Vehicle
from workbench.scenario import Rates
from workbench.systems.acceleration_estimate import make_acceleration_estimate
from workbench.systems.battery import Battery
from workbench.systems.cascade import Gains
from workbench.systems.controller import INPUT_SIZES, CascadedController
from workbench.systems.flight_mode import Settings
from workbench.systems.mode_manager import ModeManager
from workbench.systems.reference import add_reference
from workbench.systems.rotor_forces import add_rotor_forces
from workbench.systems.rotor_lag import make_rotor_lag
from workbench.systems.sampling import add_hold


@dataclass(frozen=True)
class Airframe:
    """The vehicle alone: plant, rotors, and the ports between which a controller goes."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    commanded_speeds: InputPort
    thrusts: OutputPort
    state: OutputPort
    rotor_lag: Diagram


@dataclass(frozen=True)
class Core:
    """An airframe and its controller; `reference` and `guidance` wait to be connected."""

    airframe: Airframe
    estimate: LinearSystem
    rotor_speeds: OutputPort
    reference: InputPort
    guidance: InputPort


@dataclass(frozen=True)
class Workbench:
    """The full diagram, with the systems that a session reads and writes."""

    diagram: Diagram
    vehicle: Vehicle
    core: Core
    pilot: ConstantVectorSource
    request: ConstantVectorSource
    modes: ModeManager
    logs: Mapping[str, VectorLogSink]


def add_airframe(
    builder: DiagramBuilder, description: Description, vehicle: Vehicle, *, physics_step: float
) -> Airframe:
    """Add plant, ground and rotors; 0 as `physics_step` makes all of it continuous."""
    plant, scene_graph = add_plant(builder, description, time_step=physics_step)
    lag = builder.AddSystem(make_rotor_lag(vehicle.rotors, time_step=physics_step))
    forces = add_rotor_forces(builder, plant, vehicle)
    builder.Connect(lag.get_output_port(), forces.get_command_input_port())
    return Airframe(
        plant=plant,
        scene_graph=scene_graph,
        commanded_speeds=lag.get_input_port(),
        thrusts=lag.get_output_port(),
        state=plant.get_state_output_port(),
        rotor_lag=lag,
    )


def add_core(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    *,
    physics_step: float,
    control_period: float,
) -> Core:
    """Add the airframe and its controller, held at `control_period` or, where that is 0, not."""
    airframe = add_airframe(builder, description, vehicle, physics_step=physics_step)
    estimate = builder.AddNamedSystem(
        "acceleration_estimate", make_acceleration_estimate(period=control_period)
    )
    values = Gains(**_values("controller_gains", gains))
    source = builder.AddNamedSystem("controller_gains", ConstantVectorSource(list(values)))
    signals = builder.AddNamedSystem(
        "controller_signals", Multiplexer(list(INPUT_SIZES.values()))
    )
    controller = builder.AddNamedSystem("controller", CascadedController(vehicle=vehicle))
    ports = {name: signals.get_input_port(index) for index, name in enumerate(INPUT_SIZES)}
    builder.Connect(airframe.state, estimate.get_input_port())
    builder.Connect(airframe.state, ports["state"])
    builder.Connect(estimate.get_output_port(), ports["acceleration"])
    builder.Connect(source.get_output_port(), ports["gains"])
    builder.Connect(signals.get_output_port(), controller.get_input_port())
    speeds = add_hold(builder, controller.GetOutputPort("rotor_speeds"), control_period)
    builder.Connect(speeds, airframe.commanded_speeds)
    return Core(
        airframe=airframe,
        estimate=estimate,
        rotor_speeds=speeds,
        reference=ports["reference"],
        guidance=ports["guidance"],
    )


def make_flight_core(
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    *,
    physics_step: float = 0.0,
    control_period: float = 0.0,
) -> Diagram:
    """Return plant, rotors and controller as one diagram.

    With both periods 0 it is continuous, converts to AutoDiffXd, and `Linearize` is exact.

    Input ports: reference (8) and guidance (9), see `systems.cascade`.
    Output ports: state (13), rotor_speeds (n) [rad/s], thrusts (n) [N].
    """
    builder = DiagramBuilder()
    core = add_core(
        builder,
        description,
        vehicle,
        gains,
        physics_step=physics_step,
        control_period=control_period,
    )
    builder.ExportInput(core.reference, "reference")
    builder.ExportInput(core.guidance, "guidance")
    builder.ExportOutput(core.airframe.state, "state")
    builder.ExportOutput(core.rotor_speeds, "rotor_speeds")
    builder.ExportOutput(core.airframe.thrusts, "thrusts")
    diagram = builder.Build()
    diagram.set_name("flight_core")
    return diagram


def make_workbench(
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
    path: PiecewisePolynomial,
) -> Workbench:
    """Return the core with pilot, path, flight mode, battery and recorder around it.

    Args:
        description: what flies.
        vehicle: its record.
        gains: a value for every row of the parameter table, by name.
        rates: periods of everything that is sampled.
        path: `cascade.Reference` vectors over time, added to the pilot's.
    """
    builder = DiagramBuilder()
    core = add_core(
        builder,
        description,
        vehicle,
        gains,
        physics_step=rates.physics_step,
        control_period=rates.control_period,
    )
    pilot, reference = add_reference(builder, path)
    request = builder.AddNamedSystem("request", ConstantVectorSource([0.0, 0.0, 0.0]))
    modes = builder.AddNamedSystem(
        "modes", ModeManager(period=rates.mode_period, settings=Settings(**_values("modes", gains)))
    )
    battery = builder.AddNamedSystem(
        "battery", Battery(vehicle=vehicle, duration=gains["battery_duration"])
    )
    builder.Connect(reference, core.reference)
    builder.Connect(modes.GetOutputPort("guidance"), core.guidance)
    builder.Connect(core.airframe.state, modes.GetInputPort("state"))
    builder.Connect(reference, modes.GetInputPort("reference"))
    builder.Connect(request.get_output_port(), modes.GetInputPort("request"))
    builder.Connect(battery.GetOutputPort("charge"), modes.GetInputPort("charge"))
    builder.Connect(core.airframe.thrusts, battery.GetInputPort("thrusts"))
    signals = {
        "state": core.airframe.state,
        "acceleration": core.airframe.plant.get_generalized_acceleration_output_port(),
        "rotor_speeds": core.rotor_speeds,
        "thrusts": core.airframe.thrusts,
        "reference": reference,
        "mode": modes.GetOutputPort("mode"),
        "charge": battery.GetOutputPort("charge"),
    }
    logs = _record(builder, signals, rates.record_period)
    diagram = builder.Build()
    diagram.set_name("workbench")
    return Workbench(diagram, vehicle, core, pilot, request, modes, logs)


def _record(
    builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float
) -> dict[str, VectorLogSink]:
    """Add a log for every signal."""
    logs = {}
    for name, port in signals.items():
        logs[name] = LogVectorOutput(port, builder, period)
        logs[name].set_name(f"log_{name}")
    return logs


def _values(system: str, gains: Mapping[str, float]) -> dict[str, Any]:
    """Return one system's parameters by name."""
    return {row.name: gains[row.name] for row in parameters_of(system)}
