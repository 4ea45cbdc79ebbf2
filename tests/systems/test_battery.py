"""Oracle: a hover that lasts its duration; power that goes with thrust to the 3/2."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.systems.battery import PERIOD, Battery

DURATION = 40.0


def charge_after(vehicle, seconds, share=1.0, duration=DURATION):
    """Return the charge after flying with a share of the hover thrust."""
    battery = Battery(vehicle=vehicle, duration=DURATION)
    simulator = Simulator(battery)
    context = simulator.get_mutable_context()
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    battery.GetInputPort("thrusts").FixValue(context, share * constants * vehicle.hover_speeds**2)
    context.get_mutable_numeric_parameter(0).SetAtIndex(0, duration)
    simulator.AdvanceTo(seconds)
    return battery.GetOutputPort("charge").Eval(context)[0]


@pytest.mark.parametrize("seconds", [0.0, 10.0, 20.0, 39.0])
def test_hover_takes_charge_evenly_and_lasts_its_duration(vehicle, seconds):
    left = 1.0 - seconds / DURATION
    assert charge_after(vehicle, seconds) == pytest.approx(left, abs=1.01 * PERIOD / DURATION)


def test_hover_ends_with_its_duration(vehicle):
    assert charge_after(vehicle, DURATION - 2 * PERIOD) > 0.0
    assert charge_after(vehicle, DURATION + 2 * PERIOD) == 0.0


def test_power_goes_with_thrust_to_the_three_halves(vehicle):
    hover = 1.0 - charge_after(vehicle, 5.0)
    assert 1.0 - charge_after(vehicle, 5.0, share=2.0) == pytest.approx(2.0**1.5 * hover)
    assert 1.0 - charge_after(vehicle, 5.0, share=0.25) == pytest.approx(0.125 * hover)


def test_standing_costs_nothing(vehicle):
    assert charge_after(vehicle, 5.0, share=0.0) == 1.0


def test_duration_is_live(vehicle):
    assert 1.0 - charge_after(vehicle, 5.0, duration=80.0) == pytest.approx(
        0.5 * (1.0 - charge_after(vehicle, 5.0))
    )


def test_charge_never_falls_below_empty(vehicle):
    assert charge_after(vehicle, 10.0, share=20.0) == 0.0
