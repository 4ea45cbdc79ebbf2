"""Obstacles that move: shapes in the scene whose poses Drake's C++ systems find from time."""

import numpy as np
from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    Role,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RpyFloatingJoint, SpatialInertia, UnitInertia
from pydrake.polynomial import Polynomial
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.systems.rendering import MultibodyPositionToGeometryPose
from pydrake.trajectories import (
    PathParameterizedTrajectory,
    PiecewisePolynomial,
    StackedTrajectory,
    Trajectory,
)

from workbench.plant.worlds.world import MovingObstacle, World

MOTION_END_S = 1e6
"""Time for which they move; then they stop [s]."""
_PATH_REPETITIONS = 64
"""Repetitions of a path in a trajectory, which is then repeated itself, and so on."""


def add_moving_obstacles(builder: DiagramBuilder, scene_graph: SceneGraph, world: World) -> None:
    """Add the moving obstacles of a world to a diagram, if it has any.

    They have no contact: their poses are functions of time, and a drone flies through them without
    a force. Sensors see them, and signed distances include them. The first one costs 7 µs a step of
    the plant, each further one 1.5 µs.

    Args:
        builder: of the diagram.
        scene_graph: with all geometries of the finalised plant.
        world: with the paths.
    """
    if not world.moving:
        return
    kinematics = MultibodyPlant(0.0)
    kinematics.set_name("moving_obstacles")
    source = kinematics.RegisterAsSourceForSceneGraph(scene_graph)
    geometries = []
    path = StackedTrajectory()
    for moving in world.moving:
        inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidSphere(1.0))  # of no effect
        body = kinematics.AddRigidBody(moving.name, inertia)
        kinematics.AddJoint(
            RpyFloatingJoint(moving.name, kinematics.world_frame(), body.body_frame())
        )
        frame = kinematics.GetBodyFrameIdOrThrow(body.index())
        geometries.append(scene_graph.RegisterGeometry(source, frame, moving.geometry))
        path.Append(_path(moving))
    kinematics.Finalize()
    _exclude_contact(scene_graph, geometries)
    clock = builder.AddNamedSystem("obstacle_paths", TrajectorySource(path))
    poses = builder.AddNamedSystem("obstacle_poses", MultibodyPositionToGeometryPose(kinematics))
    builder.Connect(clock.get_output_port(), poses.get_input_port())
    builder.Connect(poses.get_output_port(), scene_graph.get_source_pose_port(source))


def _exclude_contact(scene_graph: SceneGraph, geometries: list[GeometryId]) -> None:
    """Exclude geometries from all contact."""
    everything = scene_graph.model_inspector().GetAllGeometryIds(Role.kProximity)
    declaration = CollisionFilterDeclaration().ExcludeBetween(
        GeometrySet(geometries), GeometrySet(everything)
    )
    scene_graph.collision_filter_manager().Apply(declaration)


def _path(moving: MovingObstacle) -> Trajectory:
    """Return roll, pitch, yaw, x, y, z (6) over `MOTION_END_S`, in the order of the joint."""
    course = moving.course
    rows = np.zeros((6, len(course.times)))
    x, y, z, yaw = np.transpose(course.corners)
    rows[2:] = yaw, x, y, z
    path: Trajectory = PiecewisePolynomial.FirstOrderHold(course.times, rows)
    while course.repeat and path.end_time() < MOTION_END_S:
        path = _repeated(path)
    return PathParameterizedTrajectory(path, _time([0.0, MOTION_END_S]))


def _repeated(path: Trajectory) -> Trajectory:
    """Return a path repeated `_PATH_REPETITIONS` times, without more memory for a longer
    horizon.
    """
    return PathParameterizedTrajectory(
        path, _time(path.end_time() * np.arange(_PATH_REPETITIONS + 1.0))
    )


def _time(breaks: list[float] | np.ndarray) -> PiecewisePolynomial:
    """Return time since the last of the breaks."""
    rising = Polynomial(np.array([0.0, 1.0]))
    return PiecewisePolynomial([rising] * (len(breaks) - 1), breaks)
