"""The setpoints of servos over control periods, counted by hand."""

import math

import pytest
from pydrake.systems.analysis import Simulator

from workbench.plant.servo import Servo
from workbench.systems.servo_commands import ServoCommands

PERIOD = 1 / 128
COMMANDS = (3.0, 3.0, -9.0, 0.2, 0.2, 0.2, 0.2)


def setpoints(servo: Servo) -> list[float]:
    """Return the setpoints of the periods in which a law gives `COMMANDS`."""
    system = ServoCommands(servos=[servo], commanded=[0], wanted=[], period=PERIOD)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    found = []
    for number, command in enumerate(COMMANDS):
        system.GetInputPort("commands").FixValue(context, [command])
        found.append(system.GetOutputPort("setpoints").Eval(context)[0])
        simulator.AdvanceTo((number + 1) * PERIOD)  # the update of the next period is still due
    return found


@pytest.mark.parametrize("periods", [0, 1, 3])
def test_a_setpoint_is_within_its_limits_however_late_it_comes(periods):
    servo = Servo(lower=-1.0, upper=0.5, start=0.1, delay=periods * PERIOD)
    within = [0.5, 0.5, -1.0, 0.2, 0.2, 0.2, 0.2]
    assert setpoints(servo) == pytest.approx(([0.1] * periods + within)[: len(within)])


def test_a_setpoint_goes_no_further_in_a_period_than_its_rate():
    servo = Servo(lower=-1.0, upper=0.5, max_rate=0.3 / PERIOD)
    assert setpoints(servo) == pytest.approx([0.3, 0.5, 0.2, 0.2, 0.2, 0.2, 0.2])


def test_a_low_pass_takes_its_share_of_a_step_in_a_period():
    share = 1.0 - math.exp(-0.5)
    servo = Servo(upper=2.0, time_constant=2.0 * PERIOD)
    found = setpoints(servo)
    assert found[:2] == pytest.approx([2.0 * share, 2.0 * share * (2.0 - share)])
