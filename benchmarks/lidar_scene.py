"""The scene of the lidar's benchmark: 20 shapes, four of them moving, over a ground."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from pydrake.common.value import Value
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    Mesh,
    PerceptionProperties,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource

from workbench.plant.sensors import Lidar as LidarRecord
from workbench.plant.sensors import Noise, ScanAxis
from workbench.systems.casting.caster import Caster
from workbench.systems.casting.scene import CastScene, collect_scene
from workbench.systems.sensors.lidar import LidarSensor

STEP = 1 / 1024
MOVING = 4
RECORD = LidarRecord(
    name="lidar",
    type="gpu_lidar",
    frame="lidar",
    link="base",
    rate=1 / STEP,
    p_BS=(0.0, 0.0, 0.05),
    R_BS=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    horizontal=ScanAxis(360, -math.pi, math.pi),
    vertical=ScanAxis(16, -0.26, 0.26),
    min_range=0.1,
    max_range=30.0,
    noise=Noise(stddev=0.01),
)
HEIGHT = 1.5


def make_shapes() -> list[tuple[Shape, RigidTransform]]:
    """Return shapes and their poses, the moving ones first."""
    random = np.random.default_rng(20)
    kinds: list[Shape] = [Box(1.0, 1.5, 2.0), Sphere(0.6), Cylinder(0.4, 2.5), Capsule(0.4, 1.2)]
    found = []
    for number in range(20):
        turn = RollPitchYaw(*random.uniform(-0.5, 0.5, 3))
        angle, away = random.uniform(-math.pi, math.pi), random.uniform(3.0, 14.0)
        place = [away * math.cos(angle), away * math.sin(angle), random.uniform(0.5, 2.5)]
        found.append((kinds[number % 4], RigidTransform(turn, place)))
    return found


def lidar_in_a_diagram() -> tuple[LidarSensor, Simulator]:
    """Return a lidar that scans at every step of a weightless body's plant."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, STEP)
    plant.AddRigidBody("base", SpatialInertia.SolidBoxWithMass(1.0, 0.3, 0.3, 0.1))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    world = plant.world_body()
    green = np.array([0.0, 1.0, 0.0, 1.0])
    plant.RegisterVisualGeometry(world, RigidTransform(), HalfSpace(), "ground", green)
    source = scene_graph.RegisterSource("moving")
    poses = FramePoseVector()
    for number, (shape, X_WG) in enumerate(make_shapes()):
        if number >= MOVING:
            plant.RegisterVisualGeometry(world, X_WG, shape, str(number), green)
            continue
        frame = scene_graph.RegisterFrame(source, GeometryFrame(str(number)))
        instance = GeometryInstance(X_WG, shape, str(number))
        instance.set_perception_properties(PerceptionProperties())
        scene_graph.RegisterGeometry(source, frame, instance)
        poses.set_value(frame, RigidTransform())
    plant.Finalize()
    held = builder.AddSystem(ConstantValueSource(Value(poses)))
    builder.Connect(held.get_output_port(), scene_graph.get_source_pose_port(source))
    caster = Caster(collect_scene(scene_graph.model_inspector()))
    lidar = builder.AddSystem(LidarSensor(sensor=RECORD, caster=caster, period=STEP))
    builder.Connect(plant.get_state_output_port(), lidar.state_input)
    builder.Connect(scene_graph.get_query_output_port(), lidar.query_input)
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, plant.GetBodyByName("base"), RigidTransform([0.0, 0.0, HEIGHT]))
    return lidar, simulator


def as_meshes(scene: CastScene, meshes: list[trimesh.Trimesh], folder: Path) -> Caster:
    """Return a caster of the scene with meshes for its shapes, and its ground."""
    geometries = []
    for geometry in scene.geometries:
        if isinstance(geometry.shape, HalfSpace):
            geometries.append(geometry)
            continue
        path = folder / f"{geometry.name.split(':')[-1]}.obj"
        meshes[int(path.stem)].export(path)
        geometries.append(replace(geometry, shape=Mesh(str(path))))
    return Caster(CastScene(scene.frames, tuple(geometries)))


def make_mesh(shape: Shape) -> trimesh.Trimesh:
    """Return a shape as triangles, round ones of a thousand or so."""
    match shape:
        case Box():
            return trimesh.creation.box(shape.size())
        case Sphere():
            return trimesh.creation.icosphere(3, shape.radius())
        case Cylinder():
            return trimesh.creation.cylinder(shape.radius(), shape.length())
        case Capsule():
            capsule = trimesh.creation.capsule(shape.length(), shape.radius())
            capsule.apply_translation([0.0, 0.0, -capsule.bounds.mean(axis=0)[2]])
            return capsule
    raise ValueError(shape)


def make_ground() -> trimesh.Trimesh:
    """Return a piece of ground wider than a scan."""
    corners = [[-100.0, -100.0, 0.0], [100.0, -100.0, 0.0], [100.0, 100.0, 0.0], [-100.0, 100.0, 0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]])
