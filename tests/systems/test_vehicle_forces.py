"""Rotors and drag around a continuous plant: the closed form of a lag, and the pure wrench."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import Linearize

from workbench.dynamics.rigid_body import rotation
from workbench.dynamics.rotor_response import rotor_constants, speed_slope, step_rotor
from workbench.dynamics.vehicle_step import rotor_rows, vehicle_wrench
from workbench.systems.vehicle_forces import VehicleForces_

UP, DOWN = 0.0125, 0.025
PERIOD = 1 / 1024
BLEND = 3.0
"""Speed difference over which the two time constants blend [rad/s]."""
AREA, DENSITY = 0.2, 1.1
CENTRE = (0.01, -0.02, 0.03)
BEGIN = np.array([200.0, 1000.0, 300.0, 900.0])
COMMAND = np.array([1000.0, 200.0, 900.0, 300.0])


@pytest.fixture(scope="module")
def turning(description):
    """Four rotors that differ in their motor constant, with inertia."""
    rotors = tuple(
        dataclasses.replace(
            rotor,
            motor_constant=8e-6 + 1e-6 * index,
            time_constant_up=UP,
            time_constant_down=DOWN,
            max_rot_velocity=1100.0,
            inertia=6.5e-5,
        )
        for index, rotor in enumerate(description.rotors)
    )
    return dataclasses.replace(description, rotors=rotors)


@pytest.fixture
def forces(turning):
    return VehicleForces_[float](
        description=turning, p_BoBcm_B=CENTRE, drag_area=AREA, air_density=DENSITY
    )


def fixed(forces, state, commands, speeds, wind=None):
    """Return a Context with inputs."""
    context = forces.CreateDefaultContext()
    forces.GetInputPort("state").FixValue(context, state)
    forces.GetInputPort("commands").FixValue(context, commands)
    if wind is not None:
        forces.GetInputPort("wind").FixValue(context, wind)
    context.SetContinuousState(speeds)
    return context


def flying(forces, begin, command):
    simulator = Simulator(forces)
    context = simulator.get_mutable_context()
    context.SetContinuousState(begin)
    forces.GetInputPort("state").FixValue(context, [1.0, *[0.0] * 12])
    forces.GetInputPort("commands").FixValue(context, command)
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    return simulator


def drawn(seed):
    rng = np.random.default_rng(seed)
    speeds = rng.uniform(0, 1000, 4)
    return rng.normal(size=13) * 2.0, rng.uniform(0, 1000, 4), speeds, rng.normal(size=3) * 5.0


@pytest.mark.parametrize(("time", "rotor_indices"), [(UP, (0, 2)), (DOWN, (1, 3))])
def test_63_percent_of_the_way_takes_one_time_constant(forces, time, rotor_indices):
    """Within half of the blend, on a way of 600."""
    simulator = flying(forces, BEGIN, COMMAND)
    simulator.AdvanceTo(time)
    now = forces.GetOutputPort("speeds").Eval(simulator.get_context())
    done = (now - BEGIN) / (COMMAND - BEGIN)
    for index in rotor_indices:
        assert done[index] == pytest.approx(1.0 - math.exp(-1.0), abs=BLEND / 2 / 600)


def test_stepped_and_continuous_agree_at_the_samples(forces, turning):
    """Both from the same speeds with the same command, within the blend."""
    simulator = flying(forces, BEGIN, COMMAND)
    speeds = BEGIN
    for step in range(1, 80):
        simulator.AdvanceTo(step * PERIOD)
        speeds = [
            step_rotor(command, speed, rotor_constants(rotor, PERIOD))[2]
            for command, speed, rotor in zip(COMMAND, speeds, turning.rotors, strict=True)
        ]
        now = forces.GetOutputPort("speeds").Eval(simulator.get_context())
        assert speeds == pytest.approx(now, abs=BLEND / 2)


def test_thrust_is_k_times_squared_speed(forces):
    context = fixed(forces, [1.0, *[0.0] * 12], COMMAND, BEGIN)
    constants = np.array([8e-6, 9e-6, 10e-6, 11e-6])
    assert forces.GetOutputPort("thrusts").Eval(context) == pytest.approx(constants * BEGIN**2)
    assert forces.GetOutputPort("speeds").Eval(context) == pytest.approx(BEGIN)


def test_in_equilibrium_the_rate_is_the_mean_of_both(forces):
    simulator = flying(forces, BEGIN, BEGIN)
    linear = Linearize(
        forces,
        simulator.get_context(),
        input_port_index=forces.GetInputPort("commands").get_index(),
        output_port_index=forces.GetOutputPort("speeds").get_index(),
    )
    mean = (1.0 / UP + 1.0 / DOWN) / 2.0
    assert linear.A() == pytest.approx(-mean * np.eye(4))
    assert linear.B() == pytest.approx(mean * np.eye(4))


def test_its_forces_are_the_pure_ones_turned(forces, turning):
    rows = rotor_rows(turning.rotors, 0.0)
    for seed in range(20):
        state, commands, speeds, wind = drawn(seed)
        found = forces.GetOutputPort("forces").Eval(fixed(forces, state, commands, speeds, wind))
        slopes = [
            speed_slope(u, w, rotor_constants(rotor, 0.0))
            for u, w, rotor in zip(commands, speeds, turning.rotors, strict=True)
        ]
        R_WB = rotation(state[:4])
        motion = (R_WB, state[7:10], state[10:13], state[6])
        pressure = 0.5 * AREA * DENSITY
        wrench = vehicle_wrench(*motion, speeds, slopes, [1.0] * 4, wind, pressure, CENTRE, rows)
        R = np.array(R_WB).reshape(3, 3)
        wanted = [*(R @ wrench[3:]), *(R @ wrench[:3])]
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_without_a_wind_the_air_is_still(forces):
    *given, _ = drawn(1)
    calm = forces.GetOutputPort("forces").Eval(fixed(forces, *given, np.zeros(3)))
    assert forces.GetOutputPort("forces").Eval(fixed(forces, *given)).tolist() == calm.tolist()


def test_area_and_density_are_live(forces):
    context = fixed(forces, *drawn(2))
    port = forces.GetOutputPort("forces")
    before = port.Eval(context).copy()
    context.get_mutable_numeric_parameter(0).SetFromVector([2 * AREA, DENSITY, 0.0, 0.0])
    wider = port.Eval(context).copy()
    context.get_mutable_numeric_parameter(0).SetFromVector([AREA, 2 * DENSITY, 0.0, 0.0])
    assert np.abs(wider - before).max() > 0.1
    assert port.Eval(context) == pytest.approx(wider)


def test_it_converts(forces):
    twin = forces.ToAutoDiffXd()
    context, mirror = fixed(forces, *drawn(3)), twin.CreateDefaultContext()
    mirror.SetTimeStateAndParametersFrom(context)
    twin.FixInputPortsFrom(forces, context, mirror)
    for name in ("forces", "thrusts", "speeds"):
        carried = twin.GetOutputPort(name).Eval(mirror)
        wanted = forces.GetOutputPort(name).Eval(context)
        assert [value.value() for value in carried] == pytest.approx(wanted, rel=1e-12)
    slopes = twin.EvalTimeDerivatives(mirror).CopyToVector()
    wanted = forces.EvalTimeDerivatives(context).CopyToVector()
    assert [value.value() for value in slopes] == pytest.approx(wanted, rel=1e-12)
