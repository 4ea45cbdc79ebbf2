"""Where frames are, and what is said of those that are nowhere; expected values are by hand."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks


def write(folder: Path, content: str, version: str = "1.9") -> Path:
    path = folder / "top.sdf"
    path.write_text(f'<sdf version="{version}"><model name="top">{content}</model></sdf>')
    return path


def read(path: Path) -> Model:
    return read_sdf(path, PackageFinder(path), Remarks())


def fault(path: Path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(path)
    said = str(caught.value)
    assert "\n" not in said
    return said


def agree(X: RigidTransform, other: RigidTransform) -> None:
    assert X.IsNearlyEqualTo(other, 1e-10), f"{X}\nis not\n{other}"


def test_m_is_the_models_own_frame_wherever_it_stands(tmp_path):
    path = write(tmp_path, '<pose>5 5 5 1 1 1</pose><link name="a"><pose>0 0 1 0 0 0</pose></link>')
    agree(read(path).links[0].X_ML, RigidTransform([0.0, 0.0, 1.0]))


def test_a_joint_to_the_world_has_the_world_as_parent_whichever_way_it_is_written(tmp_path):
    ends = {"parent": "<parent>world</parent><child>a</child>"}
    ends["child"] = "<parent>a</parent><child>world</child>"
    for text in ends.values():
        path = write(
            tmp_path,
            '<pose>0 0 1 0 0 0</pose><link name="a"/>'
            f'<joint name="j" type="fixed"><pose relative_to="a">0 0 2 0 0 0</pose>{text}</joint>',
        )
        (joint,) = read(path).joints
        assert (joint.parent, joint.child) == ("world", "a")
        agree(joint.X_MJ, RigidTransform([0.0, 0.0, 2.0]))


def test_a_joint_whose_child_is_the_world_is_placed_in_the_world(tmp_path):
    path = write(
        tmp_path,
        '<pose>0 0 1 0 0 0</pose><link name="a"/><joint name="j" type="fixed">'
        "<pose>0 0 3 0 0 0</pose><parent>a</parent><child>world</child></joint>",
    )
    agree(read(path).joints[0].X_MJ, RigidTransform([0.0, 0.0, 2.0]))


def test_the_frame_of_an_old_pose_is_what_it_is_relative_to(tmp_path):
    content = (
        '<link name="a"><pose>1 0 0 0 0 0</pose></link>'
        '<link name="b"><pose frame="a">1 0 0 0 0 0</pose></link>'
    )
    new = read(write(tmp_path, content, "1.7")).links[1].X_ML
    agree(new, RigidTransform([1.0, 0.0, 0.0]))
    old = read(write(tmp_path, content, "1.6")).links[1].X_ML
    agree(old, RigidTransform([2.0, 0.0, 0.0]))


def test_in_an_old_file_a_joint_may_be_called_as_a_link_is(tmp_path):
    content = """
      <link name="a"/>
      <link name="b"><pose>1 0 0 0 0 0</pose></link>
      <joint name="b" type="fixed"><pose>0 1 0 0 0 0</pose>
        <parent>a</parent><child>b</child></joint>
    """
    model = read(write(tmp_path, content, "1.6"))
    assert model.joints[0].name == "b"
    agree(model.joints[0].X_MJ, RigidTransform([1.0, 1.0, 0.0]))
    said = fault(write(tmp_path, content, "1.7"))
    assert "top.sdf:4: two have the name 'b'" in said


@pytest.mark.parametrize(
    "content",
    [
        '<link name="a"/>\n<link name="a"/>',
        '<link name="a"/>\n<frame name="a"/>',
        '<link name="a"/>\n<model name="a"><link name="b"/></model>',
        '<link name="b"/><model name="a"><link name="b"/></model>\n'
        '<model name="a"><link name="b"/></model>',
        '<link name="b"/><model name="m"><link name="a"/>\n<link name="a"/></model>',
        '<link name="b"/><link name="c"/>'
        '<joint name="a" type="fixed"><parent>b</parent><child>c</child></joint>\n'
        '<joint name="a" type="fixed"><parent>b</parent><child>c</child></joint>',
    ],
)
def test_two_of_one_name_are_refused(tmp_path, content):
    said = fault(write(tmp_path, content))
    assert "two have the name " in said
    assert said.startswith(f"{tmp_path / 'top.sdf'}:")
    assert "rename one" in said


@pytest.mark.parametrize(
    ("content", "names"),
    [
        (
            '<link name="a"><pose relative_to="b"/></link><link name="b"><pose relative_to="a"/>'
            "</link>",
            "'a'",
        ),
        ('<link name="a"><pose relative_to="a"/></link>', "'a'"),
        ('<link name="a"/><frame name="f"><pose relative_to="f"/></frame>', "'f'"),
        ('<link name="a"/><frame name="f" attached_to="f"/>', "'f'"),
        (
            '<link name="a"/><frame name="f" attached_to="g"><pose relative_to="a"/></frame>'
            '<frame name="g" attached_to="f"><pose relative_to="a"/></frame>',
            "'f'",
        ),
        (
            '<link name="a"/><link name="b"/><joint name="j" type="fixed"><parent>a</parent>'
            "<child>j</child></joint>",
            "'j'",
        ),
        (
            '<link name="a"/><model name="m" placement_frame="x"><link name="x">'
            '<pose relative_to="world"/></link><link name="y"/></model>',
            "'m'",
        ),
    ],
)
def test_poses_in_a_circle_end(tmp_path, content, names):
    said = fault(write(tmp_path, content))
    assert said.startswith(f"{tmp_path / 'top.sdf'}:1: ")
    assert names in said


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (
            '<link name="rotor_0"/><link name="b"><pose relative_to="rotor_O"/></link>',
            "<pose> refers to 'rotor_O', which is not a link, joint, frame or model here: "
            "did you mean 'rotor_0'?",
        ),
        (
            '<link name="a"/><frame name="f" attached_to="x"/>',
            "frame 'f' refers to 'x', which is not a link, joint, frame or model here: "
            "known are __model__, a, f",
        ),
        (
            '<link name="b"/><model name="m"><link name="a"/><frame name="f" attached_to="b"/>'
            "</model>",
            "frame 'm::f' refers to 'b'",
        ),
        ('<link name="a"/><frame name="f" attached_to="world"/>', "attached to the world"),
        ('<link name="world"/>', "cannot be called 'world'"),
        (
            '<link name="a"/><model name="m"/><frame name="f" attached_to="m"/>',
            "model 'm' has no link",
        ),
    ],
)
def test_a_frame_that_is_not_there_is_named(tmp_path, content, said):
    assert said in fault(write(tmp_path, content))


def test_names_of_a_thousand_frames_do_not_make_an_endless_message(tmp_path):
    frames = "".join(f'<frame name="frame_{index}"/>' for index in range(1000))
    path = write(tmp_path, f'<link name="a"><pose relative_to="?"/></link>{frames}')
    said = fault(path)
    assert said.endswith("and 990 more")
    assert len(said) < 500


def test_a_chain_of_thousands_of_frames_is_followed(tmp_path):
    frames = "".join(
        f'<frame name="f{index}" attached_to="f{index + 1}"><pose>0 0 0.001 0 0 0</pose></frame>'
        for index in range(4000)
    )
    path = write(tmp_path, f'<link name="a"/>{frames}<frame name="f4000" attached_to="a"/>')
    (first, *_) = read(path).frames
    assert first.link == "a"
    np.testing.assert_allclose(first.X_LF.translation(), [0.0, 0.0, 4.0])
