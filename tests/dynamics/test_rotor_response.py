"""Oracles: the closed form of a first-order lag, and scipy's integration of its equation."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from scipy.integrate import solve_ivp

from workbench.dynamics.rotor_response import (
    rotor_constants,
    speed_slope,
    split_error,
    step_rotor,
    within,
)

UP, DOWN = 0.0125, 0.025
PERIOD = 1 / 1024
"""Of the physics, usually [s]."""
BLEND = 3.0
"""Speed difference over which the two time constants blend [rad/s]."""
NEAR = BLEND / 3
"""The most that goes by the other time constant: with x = e / BLEND, x (1 - (x² / (x² + 1))^1.5)
is at most 0.66, at 1.25, and that takes half of it."""


@pytest.fixture
def rotor(vehicle):
    return dataclasses.replace(
        vehicle.rotors[0],
        motor_constant=8e-6,
        time_constant_up=UP,
        time_constant_down=DOWN,
        max_rot_velocity=1100.0,
    )


def plain_lag(command, speed, time):
    """The lag without a blend."""
    constant = UP if command > speed else DOWN
    return command + (speed - command) * np.exp(-np.asarray(time) / constant)


def blended_rate(_, w, command):
    up, down = split_error(command - w[0])
    return [up / UP + down / DOWN]


@pytest.mark.parametrize("error", [-1e4, -5.0, -1e-3, 0.0, 1e-3, 0.7, 300.0])
def test_the_two_parts_of_an_error_are_its_sides_but_for_the_blend(error):
    up, down = split_error(error)
    assert up + down == pytest.approx(error, abs=1e-9)
    other = min(NEAR, BLEND**2 / max(1.3 * abs(error), 1e-9))  # it fades
    assert up == pytest.approx(max(error, 0.0), abs=other)
    assert down == pytest.approx(min(error, 0.0), abs=other)


def test_at_no_error_both_parts_have_half_the_slope():
    """So that a linear model of hover has the mean of the two rates."""
    up, down = split_error(AutoDiffXd(0.0, [1.0]))
    assert (up.value(), down.value()) == (0.0, 0.0)
    assert up.derivatives()[0] == pytest.approx(0.5)
    assert down.derivatives()[0] == pytest.approx(0.5)


@pytest.mark.parametrize(("begin", "end"), [(200.0, 1000.0), (1000.0, 200.0), (0.0, 1100.0)])
def test_after_its_time_constant_63_percent_of_the_way_is_done(rotor, begin, end):
    """But for the little that goes by the other one."""
    constant = UP if end > begin else DOWN
    *_, speed = step_rotor(end, begin, rotor_constants(rotor, constant))
    assert speed - begin == pytest.approx((1.0 - math.exp(-1.0)) * (end - begin), abs=NEAR)


@pytest.mark.parametrize(("begin", "end"), [(300.0, 900.0), (900.0, 300.0), (500.0, 500.0)])
def test_stepping_on_follows_the_closed_form_at_every_sample(rotor, begin, end):
    constants = rotor_constants(rotor, PERIOD)
    speed = begin
    for step in range(1, 160):
        *_, speed = step_rotor(end, speed, constants)
        assert speed == pytest.approx(plain_lag(end, begin, step * PERIOD), abs=NEAR)


@pytest.mark.parametrize(("begin", "end"), [(300.0, 900.0), (900.0, 300.0), (600.0, 603.0)])
def test_stepping_on_follows_the_blended_equation(rotor, begin, end):
    """To second order: a quarter of the error with half the step."""
    times = np.arange(160) * PERIOD
    solved = solve_ivp(
        blended_rate, (0.0, times[-1]), [begin], t_eval=times, args=(end,), rtol=1e-11, atol=1e-11
    )
    worst = []
    for parts in (1, 2):
        constants = rotor_constants(rotor, PERIOD / parts)
        speed, errors = begin, []
        for expected in solved.y[0]:
            errors.append(abs(speed - expected))
            for _ in range(parts):
                *_, speed = step_rotor(end, speed, constants)
        worst.append(max(errors))
    assert worst[0] < 1e-3
    assert worst[1] < 0.3 * worst[0]


@pytest.mark.parametrize(("begin", "end"), [(200.0, 1000.0), (1000.0, 200.0), (500.0, 500.5)])
def test_the_middle_of_a_step_is_on_the_way_with_the_slope_that_it_has_there(rotor, begin, end):
    middle, slope, _ = step_rotor(end, begin, rotor_constants(rotor, PERIOD))
    *_, half = step_rotor(end, begin, rotor_constants(rotor, PERIOD / 2))
    assert middle == pytest.approx(half, abs=1e-3)
    assert slope == pytest.approx(blended_rate(0.0, [middle], end)[0])


@pytest.mark.parametrize(("begin", "end"), [(300.0, 900.0), (900.0, 300.0), (600.0, 603.0)])
def test_in_a_step_of_no_length_the_slope_is_that_of_the_equation(rotor, begin, end):
    constants = rotor_constants(rotor, 0.0)
    middle, slope, after = step_rotor(end, begin, constants)
    assert (middle, after) == pytest.approx((begin, begin))
    assert slope == pytest.approx(blended_rate(0.0, [begin], end)[0])
    assert speed_slope(end, begin, rotor_constants(rotor, PERIOD)) == pytest.approx(slope)


def test_a_steady_speed_stays(rotor):
    for speed in (0.0, 10.0, 770.0, 1100.0):
        assert step_rotor(speed, speed, rotor_constants(rotor, PERIOD)) == (speed, 0.0, speed)


def test_speed_never_leaves_the_way(rotor):
    rng = np.random.default_rng(7)
    constants = rotor_constants(rotor, PERIOD)
    for command, speed in rng.uniform(0, 1100, (500, 2)):
        middle, _, after = step_rotor(command, speed, constants)
        for one in (middle, after):
            assert min(command, speed) - 1e-9 <= one <= max(command, speed) + 1e-9


def test_a_command_is_cut_to_what_the_rotor_can_do():
    assert [within(u, 1100.0) for u in (-5.0, 0.0, 700.0, 1100.0, 9e9)] == [0, 0, 700, 1100, 1100]
