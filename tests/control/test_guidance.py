"""The setpoint of velocity and yaw rate within its limits, by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.guidance import (
    Guidance,
    LawSetpoint,
    MeasuredMotion,
    Reference,
    velocity_setpoint,
)

LIMITS = SimpleNamespace(
    max_speed=4.0, max_climb_rate=1.5, max_height=30.0, max_tilt=0.5, max_yaw_rate=0.8
)


def setpoint(reference, height=10.0, authority=1.0, climb=0.0, correction=(0.0, 0.0, 0.0)):
    """Return commanded velocity and yaw rate far from obstacles."""
    still = (0.0, 0.0, 0.0)
    measured = MeasuredMotion((1.0, 2.0, height), still, still, (1.0, 0, 0, 0), still, still, ())
    guide = Guidance(1.0, 1.0, authority, climb, 0.0, 0.0, 0.0, 0.0, 0.0)
    asked = LawSetpoint(tuple(reference), tuple(guide), still)
    return velocity_setpoint(correction, measured, asked, LIMITS)


def test_without_authority_no_part_of_the_reference_counts(case):
    for place, name in enumerate(Reference._fields):
        reference = [0.0] * len(Reference._fields)
        reference[place] = 0.7
        with case(name):
            assert setpoint(reference, authority=0.0, climb=0.4) == (0.0, 0.0, 0.4, 0.0)


def test_each_part_keeps_its_limit_and_its_direction(case):
    draw = np.random.default_rng(4)
    for _ in range(50):
        v_x, v_y, v_z, yaw_rate = draw.uniform(-8.0, 8.0, 4).tolist()
        with case(v_x, v_y, v_z, yaw_rate):
            *velocity, turn = setpoint(Reference(v_x, v_y, v_z, yaw_rate, 0.0, 0.0, 0.0, 0.0))
            level = math.hypot(v_x, v_y)
            share = min(1.0, 4.0 / level)
            assert velocity[:2] == pytest.approx([share * v_x, share * v_y])
            assert velocity[2] == pytest.approx(math.copysign(min(1.5, abs(v_z)), v_z))
            assert turn == pytest.approx(math.copysign(min(0.8, abs(yaw_rate)), yaw_rate))


def test_a_climb_slows_down_towards_the_largest_height_and_reverses_above_it(case):
    up = Reference(0.0, 0.0, 1.2, 0.0, 0.0, 0.0, 0.0, 0.0)
    for height, expected in ((20.0, 1.2), (29.5, 0.5), (30.0, 0.0), (30.4, -0.4), (50.0, -1.5)):
        with case(height):
            assert setpoint(up, height)[2] == pytest.approx(expected)
