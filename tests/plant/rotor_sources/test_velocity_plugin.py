"""Oracle: the paper's block as printed there; its airframe turns cw, ccw, cw, ccw by number."""

import dataclasses

import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.plugins import is_velocity_plugin, read_velocity_plugin


def block(numbers=(1, 2, 3, 4), indices=None, extra="") -> str:
    """The paper's block; number n names the quadrotor's joint n-1 unless told otherwise."""
    indices = indices or [number - 1 for number in numbers]
    links = "".join(
        f"<link{n}>rotor_{i}</link{n}>\n" for n, i in zip(numbers, indices, strict=True)
    )
    joints = "".join(
        f"<joint{n}>joint_{i}</joint{n}>\n" for n, i in zip(numbers, indices, strict=True)
    )
    return (
        '<plugin name="libsetvelocity" filename="libSetVelocity.so">\n'
        f"<link>base</link>\n{links}{joints}{extra}</plugin>"
    )


@pytest.fixture
def read(model):
    def read_block(text, remarks=None, **parts):
        quad = model(text, **parts)
        return read_velocity_plugin(quad, quad.plugins[0], "base", remarks or Remarks())

    return read_block


def test_the_block_is_known_by_its_file_and_its_joints(model):
    quad = model(
        block() + '<plugin filename="libSetVelocity.so"/>' + block().replace("SetVel", "Other")
    )
    assert [is_velocity_plugin(plugin) for plugin in quad.plugins] == [True, False, False]


def test_rotors_are_where_the_joints_are_by_number(read):
    rotors = read(block(numbers=(3, 1, 10), indices=(1, 0, 2)))
    assert [rotor.joint for rotor in rotors] == ["joint_0", "joint_1", "joint_2"]
    assert rotors[1].p_BR == pytest.approx((0.0, 0.2, 0.05), abs=1e-12)


def test_what_is_not_said_is_assumed_and_noted(read):
    remarks = Remarks()
    rotors = read(block(), remarks)
    for rotor in rotors:
        assert rotor.moment_constant == 0.016
        assert rotor.time_constant_up == 0.0125
        assert rotor.time_constant_down == 0.025
        assert rotor.max_rot_velocity == 1000.0
    # 1.2 kg x 9.81 m/s^2 x 2 = 23.544 N at 1000 rad/s
    assert sum(rotor.max_thrust for rotor in rotors) == pytest.approx(23.544)
    assert {remark.kind for remark in remarks.found} == {"assumed"}
    said = " ".join(remark.text for remark in remarks.found)
    for word in ("momentConstant 0.016", "motorConstant 5.89e-06", "turningDirection4 ccw"):
        assert word in said


def test_turning_directions_alternate_by_number_on_the_papers_airframe(read):
    assert [rotor.direction for rotor in read(block())] == [-1, 1, -1, 1]


def test_turning_directions_alternate_around_the_drone_where_numbers_do_not(read):
    rotors = read(block(indices=(1, 3, 2, 0)))
    assert {rotor.joint: rotor.direction for rotor in rotors} == {
        "joint_1": -1,
        "joint_2": 1,
        "joint_3": -1,
        "joint_0": 1,
    }


def test_rotors_above_each_other_turn_against_each_other(read, model, link, joint):
    X_MB = model().link("base").X_ML
    places = [
        (x, y, z) for x, y in ((6.0, 5.0), (5.0, 6.0), (4.0, 5.0), (5.0, 4.0)) for z in (0.0, 0.1)
    ]
    links = [
        link(f"rotor_{i}", X_MB @ RigidTransform(list(place))) for i, place in enumerate(places)
    ]
    joints = [joint(f"joint_{i}", rotor) for i, rotor in enumerate(links)]
    rotors = read(block(range(1, 9)), links=links, joints=joints)
    pairs = [(rotors[i].direction, rotors[i + 1].direction) for i in range(0, 8, 2)]
    assert pairs == [(1, -1)] * 4


def test_constants_in_the_block_count(read):
    remarks = Remarks()
    extra = (
        "<motorConstant>2e-5</motorConstant><momentConstant>0.03</momentConstant>"
        "<timeConstantUp>0.1</timeConstantUp><timeConstantDown>0.2</timeConstantDown>"
        "<maxRotVelocity>500</maxRotVelocity><turningDirection1>ccw</turningDirection1>"
        "<turningDirection2>ccw</turningDirection2><turningDirection3>cw</turningDirection3>"
        "<turningDirection4>cw</turningDirection4>"
        "<rotorVelocitySlowdownSim>5</rotorVelocitySlowdownSim>"
        "<rotorDragCoefficient>1e-4</rotorDragCoefficient>"
        "<rollingMomentCoefficient>2e-6</rollingMomentCoefficient>"
    )
    rotors = read(block(extra=extra), remarks)
    assert [rotor.direction for rotor in rotors] == [1, 1, -1, -1]
    assert rotors[3].motor_constant == 2e-5
    assert rotors[3].moment_constant == 0.03
    assert rotors[3].time_constant_up == 0.1
    assert rotors[3].time_constant_down == 0.2
    assert rotors[3].max_rot_velocity == 500.0
    assert rotors[3].velocity_slowdown == 5.0
    assert rotors[3].rotor_drag_coefficient == 1e-4
    assert rotors[3].rolling_moment_coefficient == 2e-6
    assert remarks.found == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<joint2>joint_1</joint2>", "", "<joint2>"),
        ("<link2>rotor_1</link2>", "", "<link2>"),
        ("<joint2>joint_1", "<joint2>joint_9", "'joint_9'"),
        ("<link2>rotor_1", "<link2>rotor_9", "'rotor_9'"),
        ("<link2>rotor_1", "<link2>rotor_2", "'rotor_1'"),
        ("</plugin>", "<motorConstant>-1</motorConstant></plugin>", "<motorConstant>-1"),
        ("</plugin>", "<turningDirection2>up</turningDirection2></plugin>", "up"),
    ],
)
def test_what_cannot_be_is_named_with_its_line(read, old, new, said):
    with pytest.raises(WorkbenchError, match=r"quad\.sdf:\d+: ") as caught:
        read(block().replace(old, new))
    assert said in str(caught.value)


def test_one_joint_under_two_numbers_is_refused(read):
    with pytest.raises(WorkbenchError, match="twice"):
        read(block(indices=(0, 1, 2, 2)))


def test_a_drone_without_mass_has_no_thrust_to_assume(read, model, link):
    quad = model(block())
    light = [link("base"), *quad.links[1:]]
    with pytest.raises(WorkbenchError, match="mass"):
        read_velocity_plugin(
            dataclasses.replace(quad, links=tuple(light)), quad.plugins[0], "base", Remarks()
        )


def test_more_rotors_than_any_drone_has_are_refused(read):
    with pytest.raises(WorkbenchError, match="129 rotors"):
        read(block(range(1, 130), [0] * 129))


def test_a_joint_that_points_down_turns_as_the_block_says_about_it(read, link, joint):
    rotor = link("rotor_0")
    parts = {"links": [rotor], "joints": [joint("joint_0", rotor, axis=(0.0, 0.0, -1.0))]}
    (found,) = read(block([1], extra="<turningDirection1>ccw</turningDirection1>"), **parts)
    assert found.direction == -1
