"""Oracle: the tree itself, and what Drake says of the port."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.frame_tree import FrameTree, TreeFrame
from workbench.systems.frame_poses import FramePoses, FrameTransforms

X_BF = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.1, 0.0, 0.0])
TREE = FrameTree(
    (
        TreeFrame("base", "world", None),
        TreeFrame("arm", "base", X_BF),
        TreeFrame("cart", "world", lambda time: RigidTransform([time, 0.0, 0.0])),
    )
)
Q_WB = RollPitchYaw(0.4, -0.2, 2.0).ToQuaternion()
P_WB = [1.0, 2.0, 3.0]


@pytest.fixture
def system():
    return FramePoses(TREE)


def message(system, time: float = 0.0, length: float = 1.0) -> FrameTransforms:
    context = system.CreateDefaultContext()
    context.SetTime(time)
    state = np.concatenate([length * Q_WB.wxyz(), P_WB, np.zeros(6)])
    system.GetInputPort("state").FixValue(context, state)
    return system.GetOutputPort("frames").Eval(context)


def test_its_message_has_every_frame_in_its_parents(system):
    found = message(system, 1.5)
    assert found.time == 1.5
    assert found.transforms == TREE.transforms(RigidTransform(Q_WB, P_WB), 1.5)
    assert [each.child for each in found.transforms] == ["base", "arm", "cart"]
    assert found.transforms[2].p == (1.5, 0.0, 0.0)


def test_a_quaternion_of_any_length_will_do(system):
    for one, other in zip(
        message(system).transforms, message(system, length=1.01).transforms, strict=True
    ):
        assert (one.parent, one.child) == (other.parent, other.child)
        assert one.p == pytest.approx(other.p)
        assert one.q == pytest.approx(other.q)


def test_it_follows_state_and_time_and_nothing_runs_in_between(system):
    context = system.CreateDefaultContext()
    port = system.GetOutputPort("frames")
    state = np.concatenate([Q_WB.wxyz(), P_WB, np.zeros(6)])
    system.GetInputPort("state").FixValue(context, state)
    before = port.Eval(context)
    assert port.Eval(context) is before
    state[4] = 7.0
    system.GetInputPort("state").FixValue(context, state)
    assert port.Eval(context).transforms[0].p == (7.0, 2.0, 3.0)
    context.SetTime(2.0)
    assert port.Eval(context).transforms[2].p == (2.0, 0.0, 0.0)
    assert system.num_discrete_state_groups() == 0
