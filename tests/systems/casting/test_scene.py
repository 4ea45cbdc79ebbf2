"""Which geometries can be met, and what they are fixed to."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from workbench.systems.casting.caster import Caster
from workbench.systems.casting.scene import WORLD_FRAME_NUMBER, anchored_frames, collect_scene

SHAPE = "<geometry><sphere><radius>0.5</radius></sphere></geometry>"
WORLD = f"""
<sdf version="1.9"><world name="all">
  <model name="post"><static>true</static><pose>5 0 0 0 0 0</pose><link name="l">
    <visual name="post_seen"><pose>0 0 2 0 0 0</pose>{SHAPE}</visual>
    <collision name="post_touched">{SHAPE}</collision>
  </link></model>
  <model name="cart"><link name="l"><visual name="cart_seen">{SHAPE}</visual></link></model>
  <model name="drone"><link name="l"><visual name="drone_seen">{SHAPE}</visual></link></model>
</world></sdf>
"""


@pytest.fixture
def world():
    """Plant and the scene graph's inspector of three bodies, one of them welded to the world."""
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModelsFromString(WORLD, "sdf")
    plant.Finalize()
    return plant, scene_graph.model_inspector()


def frame_of(plant, model):
    body = plant.GetBodyByName("l", plant.GetModelInstanceByName(model))
    return plant.GetBodyFrameIdOrThrow(body.index())


def test_what_cameras_see_is_met_and_nothing_else(world):
    _, inspector = world
    found = collect_scene(inspector).geometries
    assert {each.id for each in found} == set(inspector.GetAllGeometryIds(Role.kPerception))
    assert {each.name for each in found} == {
        "post::post_seen",
        "cart::cart_seen",
        "drone::drone_seen",
    }


def test_frames_left_out_are_not_met(world):
    plant, inspector = world
    scene = collect_scene(inspector, leave_out={frame_of(plant, "drone")})
    assert "drone::drone_seen" not in {each.name for each in scene.geometries}
    assert frame_of(plant, "drone") not in scene.frames
    assert len(scene.geometries) == 2


def test_what_is_welded_to_the_world_does_not_move(world):
    plant, inspector = world
    scene = collect_scene(inspector, anchored=anchored_frames(plant))
    post = next(each for each in scene.geometries if each.name == "post::post_seen")
    assert post.frame == WORLD_FRAME_NUMBER
    np.testing.assert_allclose(post.X_FG.translation(), [5.0, 0.0, 2.0])
    assert set(scene.frames) == {frame_of(plant, "cart"), frame_of(plant, "drone")}


def test_poses_come_in_the_order_of_the_frames(world):
    plant, inspector = world
    scene = collect_scene(inspector, anchored=anchored_frames(plant))
    poses = [
        RigidTransform([0.0, 7.0 if frame == frame_of(plant, "cart") else -9.0, 0.0])
        for frame in scene.frames
    ]
    rays = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    found = Caster(scene).cast(np.zeros(3), rays, poses, 20.0)
    assert found.tolist() == [6.5, 8.5]
