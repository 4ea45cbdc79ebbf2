"""Steps that were flown, against python-control."""

import control
import numpy as np
import pytest

from workbench.design.step_metrics import STEP_NUMBERS
from workbench.design.step_responses import step_responses

TIME = np.arange(0.0, 20.0, 0.005)
LOOP = control.tf([16.0], [1.0, 5.0, 16.0])


def flown(edges):
    """Return a command with edges, each (time, value), and what a linear loop makes of it."""
    command = np.zeros(len(TIME))
    for at, value in edges:
        command[at <= TIME] = value
    return command, control.forced_response(LOOP, TIME, command).outputs


def test_each_step_has_python_control_s_numbers():
    command, response = flown([(2.0, 1.5), (8.0, -0.5), (14.0, 0.0)])
    found = step_responses((TIME, command), (TIME, response))
    assert [each.begin for each in found] == pytest.approx([2.0, 8.0, 14.0])
    assert [each.amplitude for each in found] == [1.5, -2.0, 0.5]
    wanted = control.step_info(LOOP, T=np.arange(0.0, 6.0, 0.005))
    names = {"rise_time": "RiseTime", "settling_time": "SettlingTime", "overshoot": "Overshoot"}
    for each in found:
        for name, theirs in names.items():
            assert each.metrics.numbers[name] == pytest.approx(wanted[theirs], abs=0.011), name
        assert set(each.metrics.numbers) == set(STEP_NUMBERS)


def test_a_ramp_a_blink_and_the_end_are_no_steps():
    ramp = np.clip(TIME - 5.0, 0.0, 3.0)
    blink = np.where((TIME > 5.0) & (TIME < 5.1), 1.0, 0.0)
    late = np.where(TIME > 19.9, 1.0, 0.0)
    for command in (ramp, blink, late, 0.0 * TIME):
        assert step_responses((TIME, command), (TIME, 0.0 * TIME)) == []
