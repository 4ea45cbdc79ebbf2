"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import FixedOffsetFrame
from pydrake.systems.framework import DiagramBuilder, InputPort
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from workbench.common.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import gathered
from workbench.plant.gravity import GRAVITY
from workbench.plant.ground import add_ground
from workbench.plant.worlds.placing import add_obstacles
from workbench.plant.worlds.world import EMPTY, World


def add_plant(
    builder: DiagramBuilder, description: Description, *, time_step: float, world: World = EMPTY
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with the world around it and its scene graph.

    The drone is one body, that of its base link; its other links are frames on it. Rotors are
    part of it at any speed: what their spin does is a force on it, see `systems.dynamics`, and
    only the picture turns them. Obstacles that stand still are shapes of the world body, and
    those that move are added by `systems.moving_obstacles`.

    Args:
        builder: the diagram being built.
        description: what flies.
        time_step: step of the discrete plant [s]; 0 makes a continuous plant.
        world: where it flies.

    Raises:
        WorkbenchError: if Drake refuses the description or the world.
    """
    config = MultibodyPlantConfig(
        time_step=time_step,
        use_sampled_output_ports=False,
        contact_model="point",
        discrete_contact_approximation="sap",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    _fill(plant, scene_graph, description, world)
    return plant, scene_graph


def add_shapes(
    builder: DiagramBuilder, description: Description, world: World = EMPTY
) -> tuple[MultibodyPlant, SceneGraph, InputPort]:
    """Add the scene of a vehicle that something else moves.

    Args:
        builder: the diagram being built.
        description: what flies.
        world: where it flies.

    Returns:
        A plant that is no system of the diagram and knows bodies and shapes; the scene graph; and
        the port for the state of the vehicle's body (13).

    Raises:
        WorkbenchError: as `add_plant` does.
    """
    plant = MultibodyPlant(0.0)
    plant.set_name("plant")
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    _fill(plant, scene_graph, description, world)
    poses = builder.AddNamedSystem(
        "poses", MultibodyPositionToGeometryPose(plant, input_multibody_state=True)
    )
    builder.Connect(
        poses.get_output_port(), scene_graph.get_source_pose_port(plant.get_source_id())
    )
    return plant, scene_graph, poses.get_input_port()


def _fill(
    plant: MultibodyPlant, scene_graph: SceneGraph, description: Description, world: World
) -> None:
    """Put drone, ground and obstacles into a plant, and finalise it."""
    with _sentences(description.source):
        _add_drone(plant, description)
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
    with _sentences(world.source):
        if world.ground:
            add_ground(plant, scene_graph)
        add_obstacles(plant, world)
    with _sentences(description.source):
        plant.Finalize()


def _add_drone(plant: MultibodyPlant, description: Description) -> None:
    """Add the drone's body, with frames named as its links."""
    model = gathered(description.model, description.base_link)
    Parser(plant).AddModelsFromString(ET.tostring(write_urdf(model), encoding="unicode"), "urdf")
    base = plant.GetBodyByName(description.base_link)
    for frame in model.frames:
        plant.AddFrame(FixedOffsetFrame(frame.name, base.body_frame(), frame.X_LF))


@contextmanager
def _sentences(source: Path) -> Iterator[None]:
    """Turn what Drake says of a file into a sentence."""
    try:
        yield
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{source}: Drake refuses it: {reason}") from error
