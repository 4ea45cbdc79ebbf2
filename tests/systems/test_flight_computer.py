"""Oracle: the pure update in plain Python, called with the same numbers."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.cascade import Gains
from workbench.systems.flight_computer import FlightComputer_
from workbench.systems.flight_law import control_update, law_constants
from workbench.systems.loop_points import closed_loops

PERIOD = 1 / 128
PORTS = ("state", "reference", "guidance")


@pytest.fixture
def computer(vehicle, gains):
    return FlightComputer_[float](vehicle=vehicle, gains=gains, period=PERIOD)


def pure(vehicle, inputs, gains, memory, shares=(1.0, 1.0, 1.0, 1.0)):
    thrusts, after = np.zeros(4), np.zeros(11)
    constants, estimate = law_constants(vehicle, PERIOD), sampled_estimate(PERIOD)
    loops = closed_loops()
    control_update(*inputs, gains, shares, constants, loops, estimate, memory, thrusts, after)
    return thrusts, after


def fix(computer, context, inputs):
    for name, signal in zip(PORTS, inputs, strict=True):
        computer.GetInputPort(name).FixValue(context, np.array(signal))


def drawn(rng, random_signals):
    """Return the three inputs and a memory."""
    state, _, reference, guide = random_signals(rng)
    memory = np.concatenate([rng.uniform(0, 1100, 8), rng.normal(size=3)])
    return (state, reference, guide), memory


def next_values(computer, context):
    after = computer.EvalUniquePeriodicDiscreteUpdate(context)
    return after.get_vector(0).CopyToVector(), after.get_vector(1).CopyToVector()


def test_its_update_is_the_pure_one_compiled(computer, vehicle, gains, random_signals):
    """Compiled code may contract a * b + c, so to rounding only."""
    context = computer.CreateDefaultContext()
    rng = np.random.default_rng(17)
    for _ in range(500):
        inputs, memory = drawn(rng, random_signals)
        fix(computer, context, inputs)
        context.SetDiscreteState(1, memory)
        thrusts, after = next_values(computer, context)
        wanted_thrusts, wanted_after = pure(vehicle, inputs, gains, memory)
        assert thrusts == pytest.approx(wanted_thrusts, rel=1e-8, abs=1e-9)
        assert after == pytest.approx(wanted_after, rel=1e-8, abs=1e-9)


def test_with_derivatives_it_gives_the_same_numbers(computer, random_signals):
    twin = computer.ToAutoDiffXd()
    context, mirror = computer.CreateDefaultContext(), twin.CreateDefaultContext()
    rng = np.random.default_rng(18)
    for _ in range(50):
        inputs, memory = drawn(rng, random_signals)
        fix(computer, context, inputs)
        context.SetDiscreteState(1, memory)
        mirror.SetTimeStateAndParametersFrom(context)
        twin.FixInputPortsFrom(computer, context, mirror)
        for plain, carried in zip(
            next_values(computer, context), next_values(twin, mirror), strict=True
        ):
            assert [x.value() for x in carried] == pytest.approx(plain, rel=1e-8, abs=1e-9)


def test_outputs_are_its_state_and_change_once_a_period(computer, random_signals):
    inputs, _ = drawn(np.random.default_rng(19), random_signals)
    simulator = Simulator(computer)
    context = simulator.get_mutable_context()
    fix(computer, context, inputs)
    computer.set_rotors(context, np.array([700.0] * 4), np.array(inputs[0][10:13]))
    seen = []
    for quarter in range(1, 13):
        simulator.AdvanceTo(quarter * PERIOD / 4)
        thrusts = computer.GetOutputPort("thrusts").Eval(context)
        assert thrusts.tolist() == context.get_discrete_state(0).value().tolist()
        memory = computer.GetOutputPort("memory").Eval(context)
        assert memory.tolist() == context.get_discrete_state(1).value().tolist()
        seen.append(tuple(thrusts))
    assert [len(set(seen[i : i + 4])) for i in (0, 4, 8)] == [1, 1, 1]
    assert len(set(seen)) == 3
    assert not computer.HasAnyDirectFeedthrough()


def test_set_rotors_turns_them_steadily(computer, vehicle):
    context = computer.CreateDefaultContext()
    speeds = np.array([100.0, 200.0, 300.0, 400.0])
    computer.set_rotors(context, speeds, np.array([1.0, 2.0, 3.0]))
    constants = [rotor.motor_constant for rotor in vehicle.rotors]
    assert computer.GetOutputPort("thrusts").Eval(context) == pytest.approx(constants * speeds**2)
    memory = computer.GetOutputPort("memory").Eval(context)
    assert memory.tolist() == [*speeds, *speeds, 1.0, 2.0, 3.0]


def test_gains_are_live_and_in_the_order_of_their_names(computer, vehicle, gains, random_signals):
    context = computer.CreateDefaultContext()
    inputs, memory = drawn(np.random.default_rng(20), random_signals)
    fix(computer, context, inputs)
    context.SetDiscreteState(1, memory)
    for index in range(len(Gains._fields)):
        changed = list(gains)
        changed[index] *= 0.9
        context.get_mutable_numeric_parameter(0).SetFromVector(changed)
        thrusts, _ = next_values(computer, context)
        wanted, _ = pure(vehicle, inputs, Gains(*changed), memory)
        assert thrusts == pytest.approx(wanted, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("shares", [[1.0, 0.5, 0.9, 1.0], [1.0, 1.0, 0.0, 0.3], [0.0] * 4])
def test_rotors_that_give_a_share_are_those_of_the_pure_update(
    computer, vehicle, gains, random_signals, shares
):
    """Compiled, and with derivatives."""
    twin = computer.ToAutoDiffXd()
    context, mirror = computer.CreateDefaultContext(), twin.CreateDefaultContext()
    context.get_mutable_numeric_parameter(1).SetFromVector(shares)
    rng = np.random.default_rng(22)
    for _ in range(30):
        inputs, memory = drawn(rng, random_signals)
        fix(computer, context, inputs)
        context.SetDiscreteState(1, memory)
        mirror.SetTimeStateAndParametersFrom(context)
        twin.FixInputPortsFrom(computer, context, mirror)
        wanted = pure(vehicle, inputs, gains, memory, shares)
        found = next_values(computer, context)
        carried = [[x.value() for x in values] for values in next_values(twin, mirror)]
        for values, plain, exact in zip(found, carried, wanted, strict=True):
            assert values == pytest.approx(exact, rel=1e-6, abs=1e-6)
            assert plain == pytest.approx(exact, rel=1e-6, abs=1e-6)


def test_all_rotors_are_whole_to_begin_with(computer):
    shares = computer.CreateDefaultContext().get_numeric_parameter(1)
    assert shares.value().tolist() == [1.0] * 4


def test_inputs_are_only_read(computer, random_signals):
    """Compiled code is handed Drake's own arrays."""
    context = computer.CreateDefaultContext()
    inputs, memory = drawn(np.random.default_rng(21), random_signals)
    fix(computer, context, inputs)
    context.SetDiscreteState(1, memory)
    gains = context.get_numeric_parameter(0).CopyToVector()
    next_values(computer, context)
    for name, signal in zip(PORTS, inputs, strict=True):
        assert computer.GetInputPort(name).Eval(context).tolist() == list(signal)
    assert context.get_discrete_state(1).value().tolist() == memory.tolist()
    assert context.get_numeric_parameter(0).CopyToVector().tolist() == gains.tolist()
