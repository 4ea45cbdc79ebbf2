"""Oracles: the closed form of a first-order lag, and Drake's linear model of it."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import Linearize

from workbench.systems.rotor_lag import HeldRotors, make_continuous_lag

UP, DOWN = 0.0125, 0.025
PERIOD = 1 / 1024
BLEND = 3.0
"""Speed difference over which the two time constants blend [rad/s]."""
LIMIT = 1100.0


@pytest.fixture
def rotors(vehicle):
    """Four rotors that differ in their motor constant."""
    return tuple(
        dataclasses.replace(
            rotor,
            motor_constant=8e-6 + 1e-6 * index,
            time_constant_up=UP,
            time_constant_down=DOWN,
            max_rot_velocity=LIMIT,
        )
        for index, rotor in enumerate(vehicle.rotors)
    )


def continuous(rotors, begin, command):
    lag = make_continuous_lag(rotors)
    simulator = Simulator(lag)
    context = simulator.get_mutable_context()
    context.SetContinuousState(begin)
    lag.GetInputPort("commands").FixValue(context, command)
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    return lag, simulator


def held(rotors, begin, command):
    lag = HeldRotors(rotors=rotors, period=PERIOD)
    simulator = Simulator(lag)
    context = simulator.get_mutable_context()
    lag.set_rotors(context, np.array(begin))
    lag.GetInputPort("commands").FixValue(context, command)
    return lag, simulator


def way_done(simulator, read, begin, command, time):
    """Return the share of the way to the command that each rotor has done by a time."""
    simulator.AdvanceTo(time)
    return (read(simulator.get_context()) - begin) / (np.array(command) - begin)


BEGIN = np.array([200.0, 1000.0, 300.0, 900.0])
COMMAND = np.array([1000.0, 200.0, 900.0, 300.0])


@pytest.mark.parametrize(("time", "rotor_indices"), [(UP, (0, 2)), (DOWN, (1, 3))])
def test_continuous_63_percent_of_the_way_takes_one_time_constant(rotors, time, rotor_indices):
    """Within half of the blend, on a way of 600."""
    lag, simulator = continuous(rotors, BEGIN, COMMAND)
    done = way_done(simulator, lag.GetOutputPort("speeds").Eval, BEGIN, COMMAND, time)
    for index in rotor_indices:
        assert done[index] == pytest.approx(1.0 - math.exp(-1.0), abs=BLEND / 2 / 600)


def test_held_and_continuous_agree_at_the_samples(rotors):
    """Both from the same speeds with the same command, within the blend."""
    lag, simulator = continuous(rotors, BEGIN, COMMAND)
    twin, sampled = held(rotors, BEGIN, COMMAND)
    for step in range(1, 80):
        simulator.AdvanceTo(step * PERIOD)
        sampled.AdvanceTo((step - 0.5) * PERIOD)  # the update at a sample steps to the next one
        ahead = twin.GetOutputPort("memory").Eval(sampled.get_context())[:4]
        now = lag.GetOutputPort("speeds").Eval(simulator.get_context())
        assert ahead == pytest.approx(now, abs=BLEND / 2)


def test_continuous_thrust_is_k_times_squared_speed(rotors):
    lag, simulator = continuous(rotors, BEGIN, COMMAND)
    context = simulator.get_context()
    constants = np.array([8e-6, 9e-6, 10e-6, 11e-6])
    assert lag.GetOutputPort("thrusts").Eval(context) == pytest.approx(constants * BEGIN**2)
    assert lag.GetOutputPort("speeds").Eval(context) == pytest.approx(BEGIN)


def test_in_equilibrium_the_rate_is_the_mean_of_both(rotors):
    lag, simulator = continuous(rotors, BEGIN, BEGIN)
    context = simulator.get_context()
    linear = Linearize(lag, context, output_port_index=lag.GetOutputPort("speeds").get_index())
    mean = (1.0 / UP + 1.0 / DOWN) / 2.0
    assert linear.A() == pytest.approx(-mean * np.eye(4))
    assert linear.B() == pytest.approx(mean * np.eye(4))


def test_commands_are_held_to_the_rotors_limits(rotors):
    lag, simulator = held(rotors, BEGIN, [5000.0, -300.0, LIMIT, 0.0])
    simulator.AdvanceTo(1.0)
    memory = lag.GetOutputPort("memory").Eval(simulator.get_context())
    wanted = [LIMIT, 0.0, LIMIT, 0.0]
    assert memory[4:8] == pytest.approx(wanted)
    assert memory[0:4] == pytest.approx(wanted, abs=1e-6)


def test_a_held_rotor_begins_steadily_where_it_is_set(rotors):
    lag, simulator = held(rotors, BEGIN, BEGIN)
    constants = np.array([8e-6, 9e-6, 10e-6, 11e-6])
    for time in (0.0, 0.1):
        simulator.AdvanceTo(time)
        context = simulator.get_context()
        assert lag.GetOutputPort("thrusts").Eval(context) == pytest.approx(constants * BEGIN**2)
        memory = lag.GetOutputPort("memory").Eval(context)
        assert memory == pytest.approx(np.concatenate([BEGIN, BEGIN]))


def test_no_output_of_held_rotors_follows_the_command_directly(rotors):
    assert not HeldRotors(rotors=rotors, period=PERIOD).HasAnyDirectFeedthrough()
