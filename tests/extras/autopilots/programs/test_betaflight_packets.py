"""The packets of Betaflight's SITL, byte by byte, in its axes."""

import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.extras.autopilots.programs.betaflight_packets import (
    ReceiverChannels,
    channels_packet,
    motion_packet,
    motors_in,
)

FRD_FLU = np.diag([1.0, -1.0, -1.0])
NED_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def test_motion_is_in_forward_right_down_and_north_east_down(case):
    """By matrices of the axes; its accelerometer reads minus the specific force."""
    random = np.random.default_rng(4)
    for R_WB in (Rotation.identity(), *Rotation.random(5, random_state=3)):
        rates, force = random.normal(size=(2, 3))
        x, y, z, w = R_WB.as_quat()
        numbers = struct.unpack("<18d", motion_packet(rates, force, (w, x, y, z)))
        with case((w, x, y, z)):
            assert numbers[1:4] == pytest.approx(FRD_FLU @ rates)
            assert numbers[4:7] == pytest.approx(-force)
            told = Rotation.from_quat([*numbers[8:11], numbers[7]]).as_matrix()
            np.testing.assert_allclose(told, NED_ENU @ R_WB.as_matrix() @ FRD_FLU, atol=1e-9)
            assert (numbers[0], *numbers[11:]) == (*[0.0] * 7, 101325.0)


def test_channels_are_roll_pitch_throttle_yaw_the_switch_and_the_mode_within_their_limits():
    sticks = ReceiverChannels(roll=1234.6, pitch=2300.0, throttle=900.0, yaw=1400.0)
    told = struct.unpack("<d16H", channels_packet(sticks, 1700.0))
    assert told == (0.0, 1235, 2000, 1000, 1400, 1700, 2000, *[1000] * 10)
    rates = struct.unpack("<d16H", channels_packet(ReceiverChannels(angle=False), 1000.0))
    assert rates == (0.0, 1500, 1500, 1000, 1500, 1000, *[1000] * 11)


def test_motors_are_shares_of_their_range_or_none_of_them_where_one_is_no_number():
    def packet(*us):
        return struct.pack("<I16f", 4, *us, *[0.0] * 12)

    assert motors_in(packet(1000.0, 1250.0, 2000.0, 1900.0)) == pytest.approx((0.0, 0.25, 1.0, 0.9))
    assert motors_in(packet(0.0, 990.0, 2100.0, 1500.0)) == pytest.approx((0.0, 0.0, 1.0, 0.5))
    assert motors_in(packet(1500.0, float("nan"), 1500.0, 1500.0)) == ()
