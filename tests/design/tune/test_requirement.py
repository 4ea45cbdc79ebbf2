"""What wishes ask of a vehicle and of its corners, and wishes that follow from the vehicle."""

import math

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.design.tune.case import NOMINAL_CASE, Robustness, VehicleCase, robustness_corners
from workbench.design.tune.requirement import (
    MISSING_VALUE_RESERVE,
    completed_wishes,
    default_wishes,
    guard_wishes,
    guarded_quantities,
    requirements,
    softened_requirements,
    wished_quantities,
)
from workbench.design.tune.wish import parse_wish

CORNER = VehicleCase(0.8, 0.7, 1.5)


def required(text, case=NOMINAL_CASE):
    (found,) = requirements(parse_wish(text), [case], Robustness())
    return found


def test_a_reserve_is_a_share_of_the_bound(case):
    for text, value, reserve in [
        ("x.rise_time<=0.4", 0.3, 0.25),
        ("x.rise_time<=0.4", 0.4, 0.0),
        ("x.rise_time<=0.4", 0.6, -0.5),
        ("x.rise_time<=0.4", 0.8, -1.0),
        ("x.rise_time<=0.4", 0.4 + 0.4 * math.e, -2.0),
        ("x.rise_time>=0.4", 0.3, -0.25),
        ("x.overshoot<=0", 0.5, -0.5),
        ("pitch.disk_margin>=0.6", 0.9, 0.5),
        ("pitch.disk_margin>=0.6", math.inf, -MISSING_VALUE_RESERVE),
        ("x.rise_time<=0.4", math.inf, MISSING_VALUE_RESERVE),
        ("x.rise_time<=0.4", math.nan, MISSING_VALUE_RESERVE),
    ]:
        with case(text, value, reserve):
            found = required(text)
            assert found.reserves(np.array([value]))[0] == pytest.approx(reserve)
            assert found.met(value) == (reserve >= 0.0)


def test_a_corner_is_asked_for_less():
    assert required("pitch.phase_margin>=50deg", CORNER).bound == pytest.approx(math.radians(30))
    assert required("pitch.gain_margin>=4", CORNER).bound == pytest.approx(4**0.6)
    assert required("x.overshoot<=5", CORNER).bound == 10.0
    assert required("x.overshoot<=0", CORNER).bound == 2.0


@pytest.mark.parametrize(
    "text",
    ["x.rise_time<=1", "x.peak_rotor_use<=0.9", "rotors.noise_amplification<=1", "x.overshoot>=1"],
)
def test_what_a_corner_is_not_asked_for(text):
    assert requirements(parse_wish(text), [CORNER], Robustness()) == ()


def test_it_says_where_it_is_asked():
    assert str(required("x.overshoot<=5")) == "x.overshoot <= 5 %"
    assert str(required("x.overshoot<=5", CORNER)) == (
        "x.overshoot <= 10 % with mass x 0.8, inertia x 0.7, rotor lag x 1.5"
    )


def test_corners_are_all_ends_of_what_is_unsure():
    found = robustness_corners(Robustness())
    assert len(set(found)) == 8
    assert CORNER in found
    assert {case.mass for case in found} == {0.8, 1.2}
    assert robustness_corners(Robustness(inertia=0.0, rotor_lag=0.0)) == [
        VehicleCase(0.8),
        VehicleCase(1.2),
    ]
    assert robustness_corners(Robustness(mass=0.0, inertia=0.0, rotor_lag=0.0)) == []
    assert CORNER.variation.rotor_lag == 1.5


GOOD = {
    "rise_time": 0.5,
    "overshoot": 2.0,
    "steady_state_error": 1.0,
    "phase_margin": math.radians(60.0),
    "disk_margin": 0.9,
}


def wishes(**other):
    reached = GOOD | other
    quantities = wished_quantities(load_controller())
    found = default_wishes(quantities, [reached[wish.metric.name] for wish in quantities])
    return {wish.name: wish for wish in found}


def test_a_good_vehicle_gets_the_usual_limits():
    found = wishes()
    assert len(found) == 4 * 3 + 6 * 2
    assert found["x.rise_time"].bound == pytest.approx(1.3 * 0.5)
    assert found["yaw.overshoot"].bound == 5.0
    assert math.degrees(found["roll.phase_margin"].bound) == pytest.approx(40.0, abs=0.1)
    assert found["velocity_z.disk_margin"].bound == 0.6


def test_what_the_rule_does_not_reach_is_not_asked_for():
    found = wishes(overshoot=9.0, disk_margin=0.5)
    assert found["x.overshoot"].bound == pytest.approx(10.0)
    assert found["roll.disk_margin"].bound == pytest.approx(0.45)


def test_what_it_has_not_at_all_is_left_out():
    assert "x.rise_time" not in wishes(rise_time=math.inf)
    assert "x.overshoot" not in wishes(overshoot=math.inf)


def test_a_wish_takes_the_place_of_the_default():
    asked = parse_wish("x.rise_time>=2")
    names = [wish.name for wish in completed_wishes(asked, list(wishes().values()))]
    assert names.count("x.rise_time") == 1
    assert "y.rise_time" in names


def test_a_loop_that_nobody_asked_about_keeps_nine_tenths_of_its_smaller_margin(case):
    """Of that with the rule's gains and of the present one; through a wished axis the usual one."""
    quantities = guarded_quantities(load_controller(), parse_wish("x.rise_time<=0.4"))
    for rule, now, kept in ((1.0, 1.5, 0.9), (1.5, 1.0, 0.9), (0.5, 2.0, 0.45), (-1.0, 1.0, None)):
        with case(rule, now):
            many = [rule] * len(quantities), [now] * len(quantities)
            found = {wish.name: wish.bound for wish in guard_wishes(*many, quantities)}
            assert found.get("roll.disk_margin") == found.get("roll.phase_margin") == kept
            usual = kept and min(kept, 0.6)
            assert found.get("pitch.disk_margin") == usual
            usual = kept and min(kept, math.radians(40.0))
            assert found.get("pitch.phase_margin") == usual


def test_corners_of_defaults_give_way_to_what_the_rule_reaches():
    default = wishes()["roll.disk_margin"]
    (asked,) = parse_wish("pitch.disk_margin>=0.6")
    required = requirements([default, asked], [NOMINAL_CASE, CORNER], Robustness())
    bounds = [
        each.bound for each in softened_requirements(required, np.array([0.9, 0.9, 0.2, 0.2]))
    ]
    assert bounds == pytest.approx([0.6, 0.6, 0.18, 0.36])
    unstable = softened_requirements(required, np.array([0.9, 0.9, -1.0, -1.0]))
    assert [each.wish for each in unstable] == [default, asked, asked]
