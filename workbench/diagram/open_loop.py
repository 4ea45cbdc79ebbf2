"""The airframe under rotor commands from outside the diagram, without a controller."""

from dataclasses import dataclass

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from workbench.diagram.airframe import Airframe, add_airframe, add_battery
from workbench.diagram.core import parameter_values
from workbench.dynamics.air.settings import calm_air
from workbench.plant.description import Description
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.recorder import Recorder, add_recorder
from workbench.systems.rotor_playback import RotorCommands, make_rotor_playback


@dataclass(frozen=True)
class OpenLoop:
    """The airframe under rotor commands from outside the diagram, without a controller."""

    diagram: Diagram
    airframe: Airframe
    recorder: Recorder


def make_open_loop(
    description: Description,
    vehicle: Vehicle,
    rates: Rates,
    commands: RotorCommands | LeafSystem,
    world: World = EMPTY,
) -> OpenLoop:
    """Return the airframe with a source of rotor commands in the controller's place, and recorder.

    The source is a table, or a system whose only output are speeds (n) [rad/s].

    There is a battery where the description states one.

    Rotors take their commands at every physics step, as a table's rows may begin at any time. Of a
    world there is what stands still; what moves touches nothing.
    """
    builder = DiagramBuilder()
    calm = parameter_table().defaults() | calm_air(vehicle)._asdict()
    airframe = add_airframe(builder, description.undrawn(), calm, rates=rates, world=world)
    add_moving_obstacles(builder, airframe.plant, airframe.scene_graph, world)
    if vehicle.battery:
        add_battery(
            builder, airframe, vehicle, **parameter_values("battery", parameter_table().defaults())
        )
    if isinstance(commands, RotorCommands):
        commands = make_rotor_playback(commands)
    playback = builder.AddNamedSystem("rotor_playback", commands)
    builder.Connect(playback.get_output_port(), airframe.commands)
    recorder = add_recorder(
        builder, airframe.signals(playback.get_output_port()), rates.record_period
    )
    diagram = builder.Build()
    diagram.set_name("open_loop")
    return OpenLoop(diagram, airframe, recorder)
