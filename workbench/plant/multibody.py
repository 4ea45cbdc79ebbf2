"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.geometry import (
    Box,
    CollisionFilterDeclaration,
    Cylinder,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    Role,
    SceneGraph,
    Shape,
    Sphere,
)
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
"""Largest number of shapes fixed to the world body itself if there is ground.

Shapes fixed to the world are in one bounding volume tree, built once. When the height of the tree
exceeds the logarithm of its number of leaves by 10, Drake 1.51 rebalances it. With the infinite box
of a half space among the leaves this ends in a segmentation fault, as all the sizes compared are
infinite. A tree of 14 leaves can never be that high."""
CORNER = 1e-3
"""Radius of the spheres at corners [m]."""
AROUND = 8
"""Number of spheres around a cylinder."""
_BODY = "_obstacles"


def add_plant(
    builder: DiagramBuilder, description: Description, *, time_step: float, world: World = EMPTY
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with the world around it and its scene graph.

    The drone is the body of its base link, and one for each joint that moves, see `gathered`; its
    other links are frames on these. Rotors are part of their body at any speed: the effect of their
    spin is a force on it, see `systems.rotors`, and they turn only in the picture. Static obstacles
    are shapes of the world body; `systems.moving_obstacles` adds moving ones.

    Args:
        builder: the diagram being built.
        description: what flies.
        time_step: step of the discrete plant [s]; 0 makes a continuous plant.
        world: where it flies.

    Raises:
        WorkbenchError: if Drake rejects the description or the world.
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
    """Add the scene of a vehicle that another system moves.

    Args:
        builder: the diagram being built.
        description: what flies.
        world: where it flies.

    Returns:
        A plant with the bodies and shapes, which is not part of the diagram; the scene graph; and
        the input port for the state of the body of the vehicle (13).

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
    """Add drone, ground and obstacles to a plant, and finalise it."""
    with _sentences(description.source):
        _add_drone(plant, description)
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
    with _sentences(world.source):
        if world.ground:
            ground = add_ground(plant, scene_graph)
            drone = plant.GetBodyByName(description.base_link).model_instance()
            for body in plant.GetBodyIndices(drone):
                _touch_at_corners(plant, scene_graph, plant.get_body(body), ground)
        add_obstacles(plant, world)
    with _sentences(description.source):
        plant.Finalize()


def _add_drone(plant: MultibodyPlant, description: Description) -> None:
    """Add the drone's body, with frames named as its links."""
    model = gathered(description.model, description.base_link)
    Parser(plant).AddModelsFromString(ET.tostring(write_urdf(model), encoding="unicode"), "urdf")
    for frame in model.frames:
        body = plant.GetBodyByName(frame.link)
        plant.AddFrame(FixedOffsetFrame(frame.name, body.body_frame(), frame.X_LF))


def _touch_at_corners(
    plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody, ground: GeometryId
) -> None:
    """Let boxes and cylinders of a body of the drone touch the ground by spheres at their corners.

    In Drake such a shape and a half space have one point of contact, the deepest. It jumps from
    corner to corner, so a drone never rests, and trips where it slides.
    """
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    touching = inspector.GetGeometries(frame, Role.kProximity)
    flat = [each for each in touching if len(_corners(inspector.GetShape(each)))]
    for place, geometry in enumerate(flat):
        X_BG = RigidTransform(inspector.GetPoseInFrame(geometry))
        properties = ProximityProperties(inspector.GetProximityProperties(geometry))
        for number, corner in enumerate(_corners(inspector.GetShape(geometry))):
            plant.RegisterCollisionGeometry(
                body,
                X_BG @ RigidTransform(corner),
                Sphere(CORNER),
                f"corner_{place}_{number}",
                properties,
            )
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeBetween(GeometrySet(flat), GeometrySet(ground))
    )


def _corners(shape: Shape) -> np.ndarray:
    """Return the centres (n, 3) of spheres that touch a shape's faces at its corners."""
    match shape:
        case Box():
            inner = np.maximum(0.5 * np.array(shape.size()) - CORNER, 0.0)
            return inner * np.array(list(product((-1.0, 1.0), repeat=3)))
        case Cylinder():
            angles = np.arange(AROUND) * 2.0 * np.pi / AROUND
            radius = max(0.0, shape.radius() - CORNER)
            rim = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
            height = max(0.0, 0.5 * shape.length() - CORNER)
            return np.concatenate([np.c_[rim, np.full(AROUND, z)] for z in (-height, height)])
        case _:
            return np.zeros((0, 3))


@contextmanager
def _sentences(source: Path) -> Iterator[None]:
    """Turn Drake's message about a file into a sentence."""
    try:
        yield
    except (RuntimeError, ValueError, SystemExit) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{source}: Drake refuses it: {reason}") from error


def add_obstacles(plant: MultibodyPlant, world: World) -> None:
    """Add the shapes of a world's obstacles to a plant, before it is finalised.

    They get no bodies of their own, as each body takes time at every step: 24 obstacles as 24
    welded bodies double a step of 20 µs. Fixed to the world body they cost almost nothing (3 µs for
    1000 shapes), but see `MOST_BESIDE_THE_GROUND`. More shapes go to one body welded to the world;
    Drake updates their boxes at every step (14 µs for 24 shapes, 70 µs for 200).

    Raises:
        RuntimeError, ValueError: from Drake, if it does not accept a geometry.
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
    """Return a new body welded to the world frame."""
    inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidSphere(1.0))  # of no effect
    body = plant.AddRigidBody(_BODY, plant.AddModelInstance(_BODY), inertia)
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    return body


def _placed(geometry: GeometryInstance, X_WO: RigidTransform) -> GeometryInstance:
    """Return a copy of an obstacle's geometry with its pose in the world."""
    placed = copy.copy(geometry)
    placed.set_pose(X_WO @ geometry.pose())
    return placed
