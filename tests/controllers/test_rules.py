"""What a vehicle's gains mean in each law: the PD cascade's, and integrals as slow as they say."""

import dataclasses
import math
from pathlib import Path

import pytest

from workbench.control.controller import load_controller
from workbench.control.flight_law import known_vehicle, law_constants
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.plant.loading import load_vehicle

FIVE_INCH = Path(__file__).parents[1] / "drones" / "five_inch_quad.urdf.xacro"


def test_pid_is_the_cascade_with_integrals_slower_than_its_loops(vehicle):
    """Time constants kp / ki: ten of a velocity loop, 20 of a rate loop, five of the yaw rate's."""
    pd, found = pd_rule(vehicle), load_controller("pid").rule(vehicle)
    assert found["kp_tilt"] * found["kp_rate"] == pytest.approx(pd["kp_roll"], rel=0.05)
    assert found["kp_rate"] == pytest.approx(pd["kd_roll"])
    for loop, slower in (("velocity_xy", 10), ("velocity_z", 10), ("rate", 20), ("yaw_rate", 5)):
        kp, ki = found[f"kp_{loop}"], found[f"ki_{loop}"]
        assert kp / ki == pytest.approx(slower / kp), loop


def test_indi_and_geometric_have_the_cascades_damping(vehicle):
    """Both damp the tilt as the cascade does; the geometric heading is critically damped."""
    pd = pd_rule(vehicle)
    damping = pd["kd_roll"] / (2.0 * math.sqrt(pd["kp_roll"]))
    indi, geometric = (load_controller(name).rule(vehicle) for name in ("indi", "geometric"))
    for kp, kd in (
        (indi["kp_tilt"], indi["kd_tilt"]),
        (geometric["k_attitude_xy"], geometric["k_rate_xy"]),
    ):
        assert kd / (2.0 * math.sqrt(kp)) == pytest.approx(damping)
    heading = geometric["k_rate_z"] / (2.0 * math.sqrt(geometric["k_attitude_z"]))
    assert heading == pytest.approx(1.0)
    assert geometric["k_position_xy"] / geometric["k_velocity_xy"] == pd["kp_position_xy"]
    assert indi["kp_velocity_xy"] < pd["kp_velocity_x"] and indi["kp_velocity_z"] < 5.0


def test_the_feedback_of_lqis_weights_is_near_the_cascade(vehicle):
    """Within a third; 9.81 times the gain of the velocity over that of the tilt is 1/s, too."""
    law, pd = load_controller("lqi"), pd_rule(vehicle)
    g = {row.name: row.default for row in law.parameters} | law.rule(vehicle)
    numbers = law.gains(g, known_vehicle(law_constants(vehicle)), 1 / 128)
    found = dict(zip(law.gain_names, numbers, strict=True))
    for value, alike in (
        (9.81 * found["level_velocity"] / found["level_tilt"], pd["kp_velocity_x"]),
        (found["level_rate"], pd["kd_roll"]),
        (found["climb_velocity"], pd["kp_velocity_z"]),
        (found["yaw_rate"], pd["kp_yaw_rate"]),
        (found["level_tilt"] / found["level_rate"], pd["kp_roll"] / pd["kd_roll"]),
    ):
        assert 2 / 3 < value / alike < 3 / 2
    for loop in ("level", "climb", "yaw"):
        rate = found.get(f"{loop}_velocity", found.get(f"{loop}_rate"))
        assert 0.3 < found[f"{loop}_integral"] / rate < 1.2, loop


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
