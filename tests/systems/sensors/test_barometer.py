"""Oracle: the standard atmosphere that is tested beside this, and heights by hand."""

import numpy as np
import pytest

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.sensors import NO_NOISE, Barometer, Noise
from workbench.systems.sensors import barometer as module
from workbench.systems.sensors.barometer import pressure_at
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import BarometerReading

PERIOD = 20 / 1024
ON_ITS_NOSE = [0.5**0.5, 0.0, 0.5**0.5, 0.0]
"""What is in front of the body is below it."""


def state(height, q_WB=(1.0, 0.0, 0.0, 0.0)):
    return [*q_WB, 1.0, 2.0, height, *[0.0] * 6]


@pytest.fixture
def barometer(record):
    def make(noise=NO_NOISE, reference=None, home=DEFAULT_HOME, latency=0.0, p_BS=(0.0, 0.0, 0.0)):
        sensor = Barometer(
            **record(rate=50.0, p_BS=p_BS), reference_altitude=reference, noise=noise
        )
        return NoisySensor(
            module.barometer_instrument(sensor, home), period=PERIOD, latency=latency
        )

    return make


@pytest.mark.parametrize("height", [-3.0, 0.0, 12.5, 900.0])
def test_altitude_is_the_height_above_home_of_the_sensor(bench, barometer, height):
    found = bench(barometer(p_BS=(0.4, 0.0, 0.2)), state=state(height, ON_ITS_NOSE))
    found.settle()
    assert found.reading().altitude == pytest.approx(height - 0.4, abs=1e-6)


def test_pressure_is_that_at_homes_altitude(bench, barometer):
    found = bench(barometer(home=Home(0.0, 0.0, 2000.0)), state=state(100.0))
    found.settle()
    assert found.reading().pressure == pytest.approx(pressure_at(2100.0), abs=1e-6)


@pytest.mark.parametrize("reference", [0.0, 1500.0])
def test_a_reference_altitude_goes_before_homes(bench, barometer, reference):
    found = bench(barometer(reference=reference), state=state(10.0))
    found.settle()
    assert found.reading().pressure == pytest.approx(pressure_at(reference + 10.0), abs=1e-6)
    assert found.reading().altitude == pytest.approx(10.0, abs=1e-6)


def test_noise_is_on_the_pressure_and_altitude_follows(bench, barometer):
    rows = bench(
        barometer(Noise(stddev=3.0, mean=20.0), home=Home(0.0, 0.0, 0.0)), state=state(0.0)
    ).measurements(3000)
    _, pressure, altitude = rows.T
    assert np.std(pressure) == pytest.approx(3.0, rel=0.05)
    assert np.mean(pressure) == pytest.approx(101_345.0, abs=0.3)
    assert np.std(altitude) == pytest.approx(3.0 / 12.013, rel=0.05)
    assert np.mean(altitude) == pytest.approx(-20.0 / 12.013, rel=0.02)


def test_a_reading_comes_late_and_says_when_it_was_taken(bench, barometer):
    found = bench(barometer(latency=1.5 * PERIOD), state=state(0.0))
    found.run(1.4 * PERIOD)
    assert found.reading() is None
    found.run(2.6 * PERIOD)
    assert isinstance(found.reading(), BarometerReading)
    assert (found.reading().stamp, found.reading().frame) == (PERIOD, "it_link")


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, barometer):
    first, second, third = (
        bench(barometer(Noise(stddev=3.0)), seed=seed, state=state(0.0)).measurements(20)
        for seed in (1, 1, 2)
    )
    assert first.tobytes() == second.tobytes()
    assert (first[:, 1:] != third[:, 1:]).all()


def test_a_noisy_barometer_is_so_even_where_the_description_has_no_noise(bench, barometer):
    found = bench(barometer(), state=state(0.0))
    found.order(Fault.NOISY)
    spread = np.std(found.measurements(1000)[:, 1])
    assert spread == pytest.approx(FAULT_NOISE_FACTOR * 2.0, rel=0.1)


@pytest.mark.parametrize(
    ("height", "share"), [(0.0, 1.0), (0.5, np.exp(-1.0)), (1.0, np.exp(-2.0)), (-2.0, 1.0)]
)
def test_downwash_adds_less_with_the_height_and_all_of_it_below_the_ground(record, height, share):
    """In a hollow, or on a gear that gives, the sensor is lower than the world's ground.

    Half of the thrust adds half as much.
    """
    sensor = Barometer(**record(rate=50.0), reference_altitude=0.0, noise=NO_NOISE)
    weight, added = 20.0, 48.0
    instrument = module.barometer_instrument(sensor, DEFAULT_HOME, rotors=4, weight=weight)
    for part in (1.0, 0.5):
        inputs = {"state": np.array(state(height)), "thrusts": np.full(4, 0.25 * part * weight)}
        found = instrument.exact(inputs, (added,))
        assert found == pytest.approx([pressure_at(height) + added * part * share], abs=1e-9)
