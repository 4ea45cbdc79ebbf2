"""Oracle: world positions and velocities by hand, and the geodesy that is tested beside this."""

import math

import numpy as np
import pytest
from pymap3d.enu import geodetic2enu

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.geodesy import geodetic
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.sensors import NO_NOISE, Gps, Noise
from workbench.systems.sensors import noisy_sensor as module
from workbench.systems.sensors.readings import GpsReading

PERIOD = 102 / 1024
HALF = math.sqrt(0.5)
LEFT = [HALF, 0.0, 0.0, HALF]
"""Turned a quarter to the left: what is in front of the body is north."""


@pytest.fixture
def gps(record):
    def make(home=DEFAULT_HOME, latency=0.0, p_BS=(0.0, 0.0, 0.0), **noises):
        sensor = Gps(**record(rate=10.0, p_BS=p_BS), **noises)
        return module.NoisySensor(
            module.gps_instrument(sensor, home), period=PERIOD, latency=latency
        )

    return make


def positions(rows, home=DEFAULT_HOME):
    """Return the measured positions in W of samples (k, 7)."""
    at = (home.latitude, home.longitude, home.altitude)
    return np.array([geodetic2enu(*row[1:4], *at, deg=False) for row in rows])


def test_the_antenna_is_located_and_not_the_body(bench, gps):
    state = [*LEFT, 10.0, 20.0, 30.0, *[0.0] * 6]
    found = bench(gps(p_BS=(0.5, 0.0, 0.2)), state=state)
    found.settle()
    reading = found.reading()
    wanted = geodetic((10.0, 20.5, 30.2), DEFAULT_HOME)
    assert (reading.latitude, reading.longitude) == pytest.approx(wanted[:2], abs=1e-13)
    assert reading.altitude == pytest.approx(wanted.altitude, abs=1e-7)


def test_velocity_is_that_of_the_antenna_east_north_and_up(bench, gps):
    """Flying at (1, 2, 3) and turning left at 2 rad/s, 0.5 m in front of the middle."""
    state = [*LEFT, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0, 2.0, 3.0]
    found = bench(gps(p_BS=(0.5, 0.0, 0.0)), state=state)
    found.settle()
    assert found.reading().velocity == pytest.approx((1.0 - 2.0 * 0.5, 2.0, 3.0), abs=1e-12)


def test_another_home_is_another_place(bench, gps):
    home = Home(-0.5, 2.0, 7.0)
    found = bench(gps(home=home), state=[1.0, *[0.0] * 12])
    found.settle()
    reading = found.reading()
    assert (reading.latitude, reading.longitude) == pytest.approx((-0.5, 2.0), abs=1e-13)
    assert reading.altitude == pytest.approx(7.0, abs=1e-6)


def test_noise_is_in_metres_on_each_axis(bench, gps):
    noises = {
        "horizontal_position": Noise(stddev=1.5),
        "vertical_position": Noise(stddev=3.0, mean=0.5),
        "horizontal_velocity": Noise(stddev=0.1),
        "vertical_velocity": Noise(stddev=0.2, bias_mean=-0.4),
    }
    rows = bench(gps(**noises), state=[1.0, *[0.0] * 12]).measurements(2000)
    values = np.hstack([positions(rows), rows[:, 4:]])
    assert np.std(values, axis=0) == pytest.approx([1.5, 1.5, 3.0, 0.1, 0.1, 0.2], rel=0.06)
    wanted = [0.0, 0.0, 0.5, 0.0, 0.0, -0.4]
    assert np.abs(np.mean(values, axis=0) - wanted).max() < 0.25
    assert np.corrcoef(values.T) == pytest.approx(np.eye(6), abs=0.08)


def test_each_axis_has_a_bias_of_its_own(bench, gps):
    rows = bench(
        gps(horizontal_position=Noise(bias_stddev=2.0)), state=[1.0, *[0.0] * 12]
    ).measurements(3)
    east, north, up = positions(rows).T
    assert np.ptp(east) < 1e-6
    assert abs(east[0]) > 1e-3
    assert abs(north[0] - east[0]) > 1e-3
    assert up == pytest.approx([0.0] * 3, abs=1e-6)


def test_a_reading_comes_late_and_says_when_it_was_taken(bench, gps):
    found = bench(gps(latency=1.5 * PERIOD), state=[1.0, *[0.0] * 12])
    found.run(1.4 * PERIOD)
    assert found.reading() is None
    found.run(2.6 * PERIOD)
    assert isinstance(found.reading(), GpsReading)
    assert (found.reading().stamp, found.reading().frame) == (PERIOD, "it_link")


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, gps):
    noise = {"horizontal_position": Noise(stddev=1.0), "vertical_velocity": Noise(stddev=1.0)}
    first, second, third = (
        bench(gps(**noise), seed=seed, state=[1.0, *[0.0] * 12]).measurements(20)
        for seed in (1, 1, 2)
    )
    assert first.tobytes() == second.tobytes()
    assert (first[:, [1, 2, 6]] != third[:, [1, 2, 6]]).all()


def test_a_noisy_gps_is_so_even_where_the_description_has_no_noise(bench, gps):
    found = bench(gps(horizontal_position=NO_NOISE), state=[1.0, *[0.0] * 12])
    found.order(Fault.NOISY)
    rows = found.measurements(500)
    spread = np.std(np.hstack([positions(rows), rows[:, 4:]]), axis=0)
    assert spread == pytest.approx(
        FAULT_NOISE_FACTOR * np.array([1.5, 1.5, 3.0, 0.1, 0.1, 0.2]), rel=0.15
    )
