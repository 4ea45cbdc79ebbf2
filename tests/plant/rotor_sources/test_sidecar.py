"""Oracle: the file's figures, and geometry by hand."""

import math

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.sidecar import find_sidecar, read_sidecar
from workbench.plant.rotors import Rotor

DEFAULTS = """\
defaults:
  motor_constant: 1e-5
  moment_constant: 0.02
  time_constant_up: 0.0125
  time_constant_down: 0.025
  max_rot_velocity: 1000
"""
ROTORS = """\
rotors:
  - {position: [0.1, 0.2, 0.3], direction: ccw}
  - {joint: joint_1, direction: cw, motor_constant: 2.0e-5}
"""


@pytest.fixture
def read(model, tmp_path):
    def read_text(text, remarks=None, **parts):
        path = tmp_path / "quad.rotors.yaml"
        path.write_text(text)
        return read_sidecar(path, model(**parts), "base", remarks or Remarks())

    return read_text


def fault(read, text, **parts) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(text, **parts)
    return str(caught.value)


@pytest.mark.parametrize(
    "description", ["drone.urdf.xacro", "drone.xacro", "drone.urdf", "drone.sdf", "drone"]
)
def test_it_has_the_stem_of_the_description(tmp_path, description):
    assert find_sidecar(tmp_path / description) is None
    (tmp_path / "rotors.yaml").touch()
    assert find_sidecar(tmp_path / description) == tmp_path / "rotors.yaml"
    (tmp_path / "drone.rotors.yaml").touch()
    assert find_sidecar(tmp_path / description) == tmp_path / "drone.rotors.yaml"


def test_a_description_with_the_longest_of_names_has_none(tmp_path):
    assert find_sidecar(tmp_path / ("x" * 250 + ".urdf")) is None


def test_a_rotor_at_a_position_of_the_base_link(read):
    rotor = read(DEFAULTS + ROTORS)[0]
    assert rotor.p_BR == pytest.approx((0.1, 0.2, 0.3))
    assert rotor.axis_B == pytest.approx((0.0, 0.0, 1.0))
    assert rotor == Rotor(
        name="rotor_0",
        joint="",
        link="base",
        p_BR=rotor.p_BR,
        axis_B=rotor.axis_B,
        direction=1,
        motor_constant=1e-5,
        moment_constant=0.02,
        time_constant_up=0.0125,
        time_constant_down=0.025,
        max_rot_velocity=1000.0,
    )


def test_a_rotor_on_a_joint_takes_its_place_and_its_own_figures(read):
    rotor = read(DEFAULTS + ROTORS)[1]
    assert (rotor.name, rotor.joint, rotor.link) == ("joint_1", "joint_1", "rotor_1")
    assert rotor.p_BR == pytest.approx((0.0, 0.2, 0.05), abs=1e-12)
    assert rotor.direction == -1
    assert rotor.motor_constant == 2e-5
    assert rotor.moment_constant == 0.02


def test_drag_is_read_where_it_is_given(read):
    drag = "  rotor_drag_coefficient: 1e-4\n  rolling_moment_coefficient: 0\n"
    own = "- {joint: joint_0, direction: cw, rolling_moment_coefficient: 2e-6}\n"
    first, second = read(DEFAULTS + drag + "rotors:\n- {joint: joint_1, direction: cw}\n" + own)
    assert (first.rotor_drag_coefficient, first.rolling_moment_coefficient) == (1e-4, 0.0)
    assert (second.rotor_drag_coefficient, second.rolling_moment_coefficient) == (1e-4, 2e-6)


def test_position_and_axis_are_in_the_links_frame(read):
    text = "rotors:\n- {link: rotor_0, position: [0, 0, 1e-1], axis: [0, 3, 3], direction: cw}\n"
    (rotor,) = read(DEFAULTS + text)
    assert rotor.p_BR == pytest.approx((0.2, 0.0, 0.15), abs=1e-12)
    assert rotor.axis_B == pytest.approx((0.0, math.sqrt(0.5), math.sqrt(0.5)), abs=1e-12)
    assert rotor.link == "rotor_0"


def test_a_link_that_is_turned_turns_position_and_axis(read, link):
    """About x by 0.3 rad, and the body as it stands in the model."""
    turned = RigidTransform(RollPitchYaw(0.3, 0.0, 0.0), [0.2, 0.0, 0.05])
    X_MB = RigidTransform(RollPitchYaw(0.0, 0.0, 0.5 * math.pi), [0.0, 0.0, 3.0])
    text = "rotors:\n- {link: arm, position: [0, 0.1, 0], direction: cw}\n"
    (rotor,) = read(DEFAULTS + text, links=[link("arm", X_MB @ turned)], joints=[])
    sine, cosine = math.sin(0.3), math.cos(0.3)
    assert rotor.p_BR == pytest.approx((0.2, 0.1 * cosine, 0.05 + 0.1 * sine), abs=1e-12)
    assert rotor.axis_B == pytest.approx((0.0, -sine, cosine), abs=1e-12)


def test_rotors_may_share_direction_axis_and_link(read):
    shared = DEFAULTS + "  direction: cw\n  axis: [0, 0, -1]\n  link: rotor_2\n"
    (rotor,) = read(shared + "rotors:\n  - {position: [0, 0, 0], name: tail}\n")
    assert (rotor.name, rotor.direction, rotor.link) == ("tail", -1, "rotor_2")
    assert rotor.axis_B == pytest.approx((0.0, 0.0, -1.0), abs=1e-12)


def test_a_joint_that_points_down_turns_reversed(read, link, joint):
    remarks = Remarks()
    rotor = link("rotor")
    parts = {"links": [rotor], "joints": [joint("spin", rotor, axis=(0.0, 0.0, -1.0))]}
    (found,) = read(DEFAULTS + "rotors:\n- {joint: spin, direction: ccw}\n", remarks, **parts)
    assert found.direction == -1
    assert [remark.kind for remark in remarks.found] == ["repaired"]


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("{position: [0, 0, 0], direktion: cw}", "did you mean 'direction'"),
        ("{position: [0, 0, 0]}", "rotors.0.direction"),
        ("{position: [0, 0, 0], direction: left}", "rotors.0.direction must be cw or ccw"),
        ("{direction: cw}", "rotors.0.position"),
        ("{position: [0, 0], direction: cw}", "rotors.0.position"),
        ("{position: [0, 0, .nan], direction: cw}", "rotors.0.position"),
        ("{position: [0, 0, 1.0e+300], direction: cw}", "rotors.0.position"),
        ("{position: [0, 0, up], direction: cw}", "rotors.0.position.2"),
        ("{position: 0, direction: cw}", "rotors.0.position"),
        ("{position: [0, 0, 0], axis: [0, 0, 0], direction: cw}", "rotors.0.axis"),
        ("{position: [0, 0, 0], direction: cw, link: wing}", "'wing'"),
        ("{joint: hinge, direction: cw}", "'hinge'"),
        ("{joint: joint_0, position: [0, 0, 0], direction: cw}", "rotors.0.position"),
        ("{joint: joint_0, link: rotor_1, direction: cw}", "should be 'rotor_0'"),
        ("{joint: joint_0, direction: cw, motor_constant: 0}", "rotors.0.motor_constant"),
        ("{joint: joint_0, direction: cw, moment_constant: -1}", "rotors.0.moment_constant"),
        (
            "{joint: joint_0, direction: cw, rotor_drag_coefficient: -1}",
            "rotors.0.rotor_drag_coefficient",
        ),
        (
            "{joint: joint_0, direction: cw, rolling_moment_coefficient: .nan}",
            "rotors.0.rolling_moment_coefficient",
        ),
        ("{joint: joint_0, direction: cw, time_constant_up: .inf}", "rotors.0.time_constant_up"),
        ("{joint: joint_0, direction: cw, time_constant_down: slow}", "time_constant_down"),
        ("{joint: joint_0, direction: cw, max_rot_velocity: true}", "max_rot_velocity"),
        ("{joint: joint_0, direction: cw, max_rot_velocity: 0x" + "f" * 398 + "}", "max_rot"),
        ("{joint: joint_0, direction: 2}", "rotors.0.direction"),
        ("17", "rotors.0"),
        ("", "rotors.0"),
    ],
)
def test_what_cannot_be_is_named_with_its_line(read, entry, said):
    message = fault(read, f"{DEFAULTS}rotors:\n  - {entry}\n")
    assert said in message
    assert "quad.rotors.yaml:8: " in message
    assert len(message) < 500


@pytest.mark.parametrize(
    "key",
    [
        "motor_constant",
        "moment_constant",
        "time_constant_up",
        "time_constant_down",
        "max_rot_velocity",
    ],
)
def test_a_constant_that_is_nowhere_is_named(read, key):
    lines = [line for line in DEFAULTS.splitlines() if key not in line]
    assert f"rotors.0.{key} is missing" in fault(read, "\n".join(lines) + "\n" + ROTORS)


def test_a_constant_that_cannot_be_is_named_in_the_defaults(read):
    message = fault(read, DEFAULTS.replace("1e-5", "-1") + ROTORS)
    assert "quad.rotors.yaml:2: " in message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "key: value"),
        ("rotors:\n", "rotors"),
        ("rotors: []\n", "list the rotors"),
        ("rotor:\n - {}\n", "did you mean 'rotors'"),
        (DEFAULTS, "list the rotors"),
        ("defaults: 3\n" + ROTORS, "defaults"),
        ("defaults: {position: [0, 0, 0]}\n" + ROTORS, "unknown key 'position'"),
        ("rotors: {a: 1}\n", "rotors"),
    ],
)
def test_a_file_of_another_kind_is_refused(read, text, said):
    message = fault(read, text)
    assert said in message
    assert message.partition(": ")[0].rpartition(":")[0].endswith("quad.rotors.yaml")


def test_two_rotors_of_one_name_are_refused(read):
    twice = "rotors:\n- {joint: joint_1, direction: cw}\n- {joint: joint_1, direction: cw}\n"
    assert "quad.rotors.yaml:9: two rotors are 'joint_1'" in fault(read, DEFAULTS + twice)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: &a [1, 1]\nb: *a\n", "quad.rotors.yaml:2: has an alias"),
        ("rotors: " + "[" * 3000 + "]" * 3000, "quad.rotors.yaml:1: is nested more than 20 deep"),
        (f"rotors: [{{motor_constant: {'9' * 5000}}}]", "quad.rotors.yaml:1: a number has more"),
        ("rotors: [{name: 2001-99-99}]", "not YAML"),
        ("rotors: [", "quad.rotors.yaml:1: not YAML"),
        ("rotors: \x00", "not YAML"),
        ("rotors: @", "quad.rotors.yaml:1: not YAML"),
    ],
)
def test_a_strangers_yaml_is_answered(read, text, said):
    assert said in fault(read, text)


def test_bytes_that_are_no_text_are_answered(read, tmp_path, model):
    (tmp_path / "broken.yaml").write_bytes(b"rotors: \xff\xfe")
    with pytest.raises(WorkbenchError, match=r"broken\.yaml"):
        read_sidecar(tmp_path / "broken.yaml", model(), "base", Remarks())
    with pytest.raises(WorkbenchError, match="is a folder"):
        read_sidecar(tmp_path, model(), "base", Remarks())
