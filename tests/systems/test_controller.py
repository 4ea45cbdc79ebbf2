"""Oracle: the pure law, called with the same numbers."""

import dataclasses

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import allocate, commanded_wrench, flight_law
from workbench.control.guidance import LIFT_FIELD, MOTORS_FIELD, LawSetpoint
from workbench.control.law_constants import law_constants
from workbench.plant.thrust_frame import thrust_frame
from workbench.systems.controller import DERIVATIVE_STEP_S, ContinuousController_

LAW = load_controller()
PORTS = ("state", "acceleration", "reference", "guidance")


@pytest.fixture
def controller(vehicle, gains):
    return ContinuousController_[float](controller=LAW, vehicle=vehicle, gains=list(gains))


def output(controller, context, signals) -> np.ndarray:
    for name, signal in zip(PORTS, signals, strict=True):
        controller.GetInputPort(name).FixValue(context, np.array(signal))
    return controller.GetOutputPort("commands").Eval(context)


def pure(vehicle, signals, gains) -> list[float]:
    commands = [0.0] * len(vehicle.rotors)
    constants = law_constants(vehicle)
    state, acceleration, reference, guidance = signals
    wrench = (0.0, 0.0, 0.0, 0.0)
    if guidance[LIFT_FIELD] > 0.0:
        setpoint, memory = LawSetpoint(reference, guidance, [0.0] * 3), LAW.initial_memory
        law = flight_law(LAW).wrench
        wrench, _ = law(
            state,
            acceleration,
            1.0,
            setpoint,
            gains,
            memory,
            [0.0] * 4,
            DERIVATIVE_STEP_S,
            constants,
            None,
        )
    allocate(wrench, guidance[LIFT_FIELD], guidance[MOTORS_FIELD], constants, commands)
    return commands


def test_its_output_is_the_pure_law(controller, vehicle, gains, random_signals):
    context = controller.CreateDefaultContext()
    rng = np.random.default_rng(13)
    for _ in range(100):
        signals = random_signals(rng)
        assert output(controller, context, signals) == pytest.approx(pure(vehicle, signals, gains))


def test_gains_are_live_and_in_the_order_of_their_names(controller, vehicle, gains, random_signals):
    context = controller.CreateDefaultContext()
    signals = random_signals(np.random.default_rng(14))
    output(controller, context, signals)
    for index in range(len(gains)):
        changed = list(gains)
        changed[index] *= 0.9
        context.get_mutable_numeric_parameter(0).SetFromVector(changed)
        found = output(controller, context, signals)
        assert found == pytest.approx(pure(vehicle, signals, type(gains)(*changed)))


def test_where_rotors_have_an_inertia_yaw_moments_wait_for_their_spin_up(
    vehicle, gains, random_signals
):
    """Its state is what it asks for, and follows what it wants by spin_up_time."""
    rotors = tuple(dataclasses.replace(rotor, inertia=6.5e-5) for rotor in vehicle.rotors)
    spinning = dataclasses.replace(vehicle, rotors=rotors)
    time = thrust_frame(spinning).spin_up_time
    assert time == pytest.approx(1 / 3.11, rel=0.01)  # four J / (2 k w moment_constant)
    reckoning = gains._replace(spin_up_feedforward=1.0)
    controller = ContinuousController_[float](
        controller=LAW, vehicle=spinning, gains=list(reckoning)
    )
    context = controller.CreateDefaultContext()
    signals = random_signals(np.random.default_rng(14))
    still = [1.0, *[0.0] * 5, 10.0, *[0.0] * 6]
    signals = (still, [0.0] * 3, [0, 0, 0, 0.1, 0, 0, 0, 0], [1.0, 1.0, 1.0, *signals[3][3:]])
    signals[3][3:9] = [0.0] * 6
    context.SetContinuousState([0.01])
    found = output(controller, context, signals)
    constants = law_constants(spinning)
    assert commanded_wrench(found, constants)[3] == pytest.approx(0.01)
    wanted = controller.wanted_yaw_moment(context)
    slope = controller.EvalTimeDerivatives(context).CopyToVector()
    assert slope == pytest.approx([(wanted - 0.01) / time])


def test_every_input_feeds_through(controller):
    for port in range(len(PORTS)):
        assert controller.HasDirectFeedthrough(port, 0)
    assert controller.num_input_ports() == len(PORTS)
    assert controller.num_continuous_states() == 1  # as the rotors have an inertia
    assert controller.num_discrete_state_groups() == 0


def test_with_derivatives_it_gives_the_same_numbers(controller, vehicle, gains, random_signals):
    twin = controller.ToAutoDiffXd()
    context = twin.CreateDefaultContext()
    rng = np.random.default_rng(15)
    for _ in range(50):
        signals = random_signals(rng)
        variables = InitializeAutoDiff(np.concatenate(signals)).ravel()
        parts = np.split(variables, np.cumsum([len(signal) for signal in signals])[:-1])
        found = [x.value() for x in output(twin, context, parts)]
        assert found == pytest.approx(pure(vehicle, signals, gains))


@pytest.mark.parametrize(("motors", "lift"), [(0.0, 0.0), (1.0, 0.0)])
def test_with_derivatives_it_also_stands_still_and_idles(
    controller, vehicle, gains, random_signals, motors, lift
):
    twin = controller.ToAutoDiffXd()
    signals = random_signals(np.random.default_rng(16))
    signals[3][:2] = [motors, lift]
    plain = output(controller, controller.CreateDefaultContext(), signals)
    found = output(twin, twin.CreateDefaultContext(), signals)
    assert [x.value() for x in found] == pytest.approx(plain)


def test_conversion_copies_the_gains(vehicle, gains):
    changed = gains._replace(kp_roll=77.0)
    twin = ContinuousController_[float](
        controller=LAW, vehicle=vehicle, gains=list(changed)
    ).ToAutoDiffXd()
    carried = twin.CreateDefaultContext().get_numeric_parameter(0).CopyToVector()
    assert [x.value() for x in carried] == list(changed)
