"""Metrics of many steps, beside python-control's."""

import control
import numpy as np
import pytest

from workbench.design.tune.flight_numbers import SEARCHED_NUMBERS, flight_numbers

TIME = np.arange(0.0, 12.0, 1.0 / 128.0)


def second_order(w, z):
    return control.step_response(control.tf([w * w], [1.0, 2.0 * z * w, w * w]), TIME).outputs


SYSTEMS = ((2.0, 0.3), (3.0, 0.6), (2.5, 0.9), (4.0, 1.2), (8.0, 0.5))
RESPONSES = np.array([second_order(w, z) for w, z in SYSTEMS])
NONE = np.zeros(len(SYSTEMS), dtype=bool)


@pytest.mark.parametrize("command", [1.0, -0.5])
def test_they_are_step_infos_or_up_to_a_sample_more(command):
    ours = flight_numbers(TIME, command * RESPONSES, command, NONE)
    for index, response in enumerate(RESPONSES):
        info = control.step_info(command * response, T=TIME)
        assert 0.0 <= ours.rise_time[index] - info["RiseTime"] <= 2 / 128
        assert 0.0 <= ours.settling_time[index] - info["SettlingTime"] <= 1 / 128
        assert ours.overshoot[index] == pytest.approx(info["Overshoot"], abs=1e-9)


def test_times_change_smoothly():
    """A first-order response rises in ln 9 time constants and settles in ln 50, and a sample."""
    tau = 0.4
    response = 1.0 - np.exp(-TIME / tau)
    ours = flight_numbers(TIME, response[None], 1.0, NONE[:1])
    assert ours.rise_time[0] == pytest.approx(tau * np.log(9.0) + 1 / 128, abs=1e-4)
    assert ours.settling_time[0] == pytest.approx(tau * np.log(50.0) + 1 / 128, abs=1e-4)
    assert ours.overshoot[0] == 0.0


def test_the_error_is_against_the_command():
    ours = flight_numbers(TIME, 0.9 * RESPONSES[1:2], 1.0, NONE[:1])
    assert ours.steady_state_error[0] == pytest.approx(10.0, abs=0.01)


@pytest.mark.parametrize("broken", [np.full_like(TIME, np.nan), -RESPONSES[1], 0.0 * TIME])
def test_what_does_not_get_there_is_infinite(broken):
    rows = np.array([broken, RESPONSES[1]])
    ours = flight_numbers(TIME, rows, 1.0, np.array([False, False]))
    found = [getattr(ours, name) for name in SEARCHED_NUMBERS]
    assert all(np.isinf(values[0]) and np.isfinite(values[1]) for values in found)


def test_what_has_diverged_is_infinite():
    ours = flight_numbers(TIME, RESPONSES[:2], 1.0, np.array([True, False]))
    found = [getattr(ours, name) for name in SEARCHED_NUMBERS]
    assert all(np.isinf(values[0]) and np.isfinite(values[1]) for values in found)


def test_what_swings_on_settles_late():
    ours = flight_numbers(TIME, (1.0 + 0.1 * np.cos(9.0 * TIME))[None], 1.0, NONE[:1])
    assert ours.settling_time[0] > 11.0
