"""Oracle: the tags as written; their meaning and defaults are those of RotorS and gz-sim."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.plugins import read_motor_plugins
from workbench.plant.rotors import Rotor

TAGS = {
    "jointName": "joint_0",
    "linkName": "rotor_0",
    "turningDirection": "cw",
    "timeConstantUp": "0.0125",
    "timeConstantDown": "0.025",
    "maxRotVelocity": "1000",
    "motorConstant": "1e-05",
    "momentConstant": "0.02",
    "motorNumber": "0",
    "rotorVelocitySlowdownSim": "7",
    "rotorDragCoefficient": "8e-05",
    "rollingMomentCoefficient": "1e-06",
}
NEEDED = ("jointName", "linkName", "turningDirection", "motorConstant")
POSITIVE = (
    "timeConstantUp",
    "timeConstantDown",
    "maxRotVelocity",
    "motorConstant",
    "momentConstant",
    "rotorVelocitySlowdownSim",
)
ROTORS = 'filename="librotors_gazebo_motor_model.so"'


def plugin(i=0, attributes=ROTORS, without=(), **tags) -> str:
    """A plugin of one line a tag; the first tag stands in the line after the plugin's."""
    own = {"jointName": f"joint_{i}", "linkName": f"rotor_{i}", "motorNumber": str(i)}
    texts = {**TAGS, **own, **{key: str(value) for key, value in tags.items()}}
    lines = [f"<{tag}>{text}</{tag}>" for tag, text in texts.items() if tag not in without]
    return "\n".join([f"<plugin {attributes}>", *lines, "</plugin>"])


@pytest.fixture
def read(model):
    """Read the plugins on the quadrotor."""

    def read_plugins(*plugins, remarks=None, **parts):
        quad = model("\n".join(plugins), **parts)
        return read_motor_plugins(quad, "base", remarks or Remarks())

    return read_plugins


def fault(read, *plugins, **parts) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(*plugins, **parts)
    said = str(caught.value)
    assert "\n" not in said
    return said


def test_every_tag_is_read_and_the_place_is_in_the_body_frame(read):
    (rotor,) = read(plugin())
    assert rotor.p_BR == pytest.approx((0.2, 0.0, 0.05), abs=1e-12)
    assert rotor.axis_B == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert rotor == Rotor(
        name="joint_0",
        joint="joint_0",
        link="rotor_0",
        p_BR=rotor.p_BR,
        axis_B=rotor.axis_B,
        direction=-1,
        motor_constant=1e-5,
        moment_constant=0.02,
        time_constant_up=0.0125,
        time_constant_down=0.025,
        max_rot_velocity=1000.0,
        velocity_slowdown=7.0,
        rotor_drag_coefficient=8e-5,
        rolling_moment_coefficient=1e-6,
    )


def test_tags_that_are_not_used_are_said_and_topics_are_not(read):
    remarks = Remarks()
    more = (
        "<commandSubTopic>c</commandSubTopic><robotNamespace/><thrustExponent>1.8</thrustExponent>"
    )
    read(plugin().replace("</plugin>", f"{more}</plugin>"), remarks=remarks)
    (said,) = remarks.found
    assert (said.kind, said.text) == ("ignored", "<thrustExponent>1.8: not known here; not used")


def test_counter_clockwise_is_positive(read):
    assert read(plugin(turningDirection="ccw"))[0].direction == 1


@pytest.mark.parametrize(
    "attributes",
    [
        ROTORS,
        'filename="libgazebo_motor_model.so"',
        'filename="gz-sim-multicopter-motor-model-system" name="x"',
        'filename="libignition-gazebo-multicopter-motor-model-system.so"',
        'filename="f" name="gz::sim::systems::MulticopterMotorModel"',
        'filename="f" name="ignition::gazebo::systems::MulticopterMotorModel"',
    ],
)
def test_plugins_of_all_gazebos_are_read(read, attributes):
    assert len(read(plugin(attributes=attributes))) == 1


@pytest.mark.parametrize(
    "attributes",
    ['filename="libSetVelocity.so"', 'filename="librotors_gazebo_imu_plugin.so" name="motor"', ""],
)
def test_other_plugins_are_left_alone(read, attributes):
    assert read(plugin(attributes=attributes)) == ()


def test_rotors_are_listed_by_motor_number(read):
    rotors = read(plugin(0, motorNumber=9), plugin(3), plugin(1), plugin(2))
    assert [rotor.joint for rotor in rotors] == ["joint_1", "joint_2", "joint_3", "joint_0"]


def test_the_actuator_number_stands_for_the_motor_number(read):
    first = plugin(0, without=["motorNumber"], actuator_number=5)
    second = plugin(1, motorNumber=7, actuator_number=2)
    assert [rotor.joint for rotor in read(first, second)] == ["joint_1", "joint_0"]


def test_without_numbers_the_order_in_the_file_is_assumed(read):
    remarks = Remarks()
    bare = [plugin(i, without=["motorNumber"]) for i in (2, 0)]
    rotors = read(bare[0], plugin(1, motorNumber=0), bare[1], remarks=remarks)
    assert [rotor.joint for rotor in rotors] == ["joint_1", "joint_2", "joint_0"]
    assert [(remark.kind, remark.element) for remark in remarks.found] == [
        ("assumed", "motor model of 'joint_2'"),
        ("assumed", "motor model of 'joint_0'"),
    ]


@pytest.mark.parametrize("tag", NEEDED)
def test_a_missing_tag_is_named_at_its_plugin(read, tag):
    said = fault(read, plugin(1), plugin(without=[tag]))
    assert f"<{tag}>" in said
    assert "quad.sdf:16: " in said


@pytest.mark.parametrize(
    ("tag", "field", "value"),
    [
        ("timeConstantUp", "time_constant_up", 0.0125),
        ("timeConstantDown", "time_constant_down", 0.025),
        ("maxRotVelocity", "max_rot_velocity", 838.0),
        ("momentConstant", "moment_constant", 0.016),
    ],
)
def test_what_gazebo_has_a_default_for_is_assumed(read, tag, field, value):
    remarks = Remarks()
    (rotor,) = read(plugin(without=[tag]), remarks=remarks)
    assert getattr(rotor, field) == pytest.approx(value)
    (remark,) = remarks.found
    assert remark.kind == "assumed"
    assert f"{tag} {value:g}" in remark.text


def test_what_concerns_the_picture_only_is_assumed_without_a_word(read):
    remarks = Remarks()
    (rotor,) = read(plugin(without=["rotorVelocitySlowdownSim"]), remarks=remarks)
    assert rotor.velocity_slowdown == 10.0
    assert not remarks.found


COEFFICIENTS = ("rotorDragCoefficient", "rollingMomentCoefficient")


def test_coefficients_that_are_left_out_are_none_without_a_word(read):
    remarks = Remarks()
    (rotor,) = read(plugin(without=COEFFICIENTS), remarks=remarks)
    assert (rotor.rotor_drag_coefficient, rotor.rolling_moment_coefficient) == (0.0, 0.0)
    assert not remarks.found


@pytest.mark.parametrize("tag", COEFFICIENTS)
@pytest.mark.parametrize("value", ["-1e-5", "inf", "nan", "much", "", "1e308"])
def test_a_coefficient_that_cannot_be_is_quoted_with_its_line(read, tag, value):
    said = fault(read, plugin(**{tag: value}))
    assert f"<{tag}>{value}</{tag}>" in said
    assert f"quad.sdf:{3 + list(TAGS).index(tag)}: " in said
    read(plugin(**{tag: "0"}))


@pytest.mark.parametrize("tag", POSITIVE)
@pytest.mark.parametrize("value", ["0", "-1", "inf", "nan", "fast", "", "1e308", "1e-300"])
def test_a_number_that_cannot_be_is_quoted_with_its_line(read, tag, value):
    said = fault(read, plugin(**{tag: value}))
    assert f"<{tag}>{value}</{tag}>" in said
    assert f"quad.sdf:{3 + list(TAGS).index(tag)}: " in said


@pytest.mark.parametrize(
    ("tag", "value"),
    [
        ("turningDirection", "left"),
        ("linkName", "rotor_x"),
        ("motorNumber", "first"),
        ("motorNumber", "-1"),
        ("motorNumber", "9" * 5000),
    ],
)
def test_a_word_that_cannot_be_is_quoted_with_its_line(read, tag, value):
    said = fault(read, plugin(**{tag: value}))
    assert value[:30] in said
    assert len(said) < 400
    assert f"quad.sdf:{3 + list(TAGS).index(tag)}: " in said


def test_a_joint_that_is_not_there_is_the_one_that_the_link_hangs_on(read):
    remarks = Remarks()
    (rotor,) = read(plugin(jointName="joint_x"), remarks=remarks)
    assert rotor.joint == "joint_0"
    (remark,) = remarks.found
    assert (remark.kind, "'joint_x'" in remark.text) == ("repaired", True)


def test_a_joint_that_is_not_there_and_a_link_that_hangs_on_none_are_refused(read):
    assert "'joint_x'" in fault(read, plugin(jointName="joint_x", linkName="base"))


def test_two_rotors_of_one_number_are_refused(read):
    assert "motorNumber 3" in fault(read, plugin(0, motorNumber=3), plugin(1, motorNumber=3))


def test_two_rotors_of_one_joint_are_refused(read):
    assert "'joint_0'" in fault(read, plugin(), plugin(motorNumber=1))


def test_a_link_that_the_joint_does_not_turn_is_refused(read):
    said = fault(read, plugin(linkName="rotor_2"))
    assert "'rotor_2'" in said
    assert "'rotor_0'" in said


@pytest.mark.parametrize(
    ("kind", "attributes"),
    [("force", ROTORS), ("position", 'filename="gz-sim-multicopter-motor-model-system"')],
)
def test_motors_that_are_no_rotors_are_ignored(read, kind, attributes):
    remarks = Remarks()
    servo = plugin(1, attributes, motorType=kind, without=["motorConstant"])
    assert len(read(plugin(motorType="velocity"), servo, remarks=remarks)) == 1
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("ignored", "motor model of 'joint_1'")
    assert kind in remark.text


def test_a_motor_of_gazebo_classic_that_takes_positions_is_a_servo_and_no_rotor(read):
    remarks = Remarks()
    servo = plugin(1, motorType="position", without=["motorConstant"])
    assert len(read(plugin(), servo, remarks=remarks)) == 1
    assert remarks.found == []


def test_reversible_motors_and_namespaces_change_nothing(read):
    assert read(plugin(reversible="true", robotNamespace="iris")) == read(plugin())


@pytest.mark.parametrize("name", ["x500::rotor", "x500/rotor"])
def test_names_may_lack_the_scope_of_the_model_that_is_nested(read, link, joint, name):
    rotor, other = link(name), link("x500::other_rotor")
    parts = {"links": [rotor, other], "joints": [joint("a::b::spin", rotor)]}
    (found,) = read(plugin(linkName="rotor", jointName="b::spin"), **parts)
    assert (found.link, found.joint) == (name, "a::b::spin")


def test_names_may_have_the_scope_of_the_model_itself(read):
    (rotor,) = read(plugin(linkName="x500::rotor_0", jointName="x500::joint_0"))
    assert rotor.link == "rotor_0"


def test_a_name_that_two_nested_models_have_is_refused(read, link, joint):
    links = [link("a::rotor"), link("b::rotor")]
    joints = [joint("spin", links[0])]
    said = fault(read, plugin(linkName="rotor", jointName="spin"), links=links, joints=joints)
    assert "a::rotor, b::rotor" in said


def test_more_rotors_than_any_drone_has_are_refused(read):
    assert "129" in fault(read, *[plugin(i) for i in range(129)])


def test_a_rotor_may_hang_on_another_ones_link(read, link, joint):
    arm = link("arm")
    rotor = link("rotor_0")
    joints = [joint("tilt", arm, axis=(1.0, 0.0, 0.0)), joint("joint_0", rotor)]
    assert len(read(plugin(), links=[arm, rotor], joints=joints)) == 1


def test_a_few_of_many_names_are_listed(read, link):
    said = fault(read, plugin(jointName="joint_9", linkName="base"))
    assert said.endswith("joints are joint_0, joint_1, joint_2, joint_3")
    said = fault(read, plugin(linkName="x"), links=[link(f"link_{i}") for i in range(20)])
    assert said.endswith("link_10 and 9 more")
    assert fault(read, plugin(), joints=[]).endswith("there are no joints")


def test_a_joint_that_points_down_turns_as_the_plugin_says_about_it(read, link, joint):
    rotor = link("rotor_0")
    parts = {"links": [rotor], "joints": [joint("joint_0", rotor, axis=(0.0, 0.0, -1.0))]}
    assert read(plugin(turningDirection="ccw"), **parts)[0].direction == -1
    assert read(plugin(turningDirection="cw"), **parts)[0].direction == 1
