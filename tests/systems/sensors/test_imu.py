"""Oracle: Drake's Accelerometer and Gyroscope beside it on the shipped drone; hand calculation."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from pydrake.systems.sensors import Accelerometer, Gyroscope

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.gravity import GRAVITY
from workbench.plant.multibody import add_plant
from workbench.plant.sensors import NO_NOISE, Imu, Noise
from workbench.systems.sensors import noisy_sensor as module
from workbench.systems.sensors.noisy_sensor import first_memory, next_memory, noisy
from workbench.systems.sensors.readings import ImuReading

PERIOD = 5 / 1024
WALKING = Noise(0.01, 0.02, 0.1, 0.05, 2e-3, 400.0, 0.0)
UPRIGHT = [1.0, *[0.0] * 12]
STILL = [0.0] * 6


@pytest.fixture
def imu(record):
    def make(gyroscope=NO_NOISE, accelerometer=NO_NOISE, period=PERIOD, latency=0.0, **place):
        sensor = Imu(**record(**place), angular_velocity=(gyroscope,) * 3)
        sensor = Imu(**{**vars(sensor), "linear_acceleration": (accelerometer,) * 3})
        return module.NoisySensor(
            module.imu_instrument(sensor, period), period=period, latency=latency
        )

    return make


@dataclass
class Beside:
    """Ours and Drake's, of one mounting."""

    X_BS: RigidTransform
    ours: module.NoisySensor
    accelerometer: Accelerometer
    gyroscope: Gyroscope


def random_mounting(rng):
    return RigidTransform(
        RotationMatrix(Quaternion(unit(rng.normal(size=4)))), rng.uniform(-1, 1, 3)
    )


def unit(q):
    return q / np.linalg.norm(q)


@pytest.fixture
def flying(description, vehicle, imu):
    """Return the drone under a constant load, with pairs of sensors of random mountings."""

    def make(rng, time_step):
        builder = DiagramBuilder()
        plant, _ = add_plant(builder, description, time_step=time_step)
        load = [*rng.uniform(-0.3, 0.3, 3), *rng.uniform(2.0, 20.0, 3)]
        forces = builder.AddSystem(ConstantVectorSource(load))
        builder.Connect(forces.get_output_port(), plant.get_applied_generalized_force_input_port())
        body = plant.GetBodyByName(vehicle.base_link)
        gravity = plant.gravity_field().gravity_vector()
        pairs = []
        for _ in range(6):
            X_BS = random_mounting(rng)
            pair = Beside(
                X_BS,
                imu(p_BS=X_BS.translation(), R_BS=X_BS.rotation().matrix()),
                Accelerometer(body, X_BS, gravity),
                Gyroscope(body, X_BS),
            )
            for system in (pair.ours, pair.accelerometer, pair.gyroscope):
                builder.AddSystem(system)
            poses, velocities = (
                plant.get_body_poses_output_port(),
                plant.get_body_spatial_velocities_output_port(),
            )
            for drakes in (pair.accelerometer, pair.gyroscope):
                builder.Connect(poses, drakes.get_body_poses_input_port())
                builder.Connect(velocities, drakes.get_body_velocities_input_port())
            builder.Connect(
                plant.get_body_spatial_accelerations_output_port(),
                pair.accelerometer.get_body_accelerations_input_port(),
            )
            builder.Connect(plant.get_state_output_port(), pair.ours.GetInputPort("state"))
            builder.Connect(
                plant.get_generalized_acceleration_output_port(),
                pair.ours.GetInputPort("acceleration"),
            )
            noise = builder.AddSystem(ConstantVectorSource(np.zeros(18)))
            builder.Connect(noise.get_output_port(), pair.ours.GetInputPort("noise"))
            pairs.append(pair)
        simulator = Simulator(builder.Build())
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        state = [*unit(rng.normal(size=4)), *rng.uniform(5, 9, 3), *rng.uniform(-12, 12, 6)]
        state[6] += 30.0  # a ground that is hit takes the continuous plant seconds to integrate
        plant.SetPositionsAndVelocities(context, state)
        return simulator, plant, pairs

    return make


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("time_step", [0.0, 1 / 1024])
def test_it_agrees_with_drake_with_any_mounting_in_a_violent_flight(flying, seed, time_step):
    simulator, plant, pairs = flying(np.random.default_rng(seed), time_step)
    root = simulator.get_mutable_context()
    rows = []
    for step in range(1, 40):
        simulator.AdvanceTo(step * 11 / 1024)
        poses = plant.get_body_poses_output_port()
        X_WB = poses.Eval(plant.GetMyContextFromRoot(root))[
            plant.GetBodyByName("base_link").index()
        ]
        for pair in pairs:
            ours = pair.ours.truth_output.Eval(pair.ours.GetMyContextFromRoot(root))
            accelerometer = pair.accelerometer.GetMyContextFromRoot(root)
            gyroscope = pair.gyroscope.GetMyContextFromRoot(root)
            drakes = np.concatenate(
                [
                    pair.accelerometer.get_measurement_output_port().Eval(accelerometer),
                    pair.gyroscope.get_measurement_output_port().Eval(gyroscope),
                ]
            )
            assert ours[:6] == pytest.approx(drakes, rel=0, abs=1e-9)
            R_WS = RotationMatrix(Quaternion(ours[6:])).matrix()
            wanted = (X_WB.rotation() @ pair.X_BS.rotation()).matrix()
            assert pytest.approx(wanted, rel=0, abs=1e-9) == R_WS
        rows.append(ours[:6])
    assert np.linalg.norm(rows, axis=0).min() > 1.0
    assert np.linalg.norm(np.array(rows)[:, 3:], axis=1).min() > 5.0
    assert np.ptp(rows, axis=0)[:3].max() > 3.0


def test_samples_of_a_flight_are_drakes_at_the_samples_time(flying):
    simulator, _, pairs = flying(np.random.default_rng(7), 1 / 1024)
    root = simulator.get_mutable_context()
    pair = pairs[0]
    for k in range(1, 20):
        simulator.AdvanceTo(k * PERIOD)
        before = pair.accelerometer.get_measurement_output_port().Eval(
            pair.accelerometer.GetMyContextFromRoot(root)
        )
        simulator.AdvanceTo((k + 0.9) * PERIOD)
        reading = pair.ours.reading(pair.ours.GetMyContextFromRoot(root))
        assert reading.stamp == k * PERIOD
        assert reading.specific_force == pytest.approx(before, rel=0, abs=1e-9)


def test_at_rest_it_measures_g_upwards(bench, imu):
    found = bench(imu(p_BS=(0.3, 0.2, 0.1)), state=UPRIGHT, acceleration=STILL)
    found.settle()
    reading = found.reading()
    assert reading.specific_force == (0.0, 0.0, GRAVITY)
    assert reading.angular_velocity == (0.0, 0.0, 0.0)
    assert reading.q_WS == (1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_at_rest_upwards_is_upwards_in_the_sensor_whatever_its_attitude(bench, imu, seed):
    rng = np.random.default_rng(seed)
    q_WB, X_BS = unit(rng.normal(size=4)), random_mounting(rng)
    R_WS = RotationMatrix(Quaternion(q_WB)).matrix() @ X_BS.rotation().matrix()
    found = bench(
        imu(p_BS=X_BS.translation(), R_BS=X_BS.rotation().matrix()),
        state=[*q_WB, *[0.0] * 9],
        acceleration=STILL,
    )
    found.settle()
    assert found.reading().specific_force == pytest.approx(R_WS[2] * GRAVITY, abs=1e-12)


def test_in_free_fall_it_measures_nothing(bench, imu):
    q_WB = unit(np.array([0.3, -0.5, 0.2, 0.9]))
    state = [*q_WB, 1.0, 2.0, 30.0, 0.0, 0.0, 0.0, 3.0, 2.0, -9.0]
    found = bench(imu(p_BS=(0.3, 0.2, 0.1)), state=state, acceleration=[0, 0, 0, 0, 0, -GRAVITY])
    found.settle()
    assert found.reading().specific_force == pytest.approx((0.0, 0.0, 0.0), abs=1e-14)


def test_a_turn_pulls_outwards_and_a_spin_up_along(bench, imu):
    """Turning about z at 3 rad/s and 5 rad/s², 0.2 m in front of the centre."""
    state = [*UPRIGHT[:9], 3.0, 0.0, 0.0, 0.0]
    found = bench(imu(p_BS=(0.2, 0.0, 0.0)), state=state, acceleration=[0, 0, 5, 0, 0, 0])
    found.settle()
    reading = found.reading()
    assert reading.specific_force == pytest.approx((-9 * 0.2, 5 * 0.2, GRAVITY), abs=1e-12)
    assert reading.angular_velocity == pytest.approx((0.0, 0.0, 3.0), abs=1e-12)


def test_a_quaternion_of_another_length_is_the_same_attitude(bench, imu):
    q_WB = unit(np.array([0.3, -0.5, 0.2, 0.9]))
    rows = []
    for length in (1.0, 1.01):
        state = [*(length * q_WB), *[0.0] * 3, 1.0, 2.0, 3.0, *[0.0] * 3]
        found = bench(imu(p_BS=(0.3, 0.2, 0.1)), state=state, acceleration=STILL)
        found.settle()
        rows.append(found.measurement())
    assert rows[0] == pytest.approx(rows[1], abs=1e-13)


def test_a_sensor_that_looks_down_has_its_x_downwards(bench, imu):
    R_BS = RollPitchYaw(0.0, math.pi / 2, 0.0).ToRotationMatrix().matrix()
    found = bench(imu(R_BS=R_BS), state=UPRIGHT, acceleration=STILL)
    found.settle()
    assert found.reading().specific_force == pytest.approx((-GRAVITY, 0.0, 0.0), abs=1e-12)


def test_there_is_no_reading_before_the_first_sample(bench, imu):
    found = bench(imu(latency=PERIOD), state=UPRIGHT, acceleration=STILL)
    assert found.reading() is None
    found.run(0.9 * PERIOD)
    assert found.reading() is None
    found.run(1.1 * PERIOD)
    assert isinstance(found.reading(), ImuReading)
    assert (found.reading().stamp, found.reading().frame) == (0.0, "it_link")


def test_noise_is_on_force_and_rate_and_not_on_the_attitude(bench, imu):
    """Its deviations are of 50 samples a second; at 204.8 the density is kept."""
    noises = (Noise(stddev=0.002), Noise(stddev=0.03))
    found = bench(imu(*noises, rate=50.0), state=UPRIGHT, acceleration=STILL)
    rows = found.measurements(2000)[:, 1:]
    wanted = math.sqrt(204.8 / 50.0) * np.array([0.03] * 3 + [0.002] * 3)
    assert np.std(rows[:, :6], axis=0) == pytest.approx(wanted, rel=0.06)
    assert np.mean(rows[:, :6], axis=0) == pytest.approx([0, 0, GRAVITY, 0, 0, 0], abs=0.006)
    assert (rows[:, 6:] == [1.0, 0.0, 0.0, 0.0]).all()
    assert np.corrcoef(rows[:, :6].T) == pytest.approx(np.eye(6), abs=0.08)


@pytest.mark.parametrize(("rate", "factor"), [(50.0, 2.0), (200.0, 1.0), (0.0, 1.0)])
def test_the_density_of_noise_is_kept_at_another_rate(rate, factor):
    noise = Noise(0.1, 0.03, 0.2, 0.3, 0.4, 5.0, 0.01).at_rate(rate, 200.0)
    assert noise == Noise(0.1, 0.03 * factor, 0.2, 0.3, 0.4, 5.0, 0.01)


def test_samples_are_what_the_noise_model_makes_of_the_draws_to_the_bit(bench, imu):
    found = bench(imu(WALKING, WALKING), seed=3, state=UPRIGHT, acceleration=STILL)
    model, memory = found.sensor.noise_model, first_memory(6)
    exact = np.array([0.0, 0.0, GRAVITY, 0.0, 0.0, 0.0])
    for k in range(2048):
        if k > 0:
            found.run(k * PERIOD)
        found.settle()  # new numbers are drawn before the sample is taken
        draws = found.sensor.GetInputPort("noise").Eval(found.context)
        assert found.measurement()[1:7].tolist() == noisy(model, exact, memory, draws, 1.0).tolist()
        memory = next_memory(model, memory, draws)


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, imu):
    first, second, third = (
        bench(imu(WALKING, WALKING), seed=seed, state=UPRIGHT, acceleration=STILL).measurements(50)
        for seed in (1, 1, 2)
    )
    assert first.tobytes() == second.tobytes()
    assert (first[:, 1:7] != third[:, 1:7]).all()


def test_two_axes_have_different_noise(bench, imu):
    found = bench(imu(WALKING, WALKING), state=UPRIGHT, acceleration=STILL)
    assert len(set(found.measurements(1)[0, [1, 2, 4, 5, 6]])) == 5


@pytest.mark.parametrize("quiet", [True, False])
def test_a_noisy_imu_is_so_even_where_the_description_has_no_noise(bench, imu, quiet):
    noises = (NO_NOISE, NO_NOISE) if quiet else (Noise(stddev=0.004), Noise(stddev=0.06))
    found = bench(imu(*noises), state=UPRIGHT, acceleration=STILL)
    found.order(Fault.NOISY)
    spread = np.std(found.measurements(1000)[:, 1:7], axis=0)
    usual = (
        [0.03] * 3 + [0.002] * 3
        if quiet
        else [0.06 * math.sqrt(1.024)] * 3 + [0.004 * math.sqrt(1.024)] * 3
    )
    assert spread == pytest.approx(FAULT_NOISE_FACTOR * np.array(usual), rel=0.1)
