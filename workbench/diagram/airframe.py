"""The vehicle in its world, and what acts on it."""

from dataclasses import dataclass

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort, System
from pydrake.systems.primitives import Multiplexer

from workbench.plant.description import Description
from workbench.plant.multibody import add_plant
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.systems.air.air_forces import air_forces
from workbench.systems.rotor_forces import add_rotor_forces


@dataclass(frozen=True)
class Airframe:
    """The vehicle without its rotors' dynamics: plant, ground, and where thrusts act on it.

    Attributes:
        plant: with the drone as one body.
        scene_graph: of the plant.
        thrusts: input of the rotors' thrusts (n) [N].
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    thrusts: InputPort

    @property
    def state(self) -> OutputPort:
        """State of the plant (13): q_WB, p_WB, w_WB_W, v_WB_W."""
        return self.plant.get_state_output_port()


def add_airframe(
    builder: DiagramBuilder, description: Description, vehicle: Vehicle, *, physics_step: float
) -> Airframe:
    """Add plant, ground and rotor forces; 0 as `physics_step` makes a continuous plant.

    There is no air but what the rotors push against: see `add_airframe_in_air`. Nothing is drawn.
    """
    plant, scene_graph = add_plant(builder, description.undrawn(), time_step=physics_step)
    forces = add_rotor_forces(builder, plant, vehicle)
    builder.Connect(
        forces.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
    )
    return Airframe(plant, scene_graph, forces.get_command_input_port())


def add_airframe_in_air(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    *,
    physics_step: float,
    world: World = EMPTY,
) -> tuple[Airframe, InputPort]:
    """Add the airframe, and return with it the port for what else acts on it.

    The port takes force [N] and moment about the base link's origin [N·m], in B (6). It is stacked
    with the thrusts, which costs time at every step: hence not for who has no air.
    """
    plant, scene_graph = add_plant(builder, description, time_step=physics_step, world=world)
    air = air_forces(plant, vehicle.base_link)
    forces = add_rotor_forces(builder, plant, vehicle, air)
    stack = builder.AddNamedSystem("stacked_forces", Multiplexer([len(vehicle.rotors), len(air)]))
    builder.Connect(stack.get_output_port(), forces.get_command_input_port())
    builder.Connect(
        forces.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
    )
    return Airframe(plant, scene_graph, stack.get_input_port(0)), stack.get_input_port(1)


def airframe_signals(airframe: Airframe, rotors: System) -> dict[str, OutputPort]:
    """Return what is recorded of every flight; `rotors` is the system that has them as state."""
    return {
        "state": airframe.state,
        "acceleration": airframe.plant.get_generalized_acceleration_output_port(),
        "thrusts": rotors.GetOutputPort("thrusts"),
        "rotors": rotors.GetOutputPort("memory"),
    }
