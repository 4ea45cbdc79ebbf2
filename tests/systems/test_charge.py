"""The observer of the state of charge, against closed forms and scipy's roots."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from workbench.plant.vehicle import BatteryPack
from workbench.systems.battery import (
    CHARGE_SETTLING_TIME_S,
    ChargeGauge,
    charge_by_voltage,
    next_charge,
    open_circuit,
)

PACK = BatteryPack(900.0, 0.06, ((0.0, 9.6), (0.15, 10.9), (0.8, 11.9), (1.0, 12.6)))
LEVEL = BatteryPack(900.0, 0.06, ((0.0, 9.6), (0.3, 11.4), (0.7, 11.4), (1.0, 12.6)))
DT = 0.125


def discharge(pack, start, current, seconds, noise=0.0):
    """Return what is known and the true charge after each update of an even discharge."""
    draws = noise * np.random.default_rng(1).standard_normal(round(seconds / DT))
    curve = np.array(pack.open_circuit_voltage)
    known, true, found = start, 1.0, []
    for draw in draws:
        voltage = np.interp(true, curve[:, 0], curve[:, 1]) - pack.resistance * current
        known = next_charge(known, voltage + draw, current, pack, DT)
        true -= current * DT / pack.capacity
        found.append((known, true))
    return np.array(found).T


def test_the_charge_under_load_is_where_the_curve_has_the_voltage():
    for current in (0.0, 15.0, 60.0):
        for charge in (0.02, 0.15, 0.4, 0.85, 1.0):
            voltage = open_circuit(charge, PACK) - PACK.resistance * current
            root = brentq(
                lambda q, u=voltage, i=current: open_circuit(q, PACK) - u - 0.06 * i, 0, 1
            )
            assert charge_by_voltage(voltage, current, PACK, 0.5) == pytest.approx(root, abs=1e-9)
            assert root == pytest.approx(charge, abs=1e-9)
    assert charge_by_voltage(12.95, 0.0, PACK, 0.5) == pytest.approx(1.1)  # as the curve came
    assert charge_by_voltage(9.6 - 0.13, 0.0, PACK, 0.5) == pytest.approx(-0.015)


def test_where_the_curve_is_level_the_voltage_tells_a_range(case):
    for near, wanted in ((0.1, 0.3), (0.3, 0.3), (0.5, 0.5), (0.9, 0.7)):
        with case(near):
            assert charge_by_voltage(11.4, 0.0, LEVEL, near) == pytest.approx(wanted)
    known, true = discharge(LEVEL, 1.0, 15.0, 55.0)
    assert known == pytest.approx(true, abs=1e-9)


def test_an_error_at_the_start_falls_as_that_of_a_first_order(case):
    for start in (0.7, 0.9):
        with case(start):
            known, true = discharge(PACK, start, 3.0, 200.0)
            time = DT * np.arange(1, len(known) + 1)
            assert true == pytest.approx(1.0 - 3.0 * time / 900.0)
            wanted = (start - 1.0) * np.exp(-time / CHARGE_SETTLING_TIME_S)
            assert known - true == pytest.approx(wanted, abs=1e-9)


def test_noise_of_the_voltage_is_left_as_far_as_the_gain_lets_it():
    """Of white noise an observer of the gain g leaves the share g / (2 - g) of its variance."""
    known, true = discharge(PACK, 1.0, 0.2, 4400.0, noise=0.1)
    straight = (true > 0.3) & (true < 0.65)  # a deviation and more from where the slope changes
    slope = (11.9 - 10.9) / (0.8 - 0.15)
    gain = 1.0 - math.exp(-DT / CHARGE_SETTLING_TIME_S)
    wanted = 0.1 / slope * math.sqrt(gain / (2.0 - gain))
    assert 0.8 * wanted < (known - true)[straight].std() < 1.25 * wanted
    assert known[straight] == pytest.approx(true[straight], abs=0.01)


def test_the_gauge_tells_the_observer_a_noisy_voltage_and_the_law_the_loaded_one():
    """By hand: 11 V with half a deviation of 0.2 V, and 20 A at 0.06 Ohm, are 12.3 V at rest."""
    gauge = ChargeGauge(pack=PACK, voltage_noise=0.2)
    context = gauge.CreateDefaultContext()
    gauge.GetInputPort("terminals").FixValue(context, [11.0, 20.0])
    gauge.GetInputPort("noise").FixValue(context, [0.5])
    context.SetDiscreteState([0.9])
    told = 0.8 + 0.2 * (12.3 - 11.9) / (12.6 - 11.9)
    wanted = 0.9 - math.expm1(-DT / CHARGE_SETTLING_TIME_S) * (told - 0.9) - 20.0 * DT / 900.0
    (found,) = gauge.EvalUniquePeriodicDiscreteUpdate(context).get_vector(0).CopyToVector()
    assert found == pytest.approx(wanted, abs=1e-12)

    context.SetDiscreteState([0.4])
    rest = 10.9 + (0.4 - 0.15) / (0.8 - 0.15) * (11.9 - 10.9)
    assert gauge.GetOutputPort("open_circuit").Eval(context) == pytest.approx(rest / 12.6)
    voltage = gauge.GetOutputPort("voltage")
    assert voltage.Eval(context) == pytest.approx((rest - 0.06 * 20.0) / 12.6)
    gauge.GetInputPort("terminals").FixValue(context, [0.0, 1e4])
    assert voltage.Eval(context) == 0.0
