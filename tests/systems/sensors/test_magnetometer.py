"""Oracle: the home's field turned by scipy's rotations; the field itself is tested elsewhere."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.home import Home
from workbench.plant.sensors import NO_NOISE, Magnetometer, Noise
from workbench.systems.sensors import noisy_sensor as module
from workbench.systems.sensors.readings import MagnetometerReading

PERIOD = 20 / 1024
FIELD = (1.3e-6, 21.5e-6, -43.2e-6)
HOME = Home(0.8, 0.1, 400.0, FIELD)
LEVEL = [1.0, *[0.0] * 12]


@pytest.fixture
def magnetometer(record):
    def make(noises=(NO_NOISE,) * 3, latency=0.0, **place):
        sensor = Magnetometer(**record(rate=50.0, **place), magnetic_field=noises)
        return module.NoisySensor(
            module.magnetometer_instrument(sensor, HOME), period=PERIOD, latency=latency
        )

    return make


@pytest.mark.parametrize("seed", range(5))
def test_the_field_is_turned_into_the_sensor_whatever_place_and_motion(bench, magnetometer, seed):
    R_WB, R_BS = Rotation.random(2, random_state=seed)
    x, y, z, w = R_WB.as_quat()
    rng = np.random.default_rng(seed)
    state = [*(1.01 * np.array([w, x, y, z])), *rng.uniform(-500.0, 500.0, 9)]
    p_BS = rng.uniform(-1.0, 1.0, 3)
    found = bench(magnetometer(p_BS=p_BS, R_BS=R_BS.as_matrix()), state=state)
    found.settle()
    expected = (R_WB * R_BS).inv().apply(FIELD)
    assert found.reading().magnetic_field == pytest.approx(expected, rel=0, abs=1e-18)


@pytest.mark.parametrize("seed", range(3))
def test_iron_on_board_is_along_the_axes_of_the_body(magnetometer, seed):
    """It turns with the drone, and its part along the sensor's axes depends on the mounting."""
    R_WB, R_BS = Rotation.random(2, random_state=10 + seed)
    iron = np.array([1e-6, -2e-6, 3e-6])
    state = np.array([*R_WB.as_quat(scalar_first=True), *[0.0] * 9])
    exact = magnetometer(R_BS=R_BS.as_matrix()).instrument.exact({"state": state}, iron)
    expected = (R_WB * R_BS).inv().apply(FIELD) + R_BS.inv().apply(iron)
    assert exact == pytest.approx(expected, rel=0, abs=1e-18)


def test_each_axis_has_its_own_noise(bench, magnetometer):
    noises = (Noise(stddev=3e-7), Noise(stddev=5e-7, mean=2e-6), Noise(bias_mean=-1e-6))
    rows = bench(magnetometer(noises), state=LEVEL).measurements(3000)[:, 1:]
    assert np.std(rows, axis=0) == pytest.approx([3e-7, 5e-7, 0.0], rel=0.05, abs=1e-15)
    offset = np.mean(rows, axis=0) - FIELD
    assert offset == pytest.approx([0.0, 2e-6, -1e-6], abs=4e-8)
    assert np.corrcoef(rows[:, :2].T)[0, 1] == pytest.approx(0.0, abs=0.08)


def test_a_reading_comes_late_and_says_when_it_was_taken(bench, magnetometer):
    found = bench(magnetometer(latency=1.5 * PERIOD), state=LEVEL)
    found.run(1.4 * PERIOD)
    assert found.reading() is None
    found.run(2.6 * PERIOD)
    assert isinstance(found.reading(), MagnetometerReading)
    assert (found.reading().stamp, found.reading().frame) == (PERIOD, "it_link")


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, magnetometer):
    noises = (Noise(stddev=5e-7),) * 3
    first, second, third = (
        bench(magnetometer(noises), seed=seed, state=LEVEL).measurements(20) for seed in (1, 1, 2)
    )
    assert first.tobytes() == second.tobytes()
    assert (first[:, 1:] != third[:, 1:]).all()


def test_a_noisy_magnetometer_is_so_even_where_the_description_has_no_noise(bench, magnetometer):
    found = bench(magnetometer(), state=LEVEL)
    found.order(Fault.NOISY)
    spread = np.std(found.measurements(1000)[:, 1:], axis=0)
    assert spread == pytest.approx([FAULT_NOISE_FACTOR * 0.5e-6] * 3, rel=0.1)
