"""What messages of ROS 2 order."""

import math
from types import SimpleNamespace

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.extras.gateways.ros2_orders import (
    TWIST_STAMPED_TYPE,
    TWIST_TYPE,
    OperationOrder,
    VelocityOrder,
    order_of,
)

COMMAND_TYPE, STRING_TYPE = "dh_drone_msgs/msg/CommandVelocity", "std_msgs/msg/String"


def twist(x=0.0, y=0.0, z=0.0, turn=0.0, roll=0.0):
    return SimpleNamespace(
        linear=SimpleNamespace(x=x, y=y, z=z), angular=SimpleNamespace(x=roll, y=0.0, z=turn)
    )


def command(axes, x=1.0, y=2.0, z=3.0, turn=0.25):
    return SimpleNamespace(lease=9, axes=axes, v_x=x, v_y=y, v_z=z, yaw_rate=turn)


@pytest.mark.parametrize(
    ("yaw", "expected"),
    [
        (0.0, (2.0, 1.0, 0.5)),
        (math.pi / 2, (-1.0, 2.0, 0.5)),  # facing north: forward is y, left is -x
        (math.pi, (-2.0, -1.0, 0.5)),
        (-math.pi / 2, (1.0, -2.0, 0.5)),
    ],
)
def test_forward_and_left_of_cmd_vel_turn_with_the_heading(yaw, expected):
    order = order_of(TWIST_TYPE, twist(2.0, 1.0, 0.5, 0.3), publisher=7)
    assert order == VelocityOrder(7, (2.0, 1.0, 0.5), 0.3, levelled=True)
    assert order.in_world(yaw) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("frame", "levelled"),
    [
        ("base_link", True),
        ("", True),
        ("crazyflie/base_link", True),
        ("map", False),
        ("odom", False),
        ("world", False),
    ],
)
def test_a_stamped_velocity_is_in_the_axes_of_its_frame(frame, levelled):
    stamped = SimpleNamespace(header=SimpleNamespace(frame_id=frame), twist=twist(2.0, 1.0, 0.5))
    order = order_of(TWIST_STAMPED_TYPE, stamped, publisher=7)
    assert order == VelocityOrder(7, (2.0, 1.0, 0.5), 0.0, levelled)


def test_a_velocity_in_an_unknown_frame_is_no_order():
    stamped = SimpleNamespace(header=SimpleNamespace(frame_id="lidar_link"), twist=twist(2.0))
    order = order_of(TWIST_STAMPED_TYPE, stamped, publisher=7)
    assert "frame_id is 'lidar_link': write base_link for forward" in order


def test_the_papers_command_is_one_of_the_world():
    order = order_of(COMMAND_TYPE, command(axes=15), publisher=7)
    assert order == VelocityOrder(7, (1.0, 2.0, 3.0), 0.25, levelled=False)
    assert order.in_world(1.0) == (1.0, 2.0, 3.0)


def test_axes_that_are_not_used_are_zero():
    assert order_of(COMMAND_TYPE, command(axes=0b0010), 7).parts == (0.0, 2.0, 0.0)
    masked = order_of(COMMAND_TYPE, command(axes=0b1000, x=math.nan), 7)
    assert (masked.parts, masked.yaw_rate) == ((0.0, 0.0, 0.0), 0.25)


@pytest.mark.parametrize("axes", [0, 16, 2**32 - 1])
def test_a_command_without_axes_is_no_order(axes):
    assert order_of(COMMAND_TYPE, command(axes), 7) == (
        f"axes is {axes}: set bits 0 to 3 for those that count, 15 for all"
    )


@pytest.mark.parametrize(
    ("order", "neutral"),
    [(twist(), True), (twist(roll=1.0), True), (twist(turn=1e-9), False), (twist(z=-1.0), False)],
)
def test_neutral_is_zero_on_all_that_is_flown(order, neutral):
    assert order_of(TWIST_TYPE, order, 7).neutral is neutral


def test_what_is_not_finite_is_not_neutral():
    assert not order_of(TWIST_TYPE, twist(x=math.nan), 7).neutral


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("arm", OperationOrder(7, "arm")),
        ("hold", OperationOrder(7, "hold")),
        (" land ", OperationOrder(7, "land")),
        ("stop", OperationOrder(7, "stop")),
        ("take_off", OperationOrder(7, "take_off")),
        ("take_off 2.5", OperationOrder(7, "take_off", 2.5)),
    ],
)
def test_flight_operations_are_words(text, expected):
    assert order_of(STRING_TYPE, SimpleNamespace(data=text), 7) == expected


@pytest.mark.parametrize(
    "text", ["", "fly", "take_off high", "take_off nan", "take_off -1", "land now", "x" * 999]
)
def test_other_words_are_no_order(text):
    order = order_of(STRING_TYPE, SimpleNamespace(data=text), 7)
    assert (
        "is not an operation: write arm, take_off, take_off HEIGHT [m], hold, land or stop" in order
    )
    assert len(order) < 200
