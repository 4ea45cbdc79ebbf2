"""What an action must not ask for, at its limits."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import Action, AttitudeSetpoint, Injection
from workbench.session.action_check import check_loops_free, check_place, check_take_off_height


def test_a_take_off_is_above_where_the_drone_stands_and_up_to_the_largest_height(case):
    for height in (0.2, 5.0, 30.0):
        check_take_off_height(height, 0.136, 30.0)
    for height in (0.1, 0.136, 30.1):
        with (
            case(height),
            pytest.raises(WorkbenchError, match="above 0.136 m, .* 30 m of max_heig"),
        ):
            check_take_off_height(height, 0.136, 30.0)
    check_place([0.0, 0.0, 0.136], 0.136)
    with pytest.raises(WorkbenchError, match="give it 0.136 m, at which the drone stands on"):
        check_place([9.0, 9.0, 0.13], 0.136)


def test_a_loop_is_measured_or_has_a_setpoint_and_each_may_be_ended():
    tilt, level = (
        Action(setpoint=each) for each in (AttitudeSetpoint(roll=0.1), AttitudeSetpoint())
    )
    measure = Action(injection=Injection("acceleration_x", 0.1, 2.0, 10.0))
    silence = Action(injection=Injection())
    for action, injecting, is_set in (
        (tilt, None, True),
        (tilt, 1.0, False),
        (level, 0.5, False),
        (measure, None, False),
        (silence, 0.5, True),
    ):
        check_loops_free(action, injecting, is_set)
    with pytest.raises(WorkbenchError, match="a loop is being measured"):
        check_loops_free(tilt, 0.5, False)
    with pytest.raises(WorkbenchError, match="a setpoint of attitude or rate is given"):
        check_loops_free(measure, None, True)
