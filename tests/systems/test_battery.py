"""Oracle: a hover that lasts its duration; power that goes with thrust to the 3/2."""

import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.dynamics.rotors import loaded_voltage, power_share
from workbench.plant.vehicle import BatteryPack
from workbench.systems.battery import BATTERY_PERIOD_S, Battery

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
    assert charge_after(vehicle, seconds) == pytest.approx(
        left, abs=1.01 * BATTERY_PERIOD_S / DURATION
    )


def test_hover_ends_with_its_duration(vehicle):
    assert charge_after(vehicle, DURATION - 2 * BATTERY_PERIOD_S) > 0.0
    assert charge_after(vehicle, DURATION + 2 * BATTERY_PERIOD_S) == 0.0


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


def test_voltage_follows_charge_and_current(vehicle):
    """36 kC in 40 s of hover are 900 A, which take 0.9 V at 1 mOhm."""
    pack = BatteryPack(36e3, 1e-3, ((0.0, 9.0), (0.5, 11.1), (1.0, 12.6)))
    powered = dataclasses.replace(vehicle, battery=pack)
    battery = Battery(vehicle=powered, duration=DURATION)
    context = battery.CreateDefaultContext()
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    hover = constants * vehicle.hover_speeds**2
    for charge, voltage in ((1.0, 12.6), (0.5, 11.1), (0.25, 10.05), (0.0, 9.0)):
        context.SetDiscreteState([charge])
        supply = battery.GetOutputPort("supply").Eval(context)
        assert supply[0] == pytest.approx(voltage / 12.6)
        for part, current in ((1.0, 900.0), (2.0, 900.0 * 2.0**1.5)):
            power = sum(power_share(part * thrust) for thrust in hover)
            loaded = 12.6 * loaded_voltage(*supply[:2], power)
            assert loaded == pytest.approx(voltage - 1e-3 * current)
    assert loaded_voltage(*supply[:2], 1e9) == 0.0


def test_its_terminals_have_the_loaded_voltage_and_the_current(vehicle):
    """The same battery; the open circuit that the compensation takes is the known one."""
    pack = BatteryPack(36e3, 1e-3, ((0.0, 9.0), (0.5, 11.1), (1.0, 12.6)))
    powered = dataclasses.replace(vehicle, battery=pack)
    battery = Battery(vehicle=powered, duration=DURATION, compensation=0.7)
    context = battery.CreateDefaultContext()
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    hover = constants * vehicle.hover_speeds**2
    supply, terminals = battery.GetOutputPort("supply"), battery.GetOutputPort("terminals")
    for charge, voltage in ((1.0, 12.6), (0.25, 10.05)):
        context.SetDiscreteState([charge])
        for part, current in ((0.0, 0.0), (1.0, 900.0), (4.0, 7200.0)):
            battery.GetInputPort("thrusts").FixValue(context, part * hover)
            assert terminals.Eval(context) == pytest.approx([voltage - 1e-3 * current, current])
        assert supply.Eval(context)[2:] == pytest.approx([0.7, voltage / 12.6])
    battery.GetInputPort("open_circuit").FixValue(context, [0.9])
    assert supply.Eval(context)[[0, 3]] == pytest.approx([10.05 / 12.6, 0.9])
    battery.GetInputPort("thrusts").FixValue(context, 100.0 * hover)
    assert terminals.Eval(context)[0] == 0.0


def test_a_battery_without_a_voltage_takes_nothing_from_the_rotors(vehicle):
    battery = Battery(vehicle=vehicle, duration=DURATION)
    context = battery.CreateDefaultContext()
    context.SetDiscreteState([0.1])
    supply = battery.GetOutputPort("supply").Eval(context)
    assert loaded_voltage(*supply[:2], 1e9) == 1.0


def test_charge_never_falls_below_empty(vehicle):
    assert charge_after(vehicle, 10.0, share=20.0) == 0.0
