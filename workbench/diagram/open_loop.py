"""The airframe under a table of rotor commands, without a controller."""

from dataclasses import dataclass

from pydrake.systems.framework import Diagram, DiagramBuilder

from workbench.diagram.airframe import Airframe, add_airframe_in_air, airframe_signals
from workbench.plant.description import Description
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario import Rates
from workbench.systems.air.air import add_air
from workbench.systems.air.settings import calm_air
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.recorder import Recorder, add_recorder
from workbench.systems.rotor_lag import HeldRotors
from workbench.systems.rotor_playback import RotorCommands, make_rotor_playback


@dataclass(frozen=True)
class OpenLoop:
    """The airframe under a table of rotor commands, without a controller."""

    diagram: Diagram
    airframe: Airframe
    rotors: HeldRotors
    recorder: Recorder


def make_open_loop(
    description: Description,
    vehicle: Vehicle,
    rates: Rates,
    commands: RotorCommands,
    world: World = EMPTY,
) -> OpenLoop:
    """Return the airframe with a table of rotor commands in the controller's place, and recorder.

    Rotors take their commands at every physics step, as a table's rows may begin at any time. Of a
    world there is what stands still; what moves touches nothing.
    """
    builder = DiagramBuilder()
    airframe, wrench = add_airframe_in_air(
        builder, description.undrawn(), vehicle, physics_step=rates.physics_step, world=world
    )
    add_moving_obstacles(builder, airframe.plant, airframe.scene_graph, world)
    rotors = builder.AddNamedSystem(
        "rotors", HeldRotors(rotors=description.rotors, period=rates.physics_step)
    )
    playback = builder.AddNamedSystem("rotor_playback", make_rotor_playback(commands))
    builder.Connect(playback.get_output_port(), rotors.get_input_port())
    builder.Connect(rotors.GetOutputPort("thrusts"), airframe.thrusts)
    memory, calm = rotors.GetOutputPort("memory"), calm_air(vehicle)
    air = add_air(builder, airframe.state, memory, wrench, vehicle, calm, rates.control_period)
    signals = airframe_signals(airframe, rotors) | {"wind": air.GetOutputPort("wind")}
    recorder = add_recorder(builder, signals, rates.record_period)
    diagram = builder.Build()
    diagram.set_name("open_loop")
    return OpenLoop(diagram, airframe, rotors, recorder)
