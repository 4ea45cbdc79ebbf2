"""Metrics of a flight whose numbers are made up: what they are is counted by hand."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.design.regress.measures import find_measure
from workbench.session.recording import Recording

STEP = 0.01


def made_up(vehicle, time, **signals) -> Recording:
    """Return a recording that has zeros where no signal is given."""
    n = len(vehicle.rotors)
    sizes = {"q_WB": 4, "commanded_speeds": n, "rotor_speeds": n, "thrusts": n, "reference": 8}
    flat = {"mode", "charge", "clearance"}
    zeros = {
        field.name: np.zeros(len(time))
        if field.name in flat
        else np.zeros((len(time), sizes.get(field.name, 3)))
        for field in dataclasses.fields(Recording)[2:]  # without vehicle and time
        if field.default_factory is dataclasses.MISSING
    }
    return Recording(vehicle=vehicle, time=time, **{**zeros, **signals})


def test_numbers_of_rotors_are_counted_over_rotors_and_time(vehicle):
    """Four samples; a rotor's limit is the largest speed, and a use is a share of that."""
    most = vehicle.rotors[0].max_rot_velocity
    commands = most * np.array([[0.5] * 4, [0.5, 1.0, 0.5, 0.5], [1.0] * 4, [0.9] * 4])
    speeds = most * np.array([[0.4, 0.5, 0.6, 0.7]] * 3 + [[0.8, 0.5, 0.6, 0.7]])
    thrusts = np.array([[1.0, 2.0, 3.0, 4.0]] * 3 + [[5.0, 2.0, 3.0, 4.0]])
    time = STEP * np.arange(4)
    v_WB = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, -4.0], [1.0, 1.0, 1.0], [0.0, 4.0, 0.0]])
    turned = np.cos(0.15), np.sin(0.15)  # by 0.3 rad about x
    q_WB = np.array([[1.0, 0.0, 0.0, 0.0]] * 3 + [[turned[0], turned[1], 0.0, 0.0]])
    signals = {"commanded_speeds": commands, "rotor_speeds": speeds, "thrusts": thrusts}
    flown = made_up(vehicle, time, v_WB=v_WB, q_WB=q_WB, **signals)
    flight = SimpleNamespace(recording=flown, judged=flown)
    for name, wanted in (
        ("saturation", 50.0),  # one rotor is enough
        ("peak_rotor_use", 0.8),
        ("mean_rotor_use", (0.5 + 0.5 + 0.6 + 0.7) / 4),  # the first rotor: 3 x 0.4 and 0.8
        ("trim", 0.7 - 0.5),
        ("peak_thrust", 14.0),
        ("peak_speed", 5.0),
        ("peak_tilt", 0.3),
    ):
        assert find_measure(name).of(flight) == pytest.approx(wanted), name


def test_numbers_of_hover_are_those_of_half_a_second_before_the_edge(vehicle):
    """Before that, and after it, rotors turn at other speeds."""
    time = STEP * np.arange(201)
    hover = (time >= 0.5 - 1e-9) & (time <= 1.0 + 1e-9)
    speeds = np.where(hover[:, None], [400.0, 410.0, 420.0, 430.0], 900.0)
    thrusts = np.where(hover[:, None], [2.0] * 4, 9.0)
    flown = made_up(vehicle, time, rotor_speeds=speeds, thrusts=thrusts)
    flight = SimpleNamespace(recording=flown, before=flown, edge=1.0)
    for name, wanted in (
        ("hover_thrust", 8.0),
        ("hover_rotor_speed", 415.0),
        ("hover_rotor_spread", 30.0),
    ):
        assert find_measure(name).of(flight) == pytest.approx(wanted), name


def test_times_and_means_until_90_percent_of_a_command():
    """A ramp from 0.2 to 2.2 in a second: nine tenths of 2 are there after 0.8 s, at 2 m/s²."""
    time = STEP * np.arange(201)
    response = 0.2 + 2.0 * np.minimum(time, 1.0)
    flight = SimpleNamespace(time=time, response=response, command=2.0, edge=0.0)
    assert find_measure("t90").of(flight) == pytest.approx(0.8)
    assert find_measure("mean_acceleration").of(flight) == pytest.approx(2.0)
    followed = SimpleNamespace(time=time, setpoint=response + 0.3 * np.sign(time - 0.995))
    followed.response = response
    flight.followed = followed
    assert find_measure("tracking_error").of(flight) == pytest.approx(0.3)


def test_an_error_of_tracking_is_that_from_the_edge_on():
    """Before the edge the drone comes from elsewhere; from it on it is 0.2 behind."""
    time = STEP * np.arange(101)
    setpoint = np.where(time < 0.5 - 1e-9, 7.0, 0.2)
    followed = SimpleNamespace(time=time, setpoint=setpoint, response=np.zeros(101))
    flight = SimpleNamespace(followed=followed, edge=0.5)
    assert find_measure("tracking_error").of(flight) == pytest.approx(0.2)


@pytest.mark.parametrize(("longest", "wanted"), [(0.5, 0.3), (0.2, math.nan)])
def test_a_lag_beyond_the_longest_that_is_tried_is_unknown(longest, wanted):
    """A pulse 0.3 s late: the error still falls at the end of what is tried."""
    time = np.arange(0.0, 6.0, STEP)
    asked, flown = (np.exp(-(((time - at) / 0.5) ** 2)) for at in (3.0, 3.3))
    measure = find_measure("lag")
    found = measure.of(SimpleNamespace(followed=(time, asked, flown, longest)))
    assert found == pytest.approx(wanted, abs=STEP, nan_ok=True)
