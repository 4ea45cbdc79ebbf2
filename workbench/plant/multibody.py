"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.geometry import GeometryInstance, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import FixedOffsetFrame, RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.framework import DiagramBuilder, InputPort
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from workbench.common.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import gathered
from workbench.plant.gravity import GRAVITY
from workbench.plant.worlds.geometry import add_ground
from workbench.plant.worlds.world import EMPTY, World

MOST_BESIDE_THE_GROUND = 13
"""So many shapes may be fixed to the world itself where there is ground.

What is fixed to the world is in one tree of boxes, built once. When the tree is higher than the
logarithm of its number of leaves by 10, Drake 1.51 balances it anew, and with the endless box of a
half space among the leaves that ends in a segmentation fault (the sizes that it compares are all
infinite). A tree of 14 leaves cannot be so high, however it grew.
"""
_BODY = "_obstacles"


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


def add_obstacles(plant: MultibodyPlant, world: World) -> None:
    """Add the shapes of a world's obstacles to a plant, before it is finalised.

    They get no bodies of their own, as each body takes time at every step: 24 obstacles as 24
    welded bodies double a step of 20 µs. Fixed to the world's body they cost nearly nothing (1000
    shapes 3 µs), but see `MOST_BESIDE_THE_GROUND`; where they are more, one body that is welded
    to the world has them, whose boxes Drake places anew at every step (24 shapes 14 µs, 200 70 µs).

    Raises:
        RuntimeError, ValueError: from Drake, if it does not take a geometry.
    """
    count = sum(len(obstacle.collisions) for obstacle in world.obstacles)
    is_many = world.ground and count > MOST_BESIDE_THE_GROUND
    touched = _welded_body(plant) if is_many else plant.world_body()
    for obstacle in world.obstacles:
        for geometry in obstacle.collisions:
            plant.RegisterCollisionGeometry(
                touched,
                obstacle.X_WO @ geometry.pose(),
                geometry.shape(),
                geometry.name(),
                geometry.proximity_properties(),
            )
        for geometry in obstacle.visuals:
            plant.RegisterVisualGeometry(plant.world_body(), _placed(geometry, obstacle.X_WO))


def _welded_body(plant: MultibodyPlant) -> RigidBody:
    """Return a new body whose frame is the world's."""
    inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidSphere(1.0))  # of no effect
    body = plant.AddRigidBody(_BODY, plant.AddModelInstance(_BODY), inertia)
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    return body


def _placed(geometry: GeometryInstance, X_WO: RigidTransform) -> GeometryInstance:
    """Return a copy of an obstacle's geometry with its pose in the world."""
    placed = copy.copy(geometry)
    placed.set_pose(X_WO @ geometry.pose())
    return placed
