"""Wishes that follow from what the rule's gains reach."""

import math

import numpy as np
import pytest

from workbench.control.controller import load_controller
from workbench.design.tune.case import NOMINAL, Case, Robustness
from workbench.design.tune.plan import (
    completed,
    default_wishes,
    softened,
    wished_quantities,
)
from workbench.design.tune.requirement import requirements
from workbench.design.tune.wish import parse_wish

GOOD = {
    "rise_time": 0.5,
    "overshoot": 2.0,
    "steady_state_error": 1.0,
    "phase_margin": math.radians(60.0),
    "disk_margin": 0.9,
}
CORNER = Case(0.8, 0.7, 1.5)


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
    names = [wish.name for wish in completed(asked, list(wishes().values()))]
    assert names.count("x.rise_time") == 1
    assert "y.rise_time" in names


def test_corners_of_defaults_give_way_to_what_the_rule_reaches():
    default = wishes()["roll.disk_margin"]
    (asked,) = parse_wish("pitch.disk_margin>=0.6")
    required = requirements([default, asked], [NOMINAL, CORNER], Robustness())
    bounds = [each.bound for each in softened(required, np.array([0.9, 0.9, 0.2, 0.2]))]
    assert bounds == pytest.approx([0.6, 0.6, 0.18, 0.36])
    unstable = softened(required, np.array([0.9, 0.9, -1.0, -1.0]))
    assert [each.wish for each in unstable] == [default, asked, asked]
