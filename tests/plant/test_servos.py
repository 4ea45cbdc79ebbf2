"""Servos of joints, as published files state them."""

import cmath
import math

import pytest

from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.parameters.servo_parameters import servo_parameters
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.servo import Servo

LIMIT = '<limit lower="-0.5" upper="1.5" effort="{}" velocity="{}"/>'


def arm(more: str = "", name: str = "hinge") -> str:
    """Return a link on a joint across the drone."""
    return link(f"{name}_arm", 0.1, (0.1, 0.0, 0.0)) + joint(
        name, "revolute", "base", f"{name}_arm", (0, 0, -0.1), (0, 1, 0), more
    )


def gazebo(kind: str, file: str, inner: str) -> str:
    """Return a plugin of gz-sim."""
    return (
        f'<gazebo><plugin name="gz::sim::systems::{kind}" filename="gz-sim-{file}-system">'
        f"{inner}</plugin></gazebo>"
    )


def servos(folder, parts: str, sidecar: str = ""):
    """Return the servos of a drone with parts, by joint, and its remarks."""
    path = drone(folder, parts)
    if sidecar:
        beside = folder / "jointed.rotors.yaml"
        beside.write_text(beside.read_text() + sidecar)
    description = read_description(path)
    vehicle = make_vehicle(description)
    remarks = [f"{each.element}: {each.text}" for each in description.remarks]
    return {each.joint: each.servo for each in vehicle.servos}, remarks


def test_gazebos_controllers_of_joints(tmp_path):
    limit = LIMIT.format(-1, 2)
    parts = "".join(arm(limit, name) for name in ("hinge", "held", "spun", "pushed", "quick"))
    parts += gazebo(
        "JointPositionController",
        "joint-position-controller",
        "<joint_name>hinge</joint_name><p_gain>3</p_gain><d_gain>0.2</d_gain>"
        "<cmd_max>0.4</cmd_max><cmd_min>-0.4</cmd_min><initial_position>9</initial_position>",
    )
    parts += gazebo("JointPositionController", "joint-position-controller", "")
    parts += gazebo(
        "JointTrajectoryController",
        "joint-trajectory-controller",
        "<joint_name>held</joint_name><joint_name>quick</joint_name>"
        "<position_p_gain>7</position_p_gain><position_p_gain>8</position_p_gain>"
        "<position_d_gain>0.1</position_d_gain>",
    )
    parts += gazebo("JointController", "joint-controller", "<joint_name>spun</joint_name>")
    parts += gazebo("ApplyJointForce", "apply-joint-force", "<joint_name>pushed</joint_name>")
    parts += gazebo("JointController", "joint-controller", "<joint_name>absent</joint_name>")
    found, remarks = servos(tmp_path, parts)
    hinge, held, spun, pushed, quick = (
        found[name] for name in ("hinge", "held", "spun", "pushed", "quick")
    )
    assert (hinge.kind, hinge.stiffness, hinge.damping) == ("position", 3.0, 0.2)
    assert (hinge.lower, hinge.upper, hinge.start) == (-0.5, 1.5, 1.5)
    assert (hinge.max_effort, hinge.max_rate) == (0.4, 2.0)
    assert (held.stiffness, held.damping, quick.stiffness, quick.damping) == (7.0, 0.1, 8.0, 0.0)
    assert (spun.kind, spun.lower, spun.upper) == ("velocity", -2.0, 2.0)
    assert (pushed.kind, pushed.max_effort) == ("effort", math.inf)
    assert "servo of 'hinge': its integral gain of 0.1 is not used" in remarks
    assert any("joint 'spun': no gains are stated; 30 rad/s" in each for each in remarks)
    assert any("the joint 'absent' does not exist" in each for each in remarks)
    assert not any("runs in Gazebo only" in each for each in remarks)


def test_terms_of_gazebos_controllers_that_do_not_act_are_said(tmp_path):
    """Offsets, and gains of integrals and accelerations; zeros and topics mean nothing."""
    rows = (
        ("JointPositionController", "<cmd_offset>0.5</cmd_offset><topic>t</topic>", "hinge"),
        ("JointController", "<d_gain>2</d_gain><p_gain>1</p_gain>", "spun"),
        (
            "JointTrajectoryController",
            "<position_p_gain>5</position_p_gain><position_i_gain>1e-2</position_i_gain>"
            "<velocity_i_gain>0.0</velocity_i_gain><position_cmd_offset>-0.0E+1</position_cmd_offset>",
            "held",
        ),
    )
    parts = "".join(arm(name=name) for _, _, name in rows)
    for kind, inner, name in rows:
        file = {"JointController": "joint-controller"}.get(kind, "joint-position-controller")
        file = "joint-trajectory-controller" if "Trajectory" in kind else file
        parts += gazebo(kind, file, f"<joint_name>{name}</joint_name>{inner}")
    _, remarks = servos(tmp_path, parts)
    assert [each for each in remarks if " plugin of " in each] == [
        "JointPositionController plugin of 'hinge': <cmd_offset>0.5: not used",
        "JointController plugin of 'spun': <d_gain>2: not used",
        "JointTrajectoryController plugin of 'held': <position_i_gain>1e-2: not used",
    ]


PID = """<joint_control_pid><p>3.5</p><i>{i}</i><d>0.2</d><cmdMax>6</cmdMax><cmdMin>-6</cmdMin>
  </joint_control_pid>"""


def test_plugins_of_gazebo_classic_drive_joints(tmp_path):
    """Legs, tilts and gimbals of PX4's models, and what RotorS moves by motor models."""

    def channel(name: str, kind: str, more: str = "") -> str:
        return (
            f"<channel name='{name}'><joint_control_type>{kind}</joint_control_type>{more}"
            f"<joint_name>jointed::{name}</joint_name></channel>"
        )

    leg = PID.format(i=0.5) + "<zero_position_disarmed>0.3</zero_position_disarmed>"
    mavlink = "<plugin name='mavlink' filename='libgazebo_mavlink_interface.so'>{}</plugin>"
    channels = (
        channel("leg", "position", leg)
        + channel("flap", "position_kinematic")
        + channel("roll", "position_gztopic", leg)
        + channel("wheel", "velocity", leg)
        + "<channel name='none'><joint_control_type>position</joint_control_type></channel>"
    )
    gimbal = (
        "<plugin name='gimbal' filename='libgazebo_gimbal_controller_plugin.so'>"
        "<joint_yaw>yaw</joint_yaw><joint_roll>roll</joint_roll><joint_pitch>pitch</joint_pitch>"
        "<control_gimbal_channels><channel><joint_axis>joint_yaw</joint_axis>"
        f"{PID.format(i=0)}</channel></control_gimbal_channels></plugin>"
    )
    motor = (
        "<plugin name='motor' filename='librotors_gazebo_motor_model.so'><jointName>tilt"
        f"</jointName><motorType>position</motorType>{PID.format(i=0)}</plugin>"
    )
    names = ("leg", "flap", "wheel", "yaw", "roll", "pitch", "tilt")
    parts = "".join(arm(name=name) for name in names)
    plugins = mavlink.format(f"<control_channels>{channels}</control_channels>") + gimbal + motor
    found, remarks = servos(tmp_path, f"{parts}<gazebo>{plugins}</gazebo>")
    assert sorted(found) == ["flap", "leg", "pitch", "roll", "tilt", "yaw"]
    assert {each.kind for each in found.values()} == {"position"}
    for name, start in (("leg", 0.3), ("yaw", 0.0), ("tilt", 0.0)):
        each = found[name]
        assert (each.stiffness, each.damping, each.max_effort) == (3.5, 0.2, 6.0)
        assert each.start == start
    for name in ("roll", "pitch"):  # the plugin's own numbers
        each = found[name]
        assert (each.stiffness, each.damping, each.max_effort) == (5.0, 0.0, 0.3)
    assert found["flap"].damping == pytest.approx(2.0 * found["flap"].stiffness / 30.0)
    assert "servo of 'jointed::leg': its integral gain of 0.5 is not used" in remarks
    assert not any("runs in Gazebo only" in each for each in remarks)
    note = "gimbal controller: Gazebo holds the camera level by its IMU; here its joints are held"
    assert remarks.count(note) == 1
    idle = mavlink.format(channel("wheel", "velocity"))
    _, remarks = servos(tmp_path, f"{parts}<gazebo>{idle}</gazebo>")
    assert any("'mavlink': its code" in each for each in remarks)


def test_a_gimbal_controller_without_names_has_those_of_px4(tmp_path):
    names = ("cgo3_vertical_arm_joint", "cgo3_horizontal_arm_joint", "cgo3_camera_joint")
    plugin = "<plugin name='gimbal' filename='libgazebo_gimbal_controller_plugin.so'/>"
    parts = "".join(arm(name=name) for name in names) + f"<gazebo>{plugin}</gazebo>"
    found, _ = servos(tmp_path, parts)
    assert [found[name].stiffness for name in names] == [1.0, 5.0, 5.0]


def test_a_channel_that_cannot_be_a_servo_is_noted_and_not_refused(tmp_path, case):
    """Its numbers act in Gazebo only; a remark on its gains would be one on no servo."""
    cases = (
        ("hinge", "-10", "servo of 'hinge': <p>-10</p>: give it a number that is not negative"),
        ("hinge", "x", "servo of 'hinge': <p>x</p>: give it a number; not used"),
        ("absent", "x", "servo of 'absent': <p>x</p>: give it a number; not used"),
        ("absent", "3", "MAVLink interface: the joint 'absent' does not exist"),
    )
    for name, gain, text in cases:
        with case(f"{name} {gain}"):
            plugin = (
                "<gazebo><plugin name='m' filename='libgazebo_mavlink_interface.so'>"
                "<control_channels><channel><joint_control_type>position</joint_control_type>"
                f"<joint_name>{name}</joint_name>{PID.format(i=1).replace('3.5', gain)}"
                "</channel></control_channels></plugin></gazebo>"
            )
            found, remarks = servos(tmp_path, arm() + plugin)
            assert not found
            assert [each for each in remarks if each.startswith(text)]
            assert not [each for each in remarks if "integral" in each or "Gazebo only" in each]


def test_ros_control_and_transmissions(tmp_path):
    """Without gains, 30 rad/s critically damped: k = I w², d = 2 I w, for what each moves."""
    parts = arm(LIMIT.format(2, 0)) + arm(LIMIT.format(0, 3), "left") + arm("", "right")
    parts += """<ros2_control name="arm" type="system"><joint name="hinge">
        <command_interface name="velocity"/>
        <command_interface name="position"><param name="min">-0.2</param>
          <param name="max">0.3</param></command_interface><state_interface name="velocity"/>
        <state_interface name="position"><param name="initial_value">0.1</param></state_interface>
        </joint></ros2_control>
      <transmission name="both"><type>transmission_interface/DifferentialTransmission</type>
        <joint name="left"><hardwareInterface>hardware_interface/VelocityJointInterface
        </hardwareInterface></joint><joint name="right"/></transmission>"""
    found, remarks = servos(tmp_path, parts)
    hinge, left, right = found["hinge"], found["left"], found["right"]
    assert (hinge.kind, hinge.lower, hinge.upper) == ("position", -0.2, 0.3)
    assert (hinge.start, left.start) == (0.1, 0.0)
    assert (hinge.max_effort, hinge.max_rate) == (2.0, math.inf)
    assert hinge.damping == pytest.approx(2.0 * hinge.stiffness / 30.0)
    assert (left.kind, left.lower, left.upper) == ("velocity", -3.0, 3.0)
    assert right.kind == "effort"
    for was, tag in (("-0.2", "command_interface"), (">0.1", "state_interface")):
        with pytest.raises(WorkbenchError, match=f"{tag} has <param>"):
            servos(tmp_path, parts.replace(was, f"{was[0]}x"))
    assert not any("ROS" in each for each in remarks)


def test_a_sidecar_drives_joints_beside_any_rotors(tmp_path):
    parts = arm(LIMIT.format(-1, -1)) + gazebo(
        "JointPositionController", "joint-position-controller", "<joint_name>hinge</joint_name>"
    )
    rows = "servos:\n  - {joint: hinge, stiffness: 5.0, damping_ratio: 0.5, time_constant: 0.1}\n"
    found, _ = servos(tmp_path, parts, rows)
    assert (found["hinge"].stiffness, found["hinge"].time_constant) == (5.0, 0.1)
    assert found["hinge"].damping == pytest.approx(0.5 * 2.0 * math.sqrt(5.0 * _inertia(tmp_path)))
    for row, said in (
        ("{joint: hinge, kind: spin}", "kind must be one of position, velocity, effort"),
        ("{joint: hinge, stiffness: -1.0}", "stiffness should be a positive number"),
        ("{kind: position}", "joint is missing: name the joint that it drives"),
        ("{joint: hing}", "the joint 'hing' does not exist"),
    ):
        with pytest.raises(WorkbenchError, match=said):
            servos(tmp_path, parts, f"servos:\n  - {row}\n")


def _inertia(folder) -> float:
    """Return what the hinge moves under the free drone [kg m²], from its servo's bandwidth."""
    found, _ = servos(folder, arm(LIMIT.format(-1, -1)), "servos:\n  - {joint: hinge}\n")
    return found["hinge"].stiffness / 30.0**2


def test_setpoints_are_parameters_of_the_vehicle(tmp_path):
    drive = "".join(
        gazebo(
            "JointPositionController", "joint-position-controller", f"<joint_name>{n}</joint_name>"
        )
        for n in ("a-b", "a b")
    )
    parts = arm(LIMIT.format(-1, -1), "a-b") + arm("", "a b") + drive
    first, second = servo_parameters(make_vehicle(read_description(drone(tmp_path, parts))))
    assert (first.name, second.name) == ("servo_a_b", "servo_a_b_")
    assert (first.minimum, first.maximum, first.unit) == (-0.5, 1.5, "rad")
    assert second.maximum == pytest.approx(2.0 * math.pi)


def test_three_rotors_fly_with_a_tilt_for_yaw(tmp_path):
    """Without moments of drag only the tail's tilt turns it: m_z = -l T sin(angle), by hand."""
    tail = link("tail", 0.05) + joint(
        "tilt", "revolute", "base", "tail", (-0.2, 0, 0), (1, 0, 0), LIMIT.format(-1, 6)
    )
    path = drone(tmp_path, tail)
    beside = tmp_path / "jointed.rotors.yaml"
    rows = [
        "{name: left, position: [0.1, 0.2, 0.0], direction: cw}",
        "{name: right, position: [0.1, -0.2, 0.0], direction: ccw}",
        "{name: tail, link: tail, position: [0, 0, 0], direction: cw}",
    ]
    head = beside.read_text().partition("rotors:")[0].replace("0.016", "0")
    beside.write_text(
        f"{head}rotors:\n" + "".join(f"  - {row}\n" for row in rows) + "servos: [{joint: tilt}]\n"
    )
    vehicle = make_vehicle(read_description(path))
    (tilt,) = vehicle.tilts
    column = tilt.column(vehicle.rotors, (0.0, 0.0, 0.0))
    assert column == pytest.approx([0.0, -1.0, 0.0, 0.0, 0.0, 0.2], abs=1e-12)
    beside.write_text(beside.read_text().replace("moment_constant: 0", "moment_constant: 0.016"))
    rotors = make_vehicle(read_description(path)).rotors  # its drag torque turns with the tail
    column = tilt.column(rotors, (0.0, 0.0, 0.0))
    assert column == pytest.approx([0.0, -1.0, 0.0, 0.0, -0.016, 0.2], abs=1e-12)
    beside.write_text(beside.read_text().replace("servos: [{joint: tilt}]", ""))
    with pytest.raises(WorkbenchError, match="3 rotors are declared, a multirotor has four"):
        make_vehicle(read_description(path))


def test_the_lag_of_a_servo_is_its_delay_in_a_slow_motion():
    """The slope of the phase at zero frequency: of spring and damper, low-pass and delay."""
    servo = Servo(stiffness=2.0, damping=0.5, time_constant=0.1, delay=0.03)
    s = 1e-4j
    follows = 2.0 / (0.5 * s + 2.0) / (0.1 * s + 1.0) * cmath.exp(-0.03 * s)
    assert servo.lag == pytest.approx(-cmath.phase(follows) / 1e-4, rel=1e-6)


def test_a_servo_of_a_shifted_position_is_shifted_with_all_of_its_positions():
    servo = Servo(lower=-0.5, upper=1.5, start=0.2)
    there = servo.shifted(0.3)
    for setpoint in (-1.0, servo.start, 2.0):
        assert there.within(setpoint + 0.3) == pytest.approx(servo.within(setpoint) + 0.3)
    assert there.start == pytest.approx(servo.start + 0.3)
    rate = Servo("velocity", lower=-0.5, upper=1.5, start=0.2)
    assert rate.shifted(0.3) == rate
