"""The IMU beside differences of a motion, and what it gives in a flight that tumbles."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from scipy.spatial.transform import Rotation

from workbench.control.controller_file import load_controller
from workbench.diagram.airframe import add_airframe
from workbench.dynamics.air.settings import calm_air
from workbench.estimation.gyro import GyroSettings
from workbench.estimation.imu import ideal_imu_sample, imu_noise, mean_force
from workbench.plant.faults import Fault
from workbench.plant.loading import make_vehicle
from workbench.plant.sensors import Imu, Noise
from workbench.scenario.scenario import Rates
from workbench.session.integration import Integration

G = np.array([0.0, 0.0, 9.81])
STEP = 1 / 1024
p_BS = np.array([0.05, -0.03, 0.08])
R_BS = Rotation.from_euler("xyz", [0.4, -0.2, 1.1])
TUMBLING = np.array([0.8, 0.3, -0.4, 0.3317, 0.0, 0.0, 3e3, 4.0, -7.0, 3.0, 1.0, 0.0, 0.0])
"""So high that it falls through the longest flight here: contact is slow to simulate."""
UNFILTERED = GyroSettings()
TUMBLING[:4] /= np.linalg.norm(TUMBLING[:4])


def sensor(gyro=None, accel=None, rate=250.0):
    """Return an IMU off the origin and turned, quiet or with noises of all its axes."""
    return Imu(
        name="imu",
        type="imu",
        frame="imu",
        link="base_link",
        rate=rate,
        p_BS=tuple(p_BS),
        R_BS=tuple(map(tuple, R_BS.as_matrix().tolist())),
        angular_velocity=(gyro or Noise(),) * 3,
        linear_acceleration=(accel or Noise(),) * 3,
    )


def tumble(description, vehicle, imu, steps=800, readout=8, gyro=UNFILTERED, seed=1, faults=()):
    """Return states (N, 13) and what the IMU gave (N, 9) at each reading of a tumbling flight.

    Args:
        faults: numbers of steps and the fault from there.
    """
    builder = DiagramBuilder()
    commands = builder.AddSystem(ConstantVectorSource([500.0, 700.0, 300.0, 600.0]))
    rates = Rates(physics_step=STEP, control_period=readout * STEP)
    values = load_controller().table.defaults() | calm_air(vehicle)._asdict() | gyro._asdict()
    airframe = add_airframe(
        builder,
        description.undrawn(),
        values,
        vehicle=make_vehicle(description),
        rates=rates,
        imu=imu,
    )
    builder.Connect(commands.get_output_port(), airframe.commands)
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    context = airframe.imu.GetMyMutableContextFromRoot(root)
    airframe.place(root, TUMBLING, np.full(4, 600.0))
    airframe.imu.set_seed(context, seed)
    integration = Integration(simulator, airframe, rates)
    states, given = [], []
    for step in range(0, steps + 1, readout):
        if step:  # asked for no time, Drake would do the first update
            integration.advance(step)
        for begin, fault in faults:
            if begin == step:
                context.get_mutable_numeric_parameter(airframe.imu.fault_index).SetAtIndex(0, fault)
        states.append(airframe.body_state(root))
        given.append(airframe.imu.GetOutputPort("imu").Eval(context).copy())
    return np.array(states), np.array(given)


def attitude(states):
    return Rotation.from_quat(states[..., :4], scalar_first=True)


def test_a_perfect_one_shows_what_differences_of_a_motion_say():
    def R(t):
        return Rotation.from_euler("zyx", [0.3 + 2 * t, np.sin(3 * t), 0.4 - t + t**2])

    def p(t):
        return np.array([np.sin(2 * t), t**3, 1.0 - t**2])

    def slope(function, t, h=1e-3):
        near, far = function(t + h) - function(t - h), function(t + 2 * h) - function(t - 2 * h)
        return (8 * near - far) / (12 * h)

    def w(t, h=1e-3):  # in W
        near = (R(t + h) * R(t - h).inv()).as_rotvec()
        return (8 * near - (R(t + 2 * h) * R(t - 2 * h).inv()).as_rotvec()) / (12 * h)

    def curve(function, t, h=1e-3):
        near, far = function(t + h) + function(t - h), function(t + 2 * h) + function(t - 2 * h)
        return (16 * near - far - 30 * function(t)) / (12 * h * h)

    for t in np.linspace(-0.5, 0.5, 7):
        state = [*R(t).as_quat(scalar_first=True), *p(t), *w(t), *slope(p, t)]
        found = ideal_imu_sample(state, [*slope(w, t), *curve(p, t)], p_BS)
        a_S = curve(lambda s: p(s) + R(s).apply(p_BS), t)
        assert found[:3] == pytest.approx(R(t).inv().apply(w(t)), abs=1e-9)
        assert found[3:] == pytest.approx(R(t).inv().apply(a_S + G), abs=1e-7)


def velocity(state):
    """Return the velocity of the IMU in W."""
    return state[10:13] + np.cross(state[7:10], attitude(state).apply(p_BS))


def test_means_of_a_period_integrate_to_the_motion(case, description, vehicle):
    """As estimators integrate them, over 0.78 s at 12 rad/s and more.

    What is left is of second order in the period: within it, they hold the means.
    """
    for readout, turn, push in (
        (1, 1e-5, 2e-5),
        (4, 2e-4, 5e-4),
        (8, 5e-4, 2e-3),
        (16, 2e-3, 8e-3),
    ):
        with case(readout):
            states, given = tumble(description, vehicle, sensor(), readout=readout)
            R, v = attitude(states[0]), velocity(states[0])
            dt = readout * STEP
            for w, f in zip(given[1:, :3], given[1:, 3:6], strict=True):
                v = v + dt * ((R * Rotation.from_rotvec(dt / 2 * w)).apply(f) - G)
                R = R * Rotation.from_rotvec(dt * w)
            assert (R.inv() * attitude(states[-1])).magnitude() < turn
            assert np.linalg.norm(v - velocity(states[-1])) < push
            assert np.linalg.norm(velocity(states[-1]) - velocity(states[0])) > 5.0


def added(description, vehicle, imu, steps, **how):
    """Return what noise and biases add to readings (N, 9): beside a quiet one of that flight."""
    _, quiet = tumble(description, vehicle, sensor(), steps, **how)
    _, loud = tumble(description, vehicle, imu, steps, **how)
    return loud - quiet


@pytest.mark.slow
def test_noise_keeps_its_density_at_any_rate_of_samples(case, description, vehicle):
    imu = sensor(Noise(stddev=0.02), Noise(stddev=0.3), rate=250.0)
    densities = np.array([0.02, 0.3]) / 250**0.5
    for rate in (0.0, 512.0, 128.0):
        with case(rate):
            gyro = UNFILTERED._replace(gyro_rate=rate)
            noise = added(description, vehicle, imu, 8192, gyro=gyro)[1:]
            # means of a gyro's period share the samples at its ends: sums of many forget that
            sums = noise[:, :6].reshape(-1, 16, 2, 3).mean(axis=1)
            expected = densities / (16 * 8 * STEP) ** 0.5
            assert np.sqrt((sums**2).mean(axis=(0, 2))) == pytest.approx(expected, rel=0.15)
            sampled = 0.02 * ((rate or 1024.0) / 250.0) ** 0.5
            assert noise[:, 6:].std(axis=0) == pytest.approx(sampled, rel=0.06)
            assert np.abs(noise.mean(axis=0)).max() < 0.02


def test_biases_are_drawn_once_a_flight(description, vehicle):
    noise = Noise(mean=0.3, bias_mean=0.1, bias_stddev=0.05)
    found = []
    for seed in range(24):
        each = added(description, vehicle, sensor(noise, noise), 24, seed=seed)
        assert each == pytest.approx(np.tile(each[0], (len(each), 1)), abs=1e-9)
        found.append(np.concatenate([R_BS.inv().apply(part) for part in each[0, :6].reshape(2, 3)]))
    assert np.mean(found, axis=0) == pytest.approx(0.4, abs=0.04)
    assert np.std(found) == pytest.approx(0.05, rel=0.15)


@pytest.mark.slow
def test_biases_drift_as_far_and_as_fast_as_described(description, vehicle):
    drift = Noise(dynamic_bias_stddev=0.2, dynamic_bias_correlation_time=0.0625)
    noise = added(description, vehicle, sensor(drift, drift), 16384)[50:, :6]
    assert np.sqrt((noise**2).mean()) == pytest.approx(0.2 * (0.0625 / 2) ** 0.5, rel=0.08)
    later = (noise[8:] * noise[:-8]).mean() / (noise**2).mean()  # a correlation time later
    assert later == pytest.approx(np.exp(-1.0), abs=0.08)


def test_what_fails_stands_still_or_is_louder_and_comes_back(case, description, vehicle):
    imu = sensor(Noise(stddev=0.02), Noise(stddev=0.3))
    for fault in (Fault.FROZEN, Fault.SILENT):
        with case(fault):
            faults = ((512, fault), (768, 0.0))
            _, given = tumble(description, vehicle, imu, 1024, faults=faults)
            stood = given[65:96]  # the reading at the fault has samples from before
            assert (stood == stood[0]).all()
            assert (given[64, 6:9] == stood[0, 6:9]).all()
            assert np.abs(np.diff(given[:64], axis=0)).min() > 0.0
            assert np.abs(np.diff(given[96:], axis=0)).min() > 0.0
    with case(Fault.NOISY):
        usual = added(description, vehicle, imu, 512)
        loud = added(description, vehicle, imu, 512, faults=((0, Fault.NOISY),))
        assert np.abs(usual).min() > 0.0
        assert loud == pytest.approx(10 * usual, abs=1e-9)


def test_a_mean_force_is_the_change_of_velocity_against_gravity_between_the_attitudes():
    """Half-way between two rolls, for a change along each axis; at rest it is 1 g up."""
    period, change = 0.01, np.array([0.03, -0.02, 0.05])
    rolls = (0.2, 0.5)
    q = [[math.cos(0.5 * roll), math.sin(0.5 * roll), 0.0, 0.0] for roll in rolls]
    found = mean_force([*q[0], 1.0, 2.0, 3.0], [*q[1], *([1.0, 2.0, 3.0] + change)], period)
    cos, sin = math.cos(0.35), math.sin(0.35)
    R_BW = np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]])
    assert found == pytest.approx(R_BW @ (change / period + [0.0, 0.0, 9.81]), rel=1e-3)
    level = [1.0, 0.0, 0.0, 0.0, 4.0, 5.0, 6.0]
    assert mean_force(level, level, period) == pytest.approx((0.0, 0.0, 9.81), rel=1e-3)


def test_the_noise_of_a_described_rate_has_its_density_at_that_of_physics(vehicle, case):
    """White noise: the deviation grows with the root of the rate; offset and bias stay."""
    (sensor,) = vehicle.body_imus
    for rate in (100.0, 1024.0):
        noise = Noise(mean=0.1, stddev=0.02, bias_mean=0.3, bias_stddev=0.4)
        described = dataclasses.replace(
            sensor, rate=rate, angular_velocity=(noise,) * 3, linear_acceleration=(noise,) * 3
        )
        found = imu_noise(described, STEP, 1 / 128)
        with case(rate):
            assert found.deviation == pytest.approx([0.02 * math.sqrt(1024.0 / rate)] * 6)
            assert found.mean == pytest.approx([0.4] * 6)
            assert found.spread == (0.4,) * 6
