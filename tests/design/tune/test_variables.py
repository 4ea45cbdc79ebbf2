"""Gains as coordinates."""

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.design.tune.variables import (
    Variables,
    counterparts,
    mirrored_wishes,
    symmetric,
    variables_for,
)
from workbench.design.tune.wish import parse_wish

PD = load_controller()


def test_an_axis_answers_through_its_loops():
    found = variables_for(PD, ["x"], tied=False)
    assert found.groups == (
        ("kp_velocity_x",),
        ("kd_velocity_x",),
        ("kp_pitch",),
        ("kd_pitch",),
    )
    assert variables_for(PD, ["pitch"], tied=False) == variables_for(PD, ["velocity_x"], tied=False)
    assert variables_for(PD, ["yaw"], tied=True).groups == (("kp_yaw_rate",),)
    assert ("kp_position_xy",) in variables_for(PD, ["position_y"], tied=True).groups


def test_all_axes_of_a_symmetric_vehicle_have_seven_gains():
    found = variables_for(PD, ["x", "y", "z", "yaw"], tied=True)
    assert len(found.groups) == 7
    assert ("kp_pitch", "kp_roll") in found.groups
    assert found == variables_for(PD, ["rotors"], tied=True)
    assert len(variables_for(PD, ["rotors"], tied=False).groups) == 11


def test_loops_and_points_along_y_have_those_along_x_as_counterparts():
    """Named by hand: velocity, acceleration and position by their axes, roll beside pitch."""
    along_x = {f"{what}_y": f"{what}_x" for what in ("velocity", "acceleration", "position")}
    along_x |= {f"{what}_y_error": f"{what}_x_error" for what in ("velocity", "position")}
    along_x |= {f"roll{what}": f"pitch{what}" for what in ("", "_error", "_acceleration")}
    assert counterparts(PD) == {"y": "x"} | along_x


def test_coordinates_are_logarithms_and_come_back():
    found = variables_for(PD, ["rotors"], tied=False)
    point = found.point(load_controller().table.defaults())
    assert np.exp(point[found.groups.index(("kp_pitch",))]) == pytest.approx(150.0)
    back = found.gains(point)
    assert all(
        back[name] == pytest.approx(load_controller().table.defaults()[name]) for name in back
    )


def test_tied_gains_take_their_geometric_mean():
    found = Variables(load_controller().table, (("kp_pitch", "kp_roll"),))
    assert found.gains(found.point({"kp_pitch": 100.0, "kp_roll": 400.0})) == pytest.approx(
        {"kp_pitch": 200.0, "kp_roll": 200.0}
    )


def test_gains_stay_within_the_parameter_table():
    found = variables_for(PD, ["rotors"], tied=False)
    for corner in (found.low - 9.0, found.high + 9.0):
        for name, value in found.rounded(corner).items():
            row = load_controller().table.find(name)
            assert row.minimum <= value <= row.maximum
    nothing = found.gains(found.point(dict.fromkeys(load_controller().table.defaults(), 0.0)))
    assert nothing["kd_velocity_x"] == pytest.approx(0.001)
    assert nothing["kp_velocity_z"] == pytest.approx(0.5)


def wishes(*texts):
    return [wish for text in texts for wish in parse_wish(text)]


def test_equal_wishes_along_x_and_y_leave_them_tied():
    rule = load_controller().table.defaults()
    assert symmetric(PD, rule, [])
    assert symmetric(PD, rule, wishes("x.rise_time<=1", "z.rise_time<=1"))
    assert symmetric(PD, rule, wishes("level.rise_time<=1", "tilt.disk_margin>=0.5"))
    assert not symmetric(PD, rule, wishes("x.rise_time<=1", "y.rise_time<=2"))
    assert not symmetric(PD, rule, wishes("x.rise_time<=1", "roll.disk_margin>=0.5"))
    assert not symmetric(PD, {**rule, "kp_roll": 100.0}, [])


def test_a_wish_along_x_counts_along_y_too():
    found = mirrored_wishes(
        PD, wishes("x.rise_time<=1", "velocity_y.disk_margin>=0.5", "yaw.overshoot<=5")
    )
    assert {wish.name for wish in found} == {
        "x.rise_time",
        "y.rise_time",
        "velocity_x.disk_margin",
        "velocity_y.disk_margin",
        "yaw.overshoot",
    }
