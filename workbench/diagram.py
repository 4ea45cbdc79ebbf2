"""The only file that wires rooms together: the flight core, and the workbench around it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, SceneGraph
from pydrake.multibody.plant import MultibodyPlant, Propeller
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource
from pydrake.trajectories import PiecewisePolynomial

from workbench.parameters import parameters_of
from workbench.plant.description import Description
from workbench.plant.multibody import add_plant
from workbench.plant.vehicle import Vehicle
from workbench.scenario import Rates
from workbench.systems.acceleration_estimate import make_acceleration_estimate
from workbench.systems.battery import Battery
from workbench.systems.cascade import Gains
from workbench.systems.controller import CascadedController
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.flight_mode import Settings
from workbench.systems.mode_manager import ModeManager
from workbench.systems.propeller_display import add_propeller_display
from workbench.systems.recorder import Recorder, add_recorder
from workbench.systems.reference import add_reference
from workbench.systems.rotor_forces import add_rotor_forces
from workbench.systems.rotor_lag import HeldRotors, make_continuous_lag
from workbench.systems.rotor_playback import RotorCommands, make_rotor_playback

PICTURE_PERIOD = 1 / 32
"""Between pictures in Meshcat [s]."""


@dataclass(frozen=True)
class Airframe:
    """The vehicle without its rotors' dynamics: plant, ground, and where thrusts act on it."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    forces: Propeller

    @property
    def state(self) -> OutputPort:
        """State of the plant (13): q_WB, p_WB, w_WB_W, v_WB_W."""
        return self.plant.get_state_output_port()

    @property
    def thrusts(self) -> InputPort:
        """Thrusts of the rotors (n) [N]."""
        return self.forces.get_command_input_port()


@dataclass(frozen=True)
class Workbench:
    """The full diagram, with the systems that a session reads and writes."""

    diagram: Diagram
    vehicle: Vehicle
    airframe: Airframe
    computer: FlightComputer
    pilot: ConstantVectorSource
    request: ConstantVectorSource
    modes: ModeManager
    recorder: Recorder


@dataclass(frozen=True)
class OpenLoop:
    """The airframe under a table of rotor commands, without a controller."""

    diagram: Diagram
    airframe: Airframe
    rotors: HeldRotors
    recorder: Recorder


def add_airframe(
    builder: DiagramBuilder, description: Description, vehicle: Vehicle, *, physics_step: float
) -> Airframe:
    """Add plant, ground and rotor forces; 0 as `physics_step` makes a continuous plant."""
    plant, scene_graph = add_plant(builder, description, time_step=physics_step)
    return Airframe(plant, scene_graph, add_rotor_forces(builder, plant, vehicle))


def make_flight_core(
    description: Description, vehicle: Vehicle, gains: Mapping[str, float]
) -> Diagram:
    """Return plant, rotors and controller as one continuous diagram.

    It converts to AutoDiffXd, and `Linearize` of it is exact.

    Input ports: reference (8) and guidance (9), see `systems.cascade`.
    Output ports: state (13), thrusts (n) [N], speeds (n) [rad/s].
    """
    builder = DiagramBuilder()
    airframe = add_airframe(builder, description, vehicle, physics_step=0.0)
    lag = builder.AddSystem(make_continuous_lag(vehicle.rotors))
    estimate = builder.AddNamedSystem("acceleration_estimate", make_acceleration_estimate())
    controller = builder.AddNamedSystem(
        "controller",
        CascadedController(vehicle=vehicle, gains=Gains(**_values("controller", gains))),
    )
    builder.Connect(airframe.state, estimate.get_input_port())
    builder.Connect(airframe.state, controller.GetInputPort("state"))
    builder.Connect(estimate.get_output_port(), controller.GetInputPort("acceleration"))
    builder.Connect(controller.get_output_port(), lag.get_input_port())
    builder.Connect(lag.GetOutputPort("thrusts"), airframe.thrusts)
    for name in ("reference", "guidance"):
        builder.ExportInput(controller.GetInputPort(name), name)
    builder.ExportOutput(airframe.state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(lag.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("flight_core")
    return diagram


def add_sampled_core(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
) -> tuple[Airframe, FlightComputer]:
    """Add the same core as it flies: discrete plant, sampled controller, rotors held with it."""
    airframe = add_airframe(builder, description, vehicle, physics_step=rates.physics_step)
    computer = builder.AddNamedSystem(
        "controller",
        FlightComputer(
            vehicle=vehicle,
            gains=Gains(**_values("controller", gains)),
            period=rates.control_period,
        ),
    )
    builder.Connect(airframe.state, computer.GetInputPort("state"))
    builder.Connect(computer.GetOutputPort("thrusts"), airframe.thrusts)
    return airframe, computer


def make_workbench(
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
    path: PiecewisePolynomial | None = None,
    meshcat: Meshcat | None = None,
) -> Workbench:
    """Return the core with pilot, path, flight mode, battery and recorder around it.

    Args:
        description: what flies.
        vehicle: its record.
        gains: a value for every row of the parameter table, by name.
        rates: periods of everything that is sampled.
        path: `cascade.Reference` vectors over time, added to the pilot's, if there is one.
        meshcat: where to draw, if anywhere.
    """
    builder = DiagramBuilder()
    airframe, computer = add_sampled_core(builder, description, vehicle, gains, rates)
    pilot, reference = add_reference(builder, path)
    request = builder.AddNamedSystem("request", ConstantVectorSource([0.0, 0.0, 0.0]))
    modes = builder.AddNamedSystem(
        "modes",
        ModeManager(
            period=rates.mode_period,
            settings=Settings(**_values("modes", gains)),
            standing_height=vehicle.ground_clearance,
        ),
    )
    battery = builder.AddNamedSystem(
        "battery", Battery(vehicle=vehicle, duration=gains["battery_duration"])
    )
    builder.Connect(reference, computer.GetInputPort("reference"))
    builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
    builder.Connect(airframe.state, modes.GetInputPort("state"))
    builder.Connect(reference, modes.GetInputPort("reference"))
    builder.Connect(request.get_output_port(), modes.GetInputPort("request"))
    builder.Connect(battery.GetOutputPort("charge"), modes.GetInputPort("charge"))
    builder.Connect(computer.GetOutputPort("thrusts"), battery.GetInputPort("thrusts"))
    signals = _airframe_signals(airframe, computer) | {
        "reference": reference,
        "mode": modes.GetOutputPort("mode"),
        "charge": battery.GetOutputPort("charge"),
    }
    recorder = add_recorder(builder, signals, rates.record_period)
    if meshcat is not None:
        _draw(builder, airframe, vehicle, computer, meshcat)
    diagram = builder.Build()
    diagram.set_name("workbench")
    return Workbench(diagram, vehicle, airframe, computer, pilot, request, modes, recorder)


def make_open_loop(
    description: Description, vehicle: Vehicle, rates: Rates, commands: RotorCommands
) -> OpenLoop:
    """Return the airframe with a table of rotor commands in the controller's place, and recorder.

    Rotors take their commands at every physics step, as a table's rows may begin at any time.
    """
    builder = DiagramBuilder()
    airframe = add_airframe(builder, description, vehicle, physics_step=rates.physics_step)
    rotors = builder.AddNamedSystem(
        "rotors", HeldRotors(rotors=vehicle.rotors, period=rates.physics_step)
    )
    playback = builder.AddNamedSystem("rotor_playback", make_rotor_playback(commands))
    builder.Connect(playback.get_output_port(), rotors.get_input_port())
    builder.Connect(rotors.GetOutputPort("thrusts"), airframe.thrusts)
    recorder = add_recorder(builder, _airframe_signals(airframe, rotors), rates.record_period)
    diagram = builder.Build()
    diagram.set_name("open_loop")
    return OpenLoop(diagram, airframe, rotors, recorder)


def _draw(
    builder: DiagramBuilder,
    airframe: Airframe,
    vehicle: Vehicle,
    computer: FlightComputer,
    meshcat: Meshcat,
) -> None:
    """Draw the scene, with propellers that turn."""
    add_propeller_display(
        builder,
        airframe.plant,
        airframe.scene_graph,
        vehicle,
        computer.GetOutputPort("memory"),
        period=PICTURE_PERIOD,
    )
    MeshcatVisualizer.AddToBuilder(
        builder,
        airframe.scene_graph,
        meshcat,
        MeshcatVisualizerParams(publish_period=PICTURE_PERIOD),
    )


def _airframe_signals(airframe: Airframe, rotors: System) -> dict[str, OutputPort]:
    """Return what is recorded of every flight; `rotors` is the system that has them as state."""
    return {
        "state": airframe.state,
        "acceleration": airframe.plant.get_generalized_acceleration_output_port(),
        "thrusts": rotors.GetOutputPort("thrusts"),
        "rotors": rotors.GetOutputPort("memory"),
    }


def _values(system: str, gains: Mapping[str, float]) -> dict[str, Any]:
    """Return one system's parameters by name."""
    return {row.name: gains[row.name] for row in parameters_of(system)}
