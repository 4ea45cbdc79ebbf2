"""Oracle: the pure update in plain Python, called with the same numbers."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import UNFILTERED_COMPUTER, flight_law
from workbench.control.guidance import LawSetpoint
from workbench.control.law_constants import law_constants
from workbench.control.law_signals import FILTER_STATE_COUNT
from workbench.plant.payload import Payload
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.flight_computer import FlightComputer

LAW = load_controller()
PERIOD = 1 / 128
PORTS = ("state", "reference", "guidance")


@pytest.fixture
def computer(vehicle, gains):
    return FlightComputer(controller=LAW, vehicle=vehicle, gains=gains._asdict(), period=PERIOD)


def pure(vehicle, inputs, gains, filtered):
    commands = np.zeros(4)
    constants, estimate = law_constants(vehicle), sampled_estimate(PERIOD)
    state, reference, guidance = inputs
    after, _ = flight_law(LAW).update(
        state,
        1.0,
        LawSetpoint(reference, guidance, [0.0] * 3),
        gains,
        constants,
        None,
        estimate,
        UNFILTERED_COMPUTER,
        filtered,
        LAW.initial_memory,
        commands,
    )
    return commands, np.array(after)


def fix(computer, context, inputs):
    for name, signal in zip(PORTS, inputs, strict=True):
        computer.GetInputPort(name).FixValue(context, np.array(signal))


def drawn(rng, random_signals):
    """Return the three inputs and what the stages before the law remember."""
    state, _, reference, guide = random_signals(rng)
    return (state, reference, guide), rng.normal(size=FILTER_STATE_COUNT)


def next_values(computer, context):
    after = computer.EvalUniquePeriodicDiscreteUpdate(context)
    return after.get_vector(0).CopyToVector(), after.get_vector(1).CopyToVector()


def test_its_update_is_the_pure_one_compiled(computer, vehicle, gains, random_signals):
    """Compiled code may contract a * b + c, so to rounding only."""
    context = computer.CreateDefaultContext()
    rng = np.random.default_rng(17)
    for _ in range(500):
        inputs, filtered = drawn(rng, random_signals)
        fix(computer, context, inputs)
        context.SetDiscreteState(1, filtered)
        for found, wanted in zip(
            next_values(computer, context), pure(vehicle, inputs, gains, filtered), strict=True
        ):
            assert found == pytest.approx(wanted, rel=1e-8, abs=1e-8)


def test_outputs_are_its_state_and_change_once_a_period(computer, random_signals):
    """What it remembers of the velocity changes them, while nothing else does."""
    (_, _, guide), _ = drawn(np.random.default_rng(19), random_signals)
    state = [1.0, *[0.0] * 5, 10.0, *[0.0] * 3, 0.1, -0.1, 0.05]
    inputs = (state, [0.0] * 8, [1.0, 1.0, *[0.0] * (len(guide) - 2)])
    simulator = Simulator(computer)
    context = simulator.get_mutable_context()
    fix(computer, context, inputs)
    computer.begin(context, np.array([700.0] * 4), np.zeros(3))
    seen = []
    for quarter in range(1, 13):
        simulator.AdvanceTo(quarter * PERIOD / 4)
        commands = computer.GetOutputPort("commands").Eval(context)
        assert commands.tolist() == context.get_discrete_state(0).value().tolist()
        seen.append(tuple(commands))
    assert [len(set(seen[i : i + 4])) for i in (0, 4, 8)] == [1, 1, 1]
    assert len(set(seen)) == 3
    assert not computer.HasAnyDirectFeedthrough()


def test_it_begins_with_commands_and_a_velocity(computer):
    context = computer.CreateDefaultContext()
    speeds = np.array([100.0, 200.0, 300.0, 400.0])
    computer.begin(context, speeds, np.array([1.0, 2.0, 3.0]))
    assert computer.GetOutputPort("commands").Eval(context).tolist() == speeds.tolist()
    at_rest = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 0.0]
    assert context.get_discrete_state(1).value().tolist() == at_rest


def test_gains_are_live_and_in_the_order_of_their_names(computer, vehicle, gains, random_signals):
    context = computer.CreateDefaultContext()
    inputs, filtered = drawn(np.random.default_rng(20), random_signals)
    fix(computer, context, inputs)
    context.SetDiscreteState(1, filtered)
    for index in range(len(gains)):
        changed = list(gains)
        changed[index] *= 0.9
        context.get_mutable_numeric_parameter(0).SetFromVector(changed)
        commands, _ = next_values(computer, context)
        wanted, _ = pure(vehicle, inputs, changed, filtered)
        assert commands == pytest.approx(wanted, rel=1e-8, abs=1e-9)


def test_inputs_are_only_read(computer, random_signals):
    """Compiled code is handed Drake's own arrays."""
    context = computer.CreateDefaultContext()
    inputs, filtered = drawn(np.random.default_rng(21), random_signals)
    fix(computer, context, inputs)
    context.SetDiscreteState(1, filtered)
    gains = context.get_numeric_parameter(0).CopyToVector()
    next_values(computer, context)
    for name, signal in zip(PORTS, inputs, strict=True):
        assert computer.GetInputPort(name).Eval(context).tolist() == list(signal)
    assert context.get_discrete_state(1).value().tolist() == filtered.tolist()
    assert context.get_numeric_parameter(0).CopyToVector().tolist() == gains.tolist()


HEAVY = '''"""Thrust for the weight."""

DESIGNED = ["mass"]


def design(vehicle, g, dt):
    return [vehicle.mass]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    return (9.81 * g.mass, 0.0, 0.0, 0.0), memory
'''


def test_a_payload_that_becomes_known_is_designed_for(vehicle, tmp_path):
    path = tmp_path / "heavy.py"
    path.write_text(HEAVY)
    law = load_controller(path)
    own = {row.name: row.default for row in law.parameters}
    computer = FlightComputer(controller=law, vehicle=vehicle, gains=own, period=PERIOD)
    context = computer.CreateDefaultContext()
    gains = context.get_numeric_parameter(0)
    assert gains.CopyToVector()[-1] == vehicle.mass
    payload = enumerate(Payload(0.4, 0.05, 0.02, -0.1, known_payload_mass=0.4))
    computer.set_parameters(context, [(computer.payload_index, *row) for row in payload])
    assert gains.CopyToVector()[-1] == pytest.approx(vehicle.mass + 0.4)


def test_the_state_says_that_a_program_has_ended(vehicle, gains, random_signals):
    """A Context that goes on from there flies on without it, whoever has seen the end."""
    inputs, _ = drawn(np.random.default_rng(3), random_signals)
    computer = FlightComputer(
        controller=replace(LAW, program=lambda *_: None),
        vehicle=vehicle,
        gains=gains._asdict(),
        period=PERIOD,
    )
    context = computer.CreateDefaultContext()
    fix(computer, context, inputs)
    runs, _ = next_values(computer, context)
    context.SetDiscreteState(context.num_discrete_state_groups() - 1, [1.0])
    ended, _ = next_values(computer, context)
    assert runs.any() and not ended.any()
