"""Oracle: 4 x 4 matrices of numpy, and Drake's own frames in test_vehicle_frames."""

import math

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.frame_tree import (
    FrameTree,
    Transform,
    TreeFrame,
    roll_pitch_yaw,
)

RNG = np.random.default_rng(41)


def drawn() -> RigidTransform:
    return RigidTransform(RollPitchYaw(RNG.uniform(-1.5, 1.5, 3)), RNG.uniform(-5, 5, 3))


ARM, TIP, EYE, POST = (drawn() for _ in range(4))
X_WB = drawn()


def drifting(time: float) -> RigidTransform:
    return RigidTransform(RollPitchYaw(0.0, 0.0, 0.3 * time), [time, 2.0, 1.0])


TREE = FrameTree(
    (
        TreeFrame("base", "world", None),
        TreeFrame("arm", "base", ARM),
        TreeFrame("tip", "arm", TIP),
        TreeFrame("eye", "base", EYE),
        TreeFrame("post", "world", POST),
        TreeFrame("cart", "world", drifting),
    )
)
TIME = 2.5
IN_WORLD = {
    "world": np.eye(4),
    "base": X_WB.GetAsMatrix4(),
    "arm": X_WB.GetAsMatrix4() @ ARM.GetAsMatrix4(),
    "tip": X_WB.GetAsMatrix4() @ ARM.GetAsMatrix4() @ TIP.GetAsMatrix4(),
    "eye": X_WB.GetAsMatrix4() @ EYE.GetAsMatrix4(),
    "post": POST.GetAsMatrix4(),
    "cart": drifting(TIME).GetAsMatrix4(),
}


def test_every_frame_is_known_the_world_first():
    assert TREE.names == tuple(IN_WORLD)


@pytest.mark.parametrize("a", IN_WORLD)
@pytest.mark.parametrize("b", IN_WORLD)
def test_any_frame_in_any_other(a, b):
    found = TREE.X(a, b, X_WB, TIME).GetAsMatrix4()
    assert found == pytest.approx(np.linalg.inv(IN_WORLD[a]) @ IN_WORLD[b], abs=1e-12)


def test_on_the_drone_frames_keep_their_poses_to_the_bit_wherever_it_is():
    far = RigidTransform(RollPitchYaw(1.0, 0.3, 2.0), [1e7, -1e7, 1e3])
    for a, b in (("tip", "eye"), ("base", "tip"), ("eye", "eye")):
        here, there = (TREE.X(a, b, X, 0.0).GetAsMatrix34() for X in (X_WB, far))
        assert here.tolist() == there.tolist()
    assert TREE.X("tip", "tip", far).IsExactlyIdentity()


def test_transforms_are_poses_in_parents_and_lead_back_to_the_world():
    transforms = TREE.transforms(X_WB, TIME)
    assert [each.child for each in transforms] == list(IN_WORLD)[1:]
    found = {"world": np.eye(4)}
    for each in transforms:
        w, x, y, z = each.q
        matrix = np.eye(4)
        v = np.array([x, y, z])
        cross = np.cross(v, np.eye(3)).T
        matrix[:3, :3] = (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * cross
        matrix[:3, 3] = each.p
        found[each.child] = found[each.parent] @ matrix
        assert math.hypot(*each.q) == pytest.approx(1.0)
    for name, matrix in found.items():
        assert matrix == pytest.approx(IN_WORLD[name], abs=1e-12), name


def test_a_transform_is_plain_numbers():
    (first, *_) = TREE.transforms(RigidTransform([1.0, 2.0, 3.0]))
    assert first == Transform("world", "base", (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0))
    assert all(type(number) is float for number in (*first.p, *first.q))


@pytest.mark.parametrize(("a", "b"), [("arn", "tip"), ("tip", "arn")])
def test_an_unknown_frame_is_answered_with_the_nearest(a, b):
    with pytest.raises(WorkbenchError, match="unknown frame 'arn': did you mean 'arm'.*known are"):
        TREE.X(a, b, X_WB)


def test_a_tree_has_every_name_once_and_parents_first():
    with pytest.raises(WorkbenchError, match="two frames are named 'arm'"):
        FrameTree((TreeFrame("arm", "world", ARM), TreeFrame("arm", "world", ARM)))
    with pytest.raises(WorkbenchError, match="unknown parent of frame 'tip', 'arn'"):
        FrameTree((TreeFrame("arm", "world", ARM), TreeFrame("tip", "arn", TIP)))


def test_lines_show_what_hangs_where():
    eighth = RotationMatrix.MakeZRotation(math.pi / 4)
    tree = FrameTree(
        (
            TreeFrame("base", "world", None),
            TreeFrame("arm", "base", RigidTransform(eighth, [0.1, 0.0, -0.25])),
            TreeFrame("tip", "arm", RigidTransform([1.0, 0.0, 0.0])),
            TreeFrame("eye", "base", RigidTransform()),
            TreeFrame("cart", "world", drifting),
        )
    )
    assert list(tree.lines(RigidTransform([0.0, 0.0, 1.5]))) == [
        "world",
        "├─ base (0 0 1.5, flies)",
        "│  ├─ arm (0.1 0 -0.25; rpy 0 0 45)",
        "│  │  └─ tip (1 0 0)",
        "│  └─ eye (0 0 0)",
        "└─ cart (0 2 1, moves)",
    ]


def test_angles_too_small_to_be_more_than_rounding_are_none():
    assert roll_pitch_yaw(RigidTransform(RollPitchYaw(1e-14, 0.2, 0.0), [0, 0, 0])) == [
        0.0,
        pytest.approx(0.2),
        0.0,
    ]
