"""What stands in a plant: roles, contact, and that nothing of it slows or moves the drone."""

import subprocess
import sys

import numpy as np
import pytest
from pydrake.geometry import Box as DrakeBox
from pydrake.geometry import (
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Role,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from workbench.common.resources import find_world, list_worlds, worlds_dir
from workbench.plant.multibody import MAX_WORLD_BODY_SHAPES, add_plant
from workbench.plant.worlds.reading import read_world
from workbench.plant.worlds.world import EMPTY_WORLD, obstacle_of

STEP = 1 / 1024


def shipped(name: str):
    return read_world(find_world(name), {"worlds": str(worlds_dir())})


def flown(description, world, *, p_WB, v_WB=(0.0, 0.0, 0.0), times=(1.0,)):
    """Return the states of a drone that is let go in a world."""
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=STEP, world=world)
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    base = plant.GetBodyByName(description.base_link)
    plant.SetFreeBodyPose(context, base, RigidTransform(np.array(p_WB)))
    plant.SetFreeBodySpatialVelocity(context, base, SpatialVelocity(np.zeros(3), np.array(v_WB)))
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(plant.GetPositionsAndVelocities(context).copy())
    return np.array(states)


def test_every_shipped_world_leaves_the_plant_its_13_states(case, dh_drone):
    for name in list_worlds():
        for time_step in [0.0, STEP]:
            with case(name, time_step):
                world = shipped(name)
                assert world.title
                assert world.remarks == ()
                plant, _ = add_plant(DiagramBuilder(), dh_drone, time_step=time_step, world=world)
                assert (plant.num_positions(), plant.num_velocities()) == (7, 6)
                assert len(plant.GetFloatingBaseBodies()) == 1


def test_the_worlds_that_are_asked_for_are_shipped():
    assert {"empty", "room", "obstacle_field", "moving_obstacle"} <= set(list_worlds())
    kinds = {
        type(g.shape()).__name__ for o in shipped("obstacle_field").obstacles for g in o.visuals
    }
    assert kinds == {"Box", "Cylinder", "Sphere"}
    assert len(shipped("moving_obstacle").moving) == 2
    for name in ("obstacle_field", "moving_obstacle"):
        world = shipped(name)
        far = [np.linalg.norm(world.pose(each, 0.0).translation()[:2]) for each in world.names]
        assert min(far) > 3.0
        assert max(far) < 30.0


def test_where_nothing_is_in_the_way_every_world_flies_alike_to_the_bit(dh_drone):
    times = np.linspace(0.1, 1.0, 10)
    there = [flown(dh_drone, world, p_WB=(0, 0, 0.6), times=times) for world in (
        EMPTY_WORLD, shipped("empty"), shipped("room"), shipped("obstacle_field")
    )]  # fmt: skip
    for states in there[1:]:
        assert states.tobytes() == there[0].tobytes()


CRATE = "obstacles: [{name: crate, shape: {box: [2, 2, 1]}, position: [0, 0, 0.5]}]"


def test_a_drone_rests_on_an_obstacle(dh_drone, dh_vehicle, read):
    clearance = dh_vehicle.ground_clearance
    (state,) = flown(dh_drone, read(CRATE), p_WB=(0, 0, 1.05 + clearance), times=(2.0,))
    assert state[6] == pytest.approx(1.0 + clearance, abs=1e-3)
    assert np.abs(state[7:]).max() < 1e-3


def test_a_drone_bumps_into_a_wall_and_not_through_it(dh_drone):
    """It falls a metre within half a second, in which 5 m/s would take it to x = 2.5 m, or 6.5."""
    states = flown(
        dh_drone, shipped("room"), p_WB=(4.0, 0, 2), v_WB=(5, 0, 0), times=np.linspace(0.1, 0.5, 9)
    )
    assert states[:, 4].max() < 5.0
    free = flown(dh_drone, EMPTY_WORLD, p_WB=(4.0, 0, 2), v_WB=(5, 0, 0), times=(0.5,))
    assert free[0, 4] == pytest.approx(6.5)


def test_without_ground_it_falls_on(dh_drone, read):
    (state,) = flown(dh_drone, read("ground: false"), p_WB=(0, 0, 0.5), times=(1.0,))
    assert state[6] == pytest.approx(0.5 - 9.81 / 2, abs=0.01)


MANY = """
import sys
sys.path[:0] = {path!r}
import numpy as np
from pathlib import Path
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo
from pydrake.systems.analysis import Simulator
from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant
from workbench.plant.worlds.reading import read_world
from workbench.common.resources import find_model
world = read_world({world!r})
builder = DiagramBuilder()
plant, _ = add_plant(builder, read_description(find_model("dh_drone")), time_step=1/1024,
                     world=world)
diagram = builder.Build()
context = diagram.CreateDefaultContext()
simulator = Simulator(diagram, context.Clone())
plant.SetPositions(plant.GetMyContextFromRoot(simulator.get_mutable_context()),
                   [1, 0, 0, 0, 0, 0, 1.5])
simulator.AdvanceTo(1.0)
p_WB = plant.GetPositions(plant.GetMyContextFromRoot(simulator.get_context()))[4:]
print(plant.num_bodies(), *p_WB)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("count", "more"), [(MAX_WORLD_BODY_SHAPES, 0), (150, 1)])
def test_drake_survives_many_obstacles_beside_the_ground(dh_drone, write, count, more):
    """In a process of its own: what it guards against is a segmentation fault.

    All stand in one place, the worst case for Drake's tree of boxes, and the drone falls on them.
    """
    row = "- {{name: slab_{}, shape: {{box: [2, 2, 1]}}, position: [0, 0, 0.5]}}\n"
    world = write("obstacles:\n" + "".join(map(row.format, range(count))))
    code = MANY.format(path=sys.path, world=str(world))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    bodies, *p_WB = map(float, done.stdout.split())
    plant, _ = add_plant(DiagramBuilder(), dh_drone, time_step=STEP)
    assert bodies == plant.num_bodies() + more
    assert p_WB[2] > 1.0


def test_geometries_are_named_after_their_obstacles_and_have_their_roles(dh_drone):
    world = shipped("obstacle_field")
    _, scene_graph = add_plant(DiagramBuilder(), dh_drone, time_step=STEP, world=world)
    inspector = scene_graph.model_inspector()
    for role in (Role.kProximity, Role.kPerception, Role.kIllustration):
        fixed = [
            obstacle_of(inspector.GetName(id))
            for id in inspector.GetAllGeometryIds(role)
            if inspector.GetFrameId(id) == scene_graph.world_frame_id()
        ]
        ground = () if role == Role.kIllustration else ("ground",)
        assert sorted(fixed) == sorted((*world.names, *ground))


def test_an_obstacle_is_where_the_world_says(dh_drone, read):
    world = read("obstacles: [{name: a, shape: {box: [1, 2, 3]}, position: [4, 5, 6]}]")
    _, scene_graph = add_plant(DiagramBuilder(), dh_drone, time_step=STEP, world=world)
    inspector = scene_graph.model_inspector()
    found = [id for id in inspector.GetAllGeometryIds() if inspector.GetName(id) == "a::shape"]
    assert len(found) == 2
    for id in found:
        assert inspector.GetPoseInFrame(id).translation().tolist() == [4.0, 5.0, 6.0]
        assert isinstance(inspector.GetShape(id), DrakeBox)


def test_one_world_can_be_flown_in_twice(dh_drone):
    world = shipped("room")
    names = []
    for _ in range(2):
        _, scene_graph = add_plant(DiagramBuilder(), dh_drone, time_step=STEP, world=world)
        inspector = scene_graph.model_inspector()
        names.append([inspector.GetName(id) for id in inspector.GetAllGeometryIds()])
    assert names[0] == names[1]
    assert {f"{name}::shape" for name in world.names} <= {*names[0]}


def test_the_camera_sees_ground_and_obstacles_without_a_word(dh_drone, caplog):
    """From 2 m over the room's middle it looks east: a wall 5 m ahead, and further down ground.

    The renderer looks through the middles of pixels: with f of 50 pixels, row 100 looks down by
    50.5/50.
    """
    builder = DiagramBuilder()
    _, scene_graph = add_plant(builder, dh_drone, time_step=STEP, world=shipped("room"))
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(RenderEngineVtkParams()))
    diagram = builder.Build()
    context = scene_graph.GetMyContextFromRoot(diagram.CreateDefaultContext())
    core = RenderCameraCore(
        "vtk",
        CameraInfo(101, 101, 50.0, 50.0, 50.0, 50.0),
        ClippingRange(0.05, 50),
        RigidTransform(),
    )
    camera = DepthRenderCamera(core, DepthRange(0.1, 40))
    X_WC = RigidTransform(RotationMatrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]]), [0, 0, 2])
    query = scene_graph.get_query_output_port().Eval(context)
    image = query.RenderDepthImage(camera, scene_graph.world_frame_id(), X_WC).data
    assert image[50, 50, 0] == pytest.approx(5.0, abs=1e-3)
    assert image[100, 50, 0] == pytest.approx(2.0 / 1.01, abs=1e-3)
    assert caplog.messages == []
