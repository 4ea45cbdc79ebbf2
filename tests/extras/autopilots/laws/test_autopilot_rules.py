"""Gains that follow from a vehicle, for the laws of autopilots."""

import dataclasses
from pathlib import Path

import pytest

from workbench.control.controller_file import load_controller
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.extras.autopilots.mixers import flies_with_defaults
from workbench.plant.loading import load_vehicle

FIVE_INCH = Path(__file__).parents[3] / "drones" / "five_inch_quad.urdf.xacro"


def test_autopilots_keep_the_proportions_of_their_firmware(case):
    """Integral over proportional gain, within a fifth of what the firmware's defaults have."""
    vehicle = load_vehicle(FIVE_INCH)
    for name, pairs in (
        (
            "px4",
            (
                ("MC_ROLLRATE_I", "MC_ROLLRATE_P", 0.2 / 0.15),
                ("MC_YAWRATE_I", "MC_YAWRATE_P", 0.1 / 0.2),
                ("MPC_XY_VEL_I_ACC", "MPC_XY_VEL_P_ACC", 0.4 / 1.8),
                ("MPC_Z_VEL_I_ACC", "MPC_Z_VEL_P_ACC", 2.0 / 4.0),
            ),
        ),
        (
            "ardupilot",
            (
                ("ATC_RAT_RLL_I", "ATC_RAT_RLL_P", 0.135 / 0.135),
                ("ATC_RAT_YAW_I", "ATC_RAT_YAW_P", 0.018 / 0.18),
                ("ATC_RAT_RLL_D", "ATC_RAT_RLL_P", 0.0036 / 0.135),
                ("PSC_D_ACC_I", "PSC_D_ACC_P", 1.0 / 0.5),
            ),
        ),
        (
            "crazyflie",
            (
                ("pid_rate_roll_ki", "pid_rate_roll_kp", 500.0 / 250.0),
                ("pid_rate_yaw_ki", "pid_rate_yaw_kp", 16.7 / 120.0),
                ("velCtlPid_vxKi", "velCtlPid_vxKp", 1.0 / 25.0),
                ("velCtlPid_vzKi", "velCtlPid_vzKp", 15.0 / 25.0),
            ),
        ),
    ):
        found = load_controller(name).rule(vehicle)
        for over, under, wanted in pairs:
            with case(over):
                assert found[over] / found[under] == pytest.approx(wanted, rel=0.2)


def test_ardupilots_integral_is_slower_for_a_slower_loop():
    """Than the X500's, whose rate P of 0.135 turns it by 113 rad/s² a unit: as much slower."""
    quick = load_vehicle(FIVE_INCH)
    lag = {"time_constant_up": 0.06, "time_constant_down": 0.06}
    rotors = tuple(dataclasses.replace(rotor, **lag) for rotor in quick.rotors)
    slow = dataclasses.replace(quick, rotors=rotors)
    for vehicle, share in ((quick, 1.0), (slow, pd_rule(slow)["kd_roll"] / (0.135 * 113.0))):
        found = load_controller("ardupilot").rule(vehicle)
        ratio = found["ATC_RAT_RLL_I"] / found["ATC_RAT_RLL_P"]
        assert ratio == pytest.approx(share, rel=0.01)


def test_defaults_are_for_vehicles_within_1_6_of_theirs_to_both_sides():
    own = [1.0 / 1.61, 1.0 / 1.59, 1.0, 1.59, 1.61]
    assert flies_with_defaults([3.0 * each for each in own], [3.0] * 5) == [
        False,
        True,
        True,
        True,
        False,
    ]
