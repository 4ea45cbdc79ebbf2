"""Oracle: the tags as written; their meaning is that of RotorS and gz-sim."""

import pytest

from workbench.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.motor_model import MotorModel

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
}
POSITIVE = (
    "timeConstantUp",
    "timeConstantDown",
    "maxRotVelocity",
    "motorConstant",
    "momentConstant",
)


def tag(name: str, value: str) -> str:
    return f"<{name}>{value}</{name}>"


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read_description(path)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said


def test_every_tag_is_read(broken_quad):
    path = broken_quad("<motorNumber>0", tag("rotorVelocitySlowdownSim", "7") + "<motorNumber>0")
    assert read_description(path).motors[0] == MotorModel(
        number=0,
        joint="joint_0",
        link="rotor_0",
        direction=-1,
        motor_constant=1e-5,
        moment_constant=0.02,
        time_constant_up=0.0125,
        time_constant_down=0.025,
        max_rot_velocity=1000.0,
        velocity_slowdown=7.0,
    )


def test_counter_clockwise_is_positive_and_the_picture_turns_ten_times_slower(write, quad):
    motor = read_description(write(quad)).motors[1]
    assert motor.direction == 1
    assert motor.velocity_slowdown == 10.0


def test_rotors_are_listed_by_motor_number(write, quad):
    swapped = quad.replace(tag("motorNumber", "0"), tag("motorNumber", "9"))
    motors = read_description(write(swapped)).motors
    assert [motor.joint for motor in motors] == ["joint_1", "joint_2", "joint_3", "joint_0"]


def test_the_plugin_of_gz_sim_is_read_as_that_of_rotors(write, quad):
    renamed = quad.replace(
        "librotors_gazebo_motor_model.so", "gz-sim-multicopter-motor-model-system"
    )
    motors = read_description(write(renamed)).motors
    assert motors == read_description(write(quad)).motors
    assert len(motors) == 4


def test_other_plugins_are_left_alone(broken_quad):
    path = broken_quad(
        "<gazebo>", '<gazebo><plugin filename="libSetVelocity.so"/></gazebo><gazebo>'
    )
    assert len(read_description(path).motors) == 4


@pytest.mark.parametrize("name", TAGS)
def test_a_missing_tag_is_named(broken_quad, name):
    assert f"<{name}>" in fault(broken_quad(tag(name, TAGS[name]), ""))


@pytest.mark.parametrize("name", POSITIVE)
@pytest.mark.parametrize("value", ["0", "-1", "inf", "nan", "fast", ""])
def test_a_number_that_cannot_be_is_quoted(broken_quad, name, value):
    said = fault(broken_quad(tag(name, TAGS[name]), tag(name, value)))
    assert f"<{name}>{value}</{name}>" in said


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("turningDirection", "left"),
        ("jointName", "joint_x"),
        ("linkName", "rotor_x"),
        ("motorNumber", "first"),
    ],
)
def test_a_word_that_cannot_be_is_quoted(broken_quad, name, value):
    assert f"'{value}'" in fault(broken_quad(tag(name, TAGS[name]), tag(name, value)))


@pytest.mark.parametrize("value", ["slow", "0", "nan"])
def test_a_slowdown_that_cannot_be_is_quoted(broken_quad, value):
    slowdown = tag("rotorVelocitySlowdownSim", value)
    said = fault(broken_quad("<motorNumber>0", f"{slowdown}<motorNumber>0"))
    assert "rotorVelocitySlowdownSim" in said
    assert value in said


def test_two_rotors_of_one_number_are_refused(broken_quad):
    said = fault(broken_quad(tag("motorNumber", "0"), tag("motorNumber", "1")))
    assert "motorNumber" in said
