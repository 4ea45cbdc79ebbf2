"""The gimbal of a drone in MAVLink: rotations of scipy, and pymavlink's own station."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="install the extra `mavlink` to try it")

from pymavlink.dialects.v20 import common as mavlink

from tests.extras.gateways.test_mavlink import FLU_FRD, Ground
from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.mavlink_gimbal import gimbal_of
from workbench.link import Client
from workbench.link.hello import ParameterRow

JOINT = (
    '<joint name="{name}"><origin rpy="{rpy}"/><parent link="{parent}"/><child link="{child}"/>'
    '<axis xyz="{axis}"/></joint>'
)


def described(*joints):
    """Return URDF with joints in a chain, the last first in the file.

    Each is its name, its axis, and if need be its child link and the rpy of its origin.
    """
    made, parent = [], "base_link"
    for number, (name, axis, more) in enumerate(joints):
        link = {"child": f"link{number}", "rpy": "0 0 0", "parent": parent} | more
        made.append(JOINT.format(name=name, axis=axis, **link))
        parent = link["child"]
    return f"<robot>{''.join(reversed(made))}</robot>"


def row(joint, low=-0.8, high=1.6, unit="rad"):
    return ParameterRow(f"servo_{joint}", unit, low, high, 0.1, "setpoint")


THREE = described(
    ("gimbal_yaw", "0 0 1", {}),
    ("gimbal_roll", "-2 0 0", {}),
    ("tilt", "0 1 0", {"child": "camera"}),
)
ROWS = [row("gimbal_yaw"), row("gimbal_roll"), row("tilt"), row("arm")]


def test_the_attitude_is_that_of_the_chain_in_axes_of_the_heading():
    """R_NED_FRD of body and joints, turned back by the heading: forward, right and down."""
    gimbal = gimbal_of(THREE, ROWS)
    random = np.random.default_rng(3)
    for _ in range(50):
        roll, pitch = random.uniform(-1.0, 1.0, 2)
        yaw_q, roll_q, tilt_q = random.uniform(-1.5, 1.5, 3)
        R_WB = Rotation.from_euler("YX", [pitch, roll])  # without heading, intrinsic
        R_BC = (
            Rotation.from_rotvec([0.0, 0.0, yaw_q])
            * Rotation.from_rotvec([-roll_q, 0.0, 0.0])
            * Rotation.from_rotvec([0.0, tilt_q, 0.0])
        )
        expected = FLU_FRD @ (R_WB * R_BC).as_matrix() @ FLU_FRD
        joints = {"gimbal_yaw": yaw_q, "gimbal_roll": roll_q, "tilt": tilt_q}
        w, x, y, z = gimbal.attitude(roll, pitch, joints)
        assert Rotation.from_quat([x, y, z, w]).as_matrix() == pytest.approx(expected, abs=1e-12)
        angles = gimbal.angles_of(gimbal.attitude(0.0, 0.0, joints))
        assert angles == pytest.approx({0: -roll_q, 1: -tilt_q, 2: -yaw_q})


def test_angles_are_up_and_right_whatever_the_joint_turns_about():
    gimbal = gimbal_of(THREE, ROWS)
    assert gimbal.limits() == [-1.6, 0.8, -1.6, 0.8, -1.6, 0.8]  # each joint turns the other way
    assert gimbal.setpoints({1: -0.5, 2: 0.25}) == {"servo_tilt": 0.5, "servo_gimbal_yaw": -0.25}
    assert gimbal.setpoints({1: math.nan, 2: 0.0}) == {"servo_gimbal_yaw": 0.0}
    assert gimbal.neutral() == {name: 0.1 for name in gimbal.neutral()} and len(gimbal.axes) == 3
    down = gimbal.angles_of((0.5**0.5, 0.0, -(0.5**0.5), 0.0))
    assert gimbal.setpoints(down) == pytest.approx(
        {"servo_tilt": math.pi / 2, "servo_gimbal_roll": 0.0, "servo_gimbal_yaw": 0.0}, abs=1e-6
    )
    up = gimbal_of(described(("gimbal_tilt", "0 -1 0", {})), [row("gimbal_tilt")])
    assert up.limits() == [0.0, 0.0, -0.8, 1.6, 0.0, 0.0]
    assert up.setpoints({1: 0.5, 2: 0.0}) == {"servo_gimbal_tilt": 0.5}
    with pytest.raises(WorkbenchError, match="has pitch only: leave out yaw"):
        up.setpoints({1: 0.5, 2: 0.1})


@pytest.mark.parametrize(
    "description",
    [
        described(("arm", "0 1 0", {})),  # another joint with a servo
        described(("gimbal_free", "0 1 0", {})),  # no servo
        described(("gimbal_spin", "0 1 0", {})),  # a servo of velocity
        described(("gimbal_yaw", "0 0.7 0.7", {})),  # between axes
        described(("gimbal_yaw", "0 0 1", {"rpy": "0 0.5 0"})),  # about a tilted axis
        described(("gimbal_yaw", "0 0 1", {}), ("gimbal_roll", "0 0 1", {})),  # twice the same
        described(("mount", "1 0 0", {"rpy": "3.14 0 0"}), ("gimbal_yaw", "0 0 1", {})),
        "<robot>",
    ],
)
def test_what_is_no_gimbal_of_mavlink_is_none(description):
    assert gimbal_of(description, [*ROWS, row("gimbal_spin", unit="rad/s")]) is None


@pytest.fixture
def ground(served, tmp_path):
    scenario = tmp_path / "gimbal.yaml"
    scenario.write_text("{vehicle: {model: gimbal}, duration: 600, start: {mode: 'off'}}")
    made = Ground(served(str(scenario)), allow_commands=True)
    yield made
    made.close()


def test_a_station_finds_the_gimbal_and_aims_it(ground):
    """Downwards is positive about the joint's axis to the left, and negative in MAVLink."""

    def asked_for(number):
        ground.mav.mav.command_long_send(
            1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, number, *[0.0] * 6
        )

    asked_for(mavlink.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION)
    about = ground.receive("GIMBAL_MANAGER_INFORMATION")
    limits = (about.roll_min, about.roll_max, about.pitch_min, about.pitch_max)
    assert limits == pytest.approx((-0.8, 0.8, -1.6, 0.8))
    assert (about.yaw_min, about.yaw_max, about.gimbal_device_id) == (0.0, 0.0, 1)
    assert about.cap_flags & mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
    assert not about.cap_flags & mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
    asked_for(mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_INFORMATION)
    told = ground.receive("GIMBAL_DEVICE_INFORMATION")
    assert (told.model_name, told.pitch_min) == ("gimbal", pytest.approx(-1.6))

    accepted, denied = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED
    aim, nan = mavlink.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW, math.nan
    assert ground.order(aim, -30.0, nan, nan, nan) == accepted
    q = ground.receive("GIMBAL_DEVICE_ATTITUDE_STATUS", where=lambda each: each.q[2] < -0.25).q
    pitch = Rotation.from_quat([*q[1:], q[0]]).as_euler("ZYX", degrees=True)[1]
    assert -40.0 < pitch < -28.0  # on its way, with a damping ratio of 0.7
    assert ground.order(aim, 0.0, 20.0, nan, nan) == denied
    assert "has roll and pitch only" in ground.said[-1]
    assert ground.order(aim, 60.0, nan, nan, nan) == denied  # beyond the joint
    assert ground.order(aim, 0.0, nan, 5.0, nan) == denied  # a rate

    configure = mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE
    assert ground.order(configure, 7.0, 8.0, -1.0, -1.0) == accepted  # another component
    status = ground.receive("GIMBAL_MANAGER_STATUS", where=lambda each: each.primary_control_sysid)
    assert (status.primary_control_sysid, status.primary_control_compid) == (7, 8)
    assert ground.order(aim, 0.0, nan, nan, nan) == denied
    assert ground.order(configure, -2.0, 0.0, -1.0, -1.0) == accepted
    ground.mav.mav.gimbal_manager_set_pitchyaw_send(1, 1, 0, 0, 0.4, nan, nan, nan)
    assert ground.receive("GIMBAL_DEVICE_ATTITUDE_STATUS", where=lambda each: each.q[2] > 0.15)
    down = Rotation.from_euler("Y", -45.0, degrees=True).as_quat(scalar_first=True)
    rates = (nan, nan, nan)
    ground.mav.mav.gimbal_manager_set_attitude_send(1, 1, 0, 0, down, *rates)
    assert ground.receive("GIMBAL_DEVICE_ATTITUDE_STATUS", where=lambda each: each.q[2] < -0.36)
    neutral = float(mavlink.GIMBAL_MANAGER_FLAGS_NEUTRAL)
    in_whole = (aim, 0, 0, -20.0, nan, nan, nan, 0, 0, 0.0)
    ground.mav.mav.command_int_send(1, 1, mavlink.MAV_FRAME_GLOBAL, *in_whole)
    assert ground.receive("COMMAND_ACK", where=lambda each: each.command == aim).result == accepted
    assert ground.order(aim, nan, nan, nan, nan, neutral) == accepted
    with Client(ground.address) as client:
        assert client.parameters("servo_gimbal_pitch") == {"servo_gimbal_pitch": 0.0}
