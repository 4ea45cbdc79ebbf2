"""Rotors around a plant: the closed form of a lag, and the load of their equations, turned."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import Linearize

from tests.dynamics.wrench import wrench_on
from workbench.dynamics.rigid_body import rotation
from workbench.dynamics.rotors import speed_slope
from workbench.systems.rotors import Rotors_

UP, DOWN = 0.0125, 0.025
BLEND = 3.0
"""Speed difference over which the two time constants blend [rad/s]."""
BEGIN = np.array([200.0, 1000.0, 300.0, 900.0])
COMMAND = np.array([1000.0, 200.0, 900.0, 300.0])
BODY = BodyIndex(1)


@pytest.fixture(scope="module")
def turning(description):
    """Four rotors that differ in their motor constant, with every effect that a rotor can have."""
    return tuple(
        dataclasses.replace(
            rotor,
            motor_constant=8e-6 + 1e-6 * index,
            time_constant_up=UP,
            time_constant_down=DOWN,
            max_rot_velocity=1100.0,
            inertia=6.5e-5,
            rotor_drag_coefficient=1e-4,
            rolling_moment_coefficient=2e-6,
            inflow_coefficient=3e-4,
            ground_effect_coefficient=1.5,
            propeller_radius=0.15,
        )
        for index, rotor in enumerate(description.rotors)
    )


@pytest.fixture
def rotors(turning):
    return Rotors_[float](rotors=turning, bodies=[BODY], carriers=[0] * len(turning))


def fixed(rotors, state, commands, speeds, wind=None):
    """Return a Context with inputs."""
    context = rotors.CreateDefaultContext()
    rotors.GetInputPort("state").FixValue(context, state)
    rotors.GetInputPort("commands").FixValue(context, commands)
    if wind is not None:
        rotors.GetInputPort("wind").FixValue(context, wind)
    context.SetContinuousState(speeds)
    return context


def wrench(rotors, context) -> np.ndarray:
    """Return moment about the body's origin and force in W (6)."""
    (force,) = rotors.GetOutputPort("spatial_forces").Eval(context)
    assert force.body_index == BODY
    assert force.p_BoBq_B.tolist() == [0.0, 0.0, 0.0]
    return np.array(force.F_Bq_W.get_coeffs())


def simulated(rotors, begin, command):
    simulator = Simulator(rotors)
    context = simulator.get_mutable_context()
    context.SetContinuousState(begin)
    rotors.GetInputPort("state").FixValue(context, [1.0, *[0.0] * 12])
    rotors.GetInputPort("commands").FixValue(context, command)
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    return simulator


def drawn(seed):
    rng = np.random.default_rng(seed)
    state = rng.normal(size=13) * 2.0
    state[6] = rng.uniform(0.05, 0.6)
    return state, rng.uniform(0, 1000, 4), rng.uniform(0, 1000, 4), rng.normal(size=3) * 5.0


@pytest.mark.parametrize(("time", "rotor_indices"), [(UP, (0, 2)), (DOWN, (1, 3))])
def test_63_percent_of_the_way_takes_one_time_constant(rotors, time, rotor_indices):
    """Within half of the blend, on a way of 600."""
    simulator = simulated(rotors, BEGIN, COMMAND)
    simulator.AdvanceTo(time)
    now = rotors.GetOutputPort("speeds").Eval(simulator.get_context())
    done = (now - BEGIN) / (COMMAND - BEGIN)
    for index in rotor_indices:
        assert done[index] == pytest.approx(1.0 - math.exp(-1.0), abs=BLEND / 2 / 600)


def test_commands_beyond_the_range_are_limited(rotors):
    simulator = simulated(rotors, BEGIN, [2000.0, -500.0, 1100.0, 0.0])
    simulator.AdvanceTo(1.0)
    now = rotors.GetOutputPort("speeds").Eval(simulator.get_context())
    assert now == pytest.approx([1100.0, 0.0, 1100.0, 0.0], abs=1e-6)


def test_static_thrust_is_k_times_squared_speed(rotors):
    context = fixed(rotors, [1.0, *[0.0] * 12], COMMAND, BEGIN)
    constants = np.array([8e-6, 9e-6, 10e-6, 11e-6])
    wanted = pytest.approx(constants * BEGIN**2)
    assert rotors.GetOutputPort("static_thrusts").Eval(context) == wanted
    assert rotors.GetOutputPort("speeds").Eval(context) == pytest.approx(BEGIN)


def test_in_equilibrium_the_rate_is_the_mean_of_both(rotors):
    simulator = simulated(rotors, BEGIN, BEGIN)
    linear = Linearize(
        rotors,
        simulator.get_context(),
        input_port_index=rotors.GetInputPort("commands").get_index(),
        output_port_index=rotors.GetOutputPort("speeds").get_index(),
    )
    mean = (1.0 / UP + 1.0 / DOWN) / 2.0
    assert linear.A() == pytest.approx(-mean * np.eye(4))
    assert linear.B() == pytest.approx(mean * np.eye(4))


def test_its_wrench_is_the_pure_one_turned(rotors, turning):
    for seed in range(20):
        state, commands, speeds, wind = drawn(seed)
        context = fixed(rotors, state, commands, speeds, wind)
        slopes = [speed_slope(*each) for each in zip(turning, commands, speeds, strict=True)]
        pure = wrench_on(turning, state, speeds, slopes, wind=wind)
        R = np.array(rotation(state[:4])).reshape(3, 3)
        wanted = [*(R @ pure[3:]), *(R @ pure[:3])]
        assert wrench(rotors, context) == pytest.approx(wanted, rel=1e-9, abs=1e-9)
        # what is along the axis of a rotor that alone turns is its thrust
        thrusts = [
            wrench_on([rotor], state, [speed], wind=wind)[:3] @ rotor.axis_B
            for rotor, speed in zip(turning, speeds, strict=True)
        ]
        assert rotors.GetOutputPort("thrusts").Eval(context) == pytest.approx(thrusts)


def test_a_share_is_that_of_thrust_and_a_stopped_rotor_runs_down(rotors):
    context = fixed(rotors, [1.0, *[0.0] * 5, 100.0, *[0.0] * 6], COMMAND, BEGIN)
    whole = rotors.GetOutputPort("thrusts").Eval(context).copy()
    context.get_mutable_numeric_parameter(0).SetFromVector([1.0, 0.5, 0.0, 1.0])
    now = rotors.GetOutputPort("thrusts").Eval(context)
    assert now == pytest.approx(whole * [1.0, 0.5, 1.0, 1.0])
    slopes = rotors.EvalTimeDerivatives(context).CopyToVector()
    assert slopes[0] > 0.0
    assert slopes[2] == pytest.approx(-BEGIN[2] / DOWN, rel=1e-3)


def test_without_a_wind_the_air_is_still(rotors):
    *given, _ = drawn(1)
    calm = wrench(rotors, fixed(rotors, *given, np.zeros(3)))
    assert wrench(rotors, fixed(rotors, *given)).tolist() == calm.tolist()


def test_a_sagging_battery_slows_rotors_and_compensation_undoes_it(rotors):
    """By hand: two thirds of the voltage under load, in a steady flight at one speed."""
    speeds, state = np.full(4, 500.0), [1.0, *[0.0] * 12]
    context = fixed(rotors, state, speeds, speeds)
    static = rotors.GetOutputPort("static_thrusts").Eval(context)
    drop = (0.9 - 2.0 / 3.0) / np.sum(static**1.5)
    for compensation, wanted in ((0.0, 2.0 / 3.0), (1.0, (2.0 / 3.0) / (2.0 / 3.0))):
        supply = [0.9, drop, compensation, 0.9]
        rotors.GetInputPort("supply").FixValue(context, supply)
        assert rotors.GetOutputPort("voltage").Eval(context)[0] == pytest.approx(2.0 / 3.0)
        slopes = rotors.EvalTimeDerivatives(context).CopyToVector()
        assert slopes == pytest.approx((wanted - 1.0) * 500.0 / DOWN, rel=1e-3, abs=1e-9)


def test_it_converts(rotors):
    twin = rotors.ToAutoDiffXd()
    context, mirror = fixed(rotors, *drawn(3)), twin.CreateDefaultContext()
    mirror.SetTimeStateAndParametersFrom(context)
    twin.FixInputPortsFrom(rotors, context, mirror)
    for name in ("thrusts", "static_thrusts", "speeds"):
        carried = twin.GetOutputPort(name).Eval(mirror)
        wanted = rotors.GetOutputPort(name).Eval(context)
        assert [value.value() for value in carried] == pytest.approx(wanted, rel=1e-12)
    (force,) = twin.GetOutputPort("spatial_forces").Eval(mirror)
    carried = [value.value() for value in force.F_Bq_W.get_coeffs()]
    assert carried == pytest.approx(wrench(rotors, context), rel=1e-12)
    slopes = twin.EvalTimeDerivatives(mirror).CopyToVector()
    wanted = rotors.EvalTimeDerivatives(context).CopyToVector()
    assert [value.value() for value in slopes] == pytest.approx(wanted, rel=1e-12)
