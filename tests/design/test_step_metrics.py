"""Oracles: closed forms of first- and second-order responses."""

import math

import numpy as np
import pytest

from workbench.design.response_metrics import crossing_time
from workbench.design.step_metrics import step_metrics

TIME = np.linspace(0.0, 10.0, 10001)
TICK = 1e-3


def first_order(tau: float) -> np.ndarray:
    return 1.0 - np.exp(-TIME / tau)


def second_order(damping: float, frequency: float) -> np.ndarray:
    decay = damping * frequency
    damped = frequency * math.sqrt(1.0 - damping**2)
    swing = np.cos(damped * TIME) + decay / damped * np.sin(damped * TIME)
    return 1.0 - np.exp(-decay * TIME) * swing


@pytest.mark.parametrize("command", [1.0, 2.5, -0.2])
def test_a_first_order_response(command):
    """From 10 to 90 % in tau ln 9, within 2 % after tau ln 50, never beyond."""
    tau = 0.4
    metrics = step_metrics(TIME, command * first_order(tau), command)
    assert metrics.rise_time == pytest.approx(tau * math.log(9.0), abs=2 * TICK)
    assert metrics.settling_time == pytest.approx(tau * math.log(50.0), abs=2 * TICK)
    assert metrics.overshoot == pytest.approx(0.0, abs=1e-9)
    assert metrics.undershoot == pytest.approx(0.0, abs=1e-9)
    assert metrics.steady_state_value == pytest.approx(command)
    assert metrics.steady_state_error == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("damping", [0.3, 0.5, 0.7])
@pytest.mark.parametrize("command", [1.0, -2.0])
def test_a_second_order_response(damping, command):
    """Overshoot exp(-pi z / sqrt(1 - z²)) after half a damped period."""
    frequency = 5.0
    metrics = step_metrics(TIME, command * second_order(damping, frequency), command)
    root = math.sqrt(1.0 - damping**2)
    overshoot = math.exp(-math.pi * damping / root)
    assert metrics.overshoot == pytest.approx(100.0 * overshoot, rel=1e-3)
    assert metrics.peak == pytest.approx(abs(command) * (1.0 + overshoot), rel=1e-4)
    assert metrics.peak_time == pytest.approx(math.pi / (frequency * root), abs=2 * TICK)


def test_a_response_that_comes_to_another_value_than_asked():
    metrics = step_metrics(TIME, 0.9 * first_order(0.2), 1.0)
    assert metrics.steady_state_value == pytest.approx(0.9)
    assert metrics.steady_state_error == pytest.approx(10.0)
    mirrored = step_metrics(TIME, -0.9 * first_order(0.2), -1.0)
    assert mirrored.steady_state_error == pytest.approx(10.0)


def test_a_response_that_begins_the_wrong_way():
    """1 - exp(-t) (1 + 2 t) is lowest where its slope is 0: at t = 1/2, 1 - 2 exp(-1/2)."""
    metrics = step_metrics(TIME, 1.0 - np.exp(-TIME) * (1.0 + 2.0 * TIME), 1.0)
    lowest = 1.0 - 2.0 * math.exp(-0.5)
    assert metrics.undershoot == pytest.approx(-100.0 * lowest, rel=1e-2)


@pytest.mark.parametrize(("settled_s", "counts"), [(7.9, True), (8.1, False)])
def test_what_settles_in_the_last_fifth_has_not_settled(settled_s, counts):
    """A ramp to 1, which is within 2 % of it at the given time of 10 s."""
    ramp = np.minimum(0.98 * TIME / settled_s, 1.0)
    metrics = step_metrics(TIME, ramp, 1.0)
    for name in ("rise_time", "settling_time", "overshoot", "steady_state_value"):
        assert math.isfinite(getattr(metrics, name)) is counts, name
    assert ("has not settled within 10 s" in metrics.withheld) is not counts
    if counts:
        assert metrics.settling_time == pytest.approx(settled_s, abs=2 * TICK)


@pytest.mark.parametrize("command", [2.0, -2.0])
@pytest.mark.parametrize(("share", "counts"), [(0.015, True), (0.03, False)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_begins_at_rest_within_2_percent_on_both_sides(command, share, counts, sign):
    begin = sign * share * command
    metrics = step_metrics(TIME, begin + (command - begin) * first_order(0.4), command)
    assert math.isfinite(metrics.rise_time) is counts
    assert ("did not begin at rest" in metrics.withheld) is not counts
    assert metrics.steady_state_value == pytest.approx(command)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_crossing_lies_between_samples(sign):
    time = np.array([0.0, 1.0, 2.0, 3.0])
    response = sign * np.array([0.0, 1.0, 3.0, 2.0])
    assert crossing_time(time, response, sign * 2.5) == pytest.approx(1.75)
    assert crossing_time(time, response, sign * 1.0) == pytest.approx(1.0)


def test_a_crossing_of_a_first_order_response():
    found = crossing_time(TIME, first_order(0.4), 0.9)
    assert found == pytest.approx(0.4 * math.log(10.0), abs=1e-6)


def test_a_crossing_that_never_comes_is_no_number():
    assert math.isnan(crossing_time(TIME, first_order(0.4), 1.1))
    assert math.isnan(crossing_time(TIME, first_order(0.4), -0.1))


def test_a_crossing_from_the_start():
    assert crossing_time(np.array([0.5, 1.0]), np.array([2.0, 3.0]), 1.0) == 0.5
