"""What a vehicle's gains mean in each law: the PD cascade's, and integrals as slow as they say."""

import math

import pytest

from workbench.control.controller_file import load_controller
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.controllers.pd_rule import rule as pd_rule


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
