"""Oracle: the tables of the U.S. Standard Atmosphere 1976, by geometric altitude."""

import numpy as np
import pytest

from workbench.systems.sensors.barometer import altitude_at, pressure_at

TABLE = [
    (-1000, 1.1393e5),
    (0, 1.01325e5),
    (500, 9.5461e4),
    (1000, 8.9876e4),
    (2000, 7.9501e4),
    (5000, 5.4048e4),
    (10_000, 2.6500e4),
    (15_000, 1.2111e4),
    (20_000, 5.5293e3),
]


@pytest.mark.parametrize(("altitude", "pressure"), TABLE)
def test_pressures_are_those_of_the_table(altitude, pressure):
    assert pressure_at(altitude) == pytest.approx(pressure, rel=1e-4)


def test_near_the_ground_a_metre_is_twelve_pascals():
    """The weight of a cubic metre of air of 1.225 kg."""
    assert pressure_at(0.0) - pressure_at(1.0) == pytest.approx(1.225 * 9.80665, rel=1e-3)


def test_altitude_is_the_inverse_and_goes_on_smoothly():
    altitudes = np.linspace(-1000.0, 20_000.0, 2101)
    back = [altitude_at(pressure_at(altitude)) for altitude in altitudes]
    assert back == pytest.approx(altitudes, abs=1e-6)
    assert (np.diff([pressure_at(altitude) for altitude in altitudes]) < 0.0).all()


@pytest.mark.parametrize("pressure", [0.0, -5.0, -1e9])
def test_no_pressure_is_some_high_altitude(pressure):
    assert 50_000.0 < altitude_at(pressure) < 200_000.0
