"""From a description to a finalised Drake `MultibodyPlant` that stands in a world."""

import copy
import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
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
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    PrismaticSpring,
    QuaternionFloatingJoint,
    RevoluteSpring,
    RigidBody,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.framework import Context, DiagramBuilder, InputPort
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from workbench.common.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import merged_model
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import Freedom, Joint, Model
from workbench.plant.sensors import free_name
from workbench.plant.shapes import box_corners, prism_corners
from workbench.plant.worlds.geometry import add_ground
from workbench.plant.worlds.world import EMPTY_WORLD, World

MAX_WORLD_BODY_SHAPES = 13
"""Largest number of shapes fixed to the world body itself if there is ground.

Shapes fixed to the world are in one bounding volume tree, built once. When the height of the tree
exceeds the logarithm of its number of leaves by 10, Drake 1.51 rebalances it. With the infinite box
of a half space among the leaves this ends in a segmentation fault, as all the sizes compared are
infinite. A tree of 14 leaves can never be that high."""
CORNER_RADIUS_M = 1e-3
"""Radius of the spheres at corners [m]."""
CYLINDER_SPHERE_COUNT = 8
"""Number of spheres around a cylinder."""
_OBSTACLES_BODY_NAME = "_obstacles"


def add_plant(
    builder: DiagramBuilder,
    description: Description,
    *,
    time_step: float,
    world: World = EMPTY_WORLD,
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add a finalised plant with the world around it and its scene graph.

    The drone is the body of its base link, and one for each joint that moves, see `merged_model`;
    its other links are frames on these. Rotors are part of their body at any speed: the effect of
    their spin is a force on it, see `systems.rotors`, and they turn only in the picture. Static
    obstacles are shapes of the world body; `systems.moving_obstacles` adds moving ones.

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


def add_shapes(builder: DiagramBuilder, description: Description) -> tuple[SceneGraph, InputPort]:
    """Add the scene of a vehicle that another system moves, in the empty world.

    Args:
        builder: the diagram being built.
        description: what flies.

    Returns:
        The scene graph, and the input port for the state of the body of the vehicle (13).

    Raises:
        WorkbenchError: as `add_plant` does.
    """
    plant = MultibodyPlant(0.0)  # of bodies and shapes, not a part of the diagram
    plant.set_name("plant")
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    _fill(plant, scene_graph, description, EMPTY_WORLD)
    poses = builder.AddNamedSystem(
        "poses", MultibodyPositionToGeometryPose(plant, input_multibody_state=True)
    )
    builder.Connect(
        poses.get_output_port(), scene_graph.get_source_pose_port(plant.get_source_id())
    )
    return scene_graph, poses.get_input_port()


def _fill(
    plant: MultibodyPlant, scene_graph: SceneGraph, description: Description, world: World
) -> None:
    """Add drone, ground and obstacles to a plant, and finalise it."""
    with _readable_errors(description.source):
        _add_drone(plant, description)
        plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -GRAVITY]))
    with _readable_errors(world.source):
        if world.ground:
            ground = add_ground(plant, scene_graph)
            drone = plant.GetBodyByName(description.base_link).model_instance()
            for body in plant.GetBodyIndices(drone):
                _add_corner_contacts(plant, scene_graph, plant.get_body(body), ground)
        _leave_out_own_contacts(plant, scene_graph, description.base_link)
        add_obstacles(plant, world)
    with _readable_errors(description.source):
        plant.Finalize()


def _add_drone(plant: MultibodyPlant, description: Description) -> None:
    """Add the drone's bodies, with frames named as its links, and the joints between them."""
    model = merged_model(description.model, description.base_link)
    ours = ("free", "ball")
    tied = tuple(_drakes_joint(each) for each in model.joints if each.kind not in ours)
    bare = dataclasses.replace(model, joints=tied, cables=())
    Parser(plant).AddModelsFromString(ET.tostring(write_urdf(bare), encoding="unicode"), "urdf")
    for frame in model.frames:
        body = plant.GetBodyByName(frame.link)
        plant.AddFrame(FixedOffsetFrame(frame.name, body.body_frame(), frame.X_LF))
    for joint in model.joints:
        if joint.kind in ours:
            _add_loose_joint(plant, model, joint)
        else:
            _add_dynamics(plant, joint)


def _add_loose_joint(plant: MultibodyPlant, model: Model, joint: Joint) -> None:
    """Add a ball joint, or one that ties a body to nothing.

    The state of the latter is the motion relative to the parent. So a load begins below the drone
    wherever this is, and at rest both have constant states. A ball joint has a frame of its own in
    the child, which flights turn, see `systems.ball_forces`.
    """
    parent, child = plant.GetBodyByName(joint.parent), plant.GetBodyByName(joint.child)
    above = model.link(joint.parent)
    assert above
    X_PJ = above.X_ML.InvertAndCompose(joint.X_MJ)
    instance = child.model_instance()
    taken = {plant.get_frame(each).name() for each in plant.GetFrameIndices(instance)}
    name = free_name(taken, f"{joint.name}_frame")
    frame = plant.AddFrame(FixedOffsetFrame(name, parent.body_frame(), X_PJ))
    if joint.kind == "free":
        plant.AddJoint(QuaternionFloatingJoint(joint.name, frame, child.body_frame()))
        return
    name = free_name(taken, f"{joint.name}_turned")
    turned = FixedOffsetFrame(name, child.body_frame(), RigidTransform())
    damping = joint.freedoms[0].damping
    plant.AddJoint(BallRpyJoint(joint.name, frame, plant.AddFrame(turned), damping))


def _drakes_joint(joint: Joint) -> Joint:
    """Return a joint with what Drake's continuous plant has: axis and damping, see
    `systems.joint_forces`.
    """
    (freedom,) = joint.freedoms
    bare = Freedom(freedom.kind, freedom.axis_J, damping=freedom.damping)
    return dataclasses.replace(joint, freedoms=(bare,), mimic=None)


def _add_dynamics(plant: MultibodyPlant, joint: Joint) -> None:
    """Add spring, armature and initial position of a joint to a plant that has it."""
    (freedom,), made = joint.freedoms, plant.GetJointByName(joint.name)
    made.set_default_positions([freedom.start])
    if freedom.armature:
        actuator = plant.AddJointActuator(joint.name, made)
        actuator.set_default_rotor_inertia(freedom.armature)
        actuator.set_default_gear_ratio(1.0)
    if freedom.stiffness:
        spring = RevoluteSpring if freedom.kind == "revolute" else PrismaticSpring
        plant.AddForceElement(spring(made, freedom.rest, freedom.stiffness))


def _leave_out_own_contacts(plant: MultibodyPlant, scene_graph: SceneGraph, base: str) -> None:
    """Let the bodies of the drone not touch each other, as in Gazebo without self_collide."""
    drone = plant.GetBodyIndices(plant.GetBodyByName(base).model_instance())
    if len(drone) > 1:
        bodies = [plant.GetBodyFrameIdOrThrow(each) for each in drone]
        scene_graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeWithin(GeometrySet(bodies))
        )


def _add_corner_contacts(
    plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody, ground: GeometryId
) -> None:
    """Let boxes and cylinders of a body of the drone touch the ground by spheres at their corners.

    In Drake such a shape and a half space have one point of contact, the deepest. It jumps from
    corner to corner, so a drone never rests, and trips where it slides.
    """
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    touching = inspector.GetGeometries(frame, Role.kProximity)
    flat = [each for each in touching if len(_corner_spheres(inspector.GetShape(each)))]
    for place, geometry in enumerate(flat):
        X_BG = RigidTransform(inspector.GetPoseInFrame(geometry))
        properties = ProximityProperties(inspector.GetProximityProperties(geometry))
        for number, corner in enumerate(_corner_spheres(inspector.GetShape(geometry))):
            plant.RegisterCollisionGeometry(
                body,
                X_BG @ RigidTransform(corner),
                Sphere(CORNER_RADIUS_M),
                f"corner_{place}_{number}",
                properties,
            )
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeBetween(GeometrySet(flat), GeometrySet(ground))
    )


def _corner_spheres(shape: Shape) -> np.ndarray:
    """Return the centres (n, 3) of spheres that touch a shape's faces at its corners."""
    match shape:
        case Box():
            return box_corners(np.maximum(0.5 * np.array(shape.size()) - CORNER_RADIUS_M, 0.0))
        case Cylinder():
            radius = max(0.0, shape.radius() - CORNER_RADIUS_M)
            height = max(0.0, 0.5 * shape.length() - CORNER_RADIUS_M)
            return prism_corners(radius, height, CYLINDER_SPHERE_COUNT)
        case _:
            return np.zeros((0, 3))


@contextmanager
def _readable_errors(source: Path) -> Iterator[None]:
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
    1000 shapes), but see `MAX_WORLD_BODY_SHAPES`. More shapes go to one body welded to the world;
    Drake updates their boxes at every step (14 µs for 24 shapes, 70 µs for 200).

    Raises:
        RuntimeError, ValueError: from Drake, if it does not accept a geometry.
    """
    count = sum(len(obstacle.collisions) for obstacle in world.obstacles)
    is_many = world.ground and count > MAX_WORLD_BODY_SHAPES
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
            plant.RegisterVisualGeometry(
                plant.world_body(), _placed_geometry(geometry, obstacle.X_WO)
            )


def _welded_body(plant: MultibodyPlant) -> RigidBody:
    """Return a new body welded to the world frame."""
    inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidSphere(1.0))  # of no effect
    body = plant.AddRigidBody(
        _OBSTACLES_BODY_NAME, plant.AddModelInstance(_OBSTACLES_BODY_NAME), inertia
    )
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    return body


def _placed_geometry(geometry: GeometryInstance, X_WO: RigidTransform) -> GeometryInstance:
    """Return a copy of an obstacle's geometry with its pose in the world."""
    placed = copy.copy(geometry)
    placed.set_pose(X_WO @ geometry.pose())
    return placed


def mobility(plant: MultibodyPlant, context: Context) -> np.ndarray:
    """Return the inverse of the mass matrix (nv, nv), zero for motions without inertia."""
    inverse: np.ndarray = np.linalg.pinv(plant.CalcMassMatrix(context))
    return inverse
