"""A session's frames: against the tree of frames at its end, and against Drake's own body poses."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.frame_tree import frame_tree
from workbench.plant.multibody import add_plant
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session


@pytest.fixture
def framed() -> Session:
    """A flight in a world where something moves."""
    session = Session(Scenario(world="moving_obstacle"))
    session.command([1.0, -0.5, 0.5], 0.3)
    session.tick(1.5)
    return session


def chained(session: Session, name: str) -> RigidTransform:
    """Return the pose of a frame in the world, from the session's transforms alone."""
    parts = {each.child: each for each in session.frames().transforms}
    X = RigidTransform()
    while name in parts:
        part = parts[name]
        X = RigidTransform(Quaternion(part.q), part.p) @ X
        name = part.parent
    assert name == "world"
    return X


def test_frames_chain_to_those_of_the_flight(framed):
    description = read_description(find_model("dh_drone"))
    world = framed.world
    tree = frame_tree(
        framed.vehicle,
        description.model,
        moving=[(moving.name, moving.pose) for moving in world.moving],
    )
    flown = framed.recording()
    X_WB = RigidTransform(Quaternion(flown.q_WB[-1]), flown.p_WB[-1])
    assert framed.frames().time == 1.5
    assert {each.child for each in framed.frames().transforms} == set(tree.names) - {"world"}
    assert {"lidar_link", "camera", "ball", "cart"} <= set(tree.names)
    for name in tree.names:
        wanted = tree.X("world", name, X_WB, 1.5)
        assert chained(framed, name).IsNearlyEqualTo(wanted, 1e-12), name


def test_frames_are_where_drake_has_the_bodies(framed):
    """The plant's body is the drone's whole; its links hang on it as the description says."""
    description = read_description(find_model("dh_drone"))
    plant, _ = add_plant(DiagramBuilder(), description, time_step=0.0)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, framed.state())
    X_WB = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("base_link"))
    assert chained(framed, "base_link").IsNearlyEqualTo(X_WB, 1e-12)
    assert np.linalg.norm(X_WB.translation() - [0.0, 0.0, 1.5]) > 0.5
    for link in ("lidar_link", "camera_link", "IMU_link", "propeller1_link"):
        X_WL = plant.GetFrameByName(link).CalcPoseInWorld(context)
        assert chained(framed, link).IsNearlyEqualTo(X_WL, 1e-12), link


def test_frames_follow_the_flight(framed):
    before = framed.frames()
    framed.tick(0.25)
    after = framed.frames()
    moved = {
        old.child
        for old, new in zip(before.transforms, after.transforms, strict=True)
        if old != new
    }
    assert moved == {"base_link", "ball", "cart"}


def test_any_frame_in_any_other_is_that_of_the_chain(framed):
    X = framed.pose("lidar_link", "camera_optical")
    wanted = chained(framed, "lidar_link").InvertAndCompose(chained(framed, "camera_optical"))
    assert X.IsNearlyEqualTo(wanted, 1e-12)


def test_a_frame_that_is_not_there_is_a_sentence(framed):
    with pytest.raises(WorkbenchError, match="unknown frame 'camera_optcal': did you mean"):
        framed.pose("world", "camera_optcal")
