"""Flags and poses in texts of elements; expected poses are Drake's from their angles."""

import math
from pathlib import Path

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_pose import sdf_flag, sdf_pose
from workbench.plant.formats.xml import Element

FILE = Path("drone.sdf")


def node(tag: str, text: str, **attributes: str) -> Element:
    element = Element(tag, attributes)
    element.file = FILE
    element.text = text
    element.line = 7
    return element


@pytest.mark.parametrize(
    ("text", "attributes", "rpy"),
    [
        ("1 2 3 0.1 0.2 0.3", {}, (0.1, 0.2, 0.3)),
        ("1\n2\t3   0.1 0.2 0.3 ", {"rotation_format": "euler_rpy"}, (0.1, 0.2, 0.3)),
        ("1 2 3 30 45 -60", {"degrees": "true"}, (math.pi / 6, math.pi / 4, -math.pi / 3)),
        ("1 2 3 0.1 0.2 0.3", {"degrees": "False"}, (0.1, 0.2, 0.3)),
        ("1 2 3 0 0 0 1", {"rotation_format": "quat_xyzw"}, (0.0, 0.0, 0.0)),
        ("1 2 3 1 0 0 1", {"rotation_format": "quat_xyzw"}, (math.pi / 2, 0.0, 0.0)),
        ("1 2 3 0 0 -7 7", {"rotation_format": "quat_xyzw"}, (0.0, 0.0, -math.pi / 2)),
    ],
)
def test_a_pose_is_read(text, attributes, rpy):
    expected = RigidTransform(RollPitchYaw(*rpy), [1.0, 2.0, 3.0])
    found = sdf_pose(node("pose", text, **attributes))
    assert found.IsNearlyEqualTo(expected, 1e-12)


def test_no_pose_is_the_identity():
    assert sdf_pose(None).IsExactlyIdentity()
    assert sdf_pose(node("pose", " ")).IsExactlyIdentity()
    assert sdf_pose(node("pose", "", degrees="odd")).IsExactlyIdentity()


@pytest.mark.parametrize(
    ("text", "attributes", "said"),
    [
        ("1 2 3", {}, "<pose>1 2 3</pose>: give it 6 numbers within ±1e+06"),
        ("0 0 0 0 0 0 1", {}, "give it 6 numbers"),
        ("0 0 0 0 0 0", {"rotation_format": "quat_xyzw"}, "give it 7 numbers"),
        ("0 0 0 0 0 nan", {}, "give it 6 numbers"),
        ("0 0 -inf 0 0 0", {}, "give it 6 numbers"),
        ("0 0 1.1e6 0 0 0", {}, "give it 6 numbers"),
        ("0 0 ${z} 0 0 0", {}, "<pose>0 0 ${z} 0 0 0</pose>"),
        ("0,0,1,0,0,0", {}, "give it 6 numbers"),
        ("0 0 0 0 0 0 0", {"rotation_format": "quat_xyzw"}, "its quaternion has no length"),
        ("0 0 0 0 0 1e-9 0", {"rotation_format": "quat_xyzw"}, "its quaternion has no length"),
        ("0 0 0 0 0 0", {"rotation_format": "matrix"}, "write euler_rpy or quat_xyzw"),
        ("0 0 0 0 0 0", {"degrees": "some"}, "'some' of <pose> is neither true nor false"),
    ],
)
def test_a_pose_that_cannot_be_is_refused(text, attributes, said):
    with pytest.raises(WorkbenchError) as caught:
        sdf_pose(node("pose", text, **attributes))
    assert str(caught.value).startswith("drone.sdf:7: ")
    assert said in str(caught.value)


def test_the_largest_pose_is_a_thousand_kilometres():
    pose = sdf_pose(node("pose", "1e6 -1e6 0 0 0 0"))
    assert pose.translation().tolist() == [1e6, -1e6, 0.0]


@pytest.mark.parametrize(
    ("text", "value"), [("true", True), ("1", True), ("True", True), ("0", False), ("", False)]
)
def test_a_flag_is_read(text, value):
    assert sdf_flag(node("static", text), text) is value


def test_a_long_text_is_shortened_in_a_message():
    with pytest.raises(WorkbenchError) as caught:
        sdf_pose(node("pose", "1 " * 100_000))
    assert len(str(caught.value)) < 150
