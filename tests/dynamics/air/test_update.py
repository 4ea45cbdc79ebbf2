"""Wind, gust and the times of a push by hand."""

import math

import numpy as np
import pytest

from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import (
    gust_share,
    intensities,
    push_share,
    steady_wind,
    turbulent_wind,
)

PERIOD = 1 / 128
STATE = np.array([1.0, *[0.0] * 5, 20.0, *[0.0] * 6])


def turbulence(settings, noise, eddies=None):
    """Return the velocity of the turbulence, and what it remembers."""
    after = np.zeros(6)
    begun = np.zeros(6) if eddies is None else eddies
    return np.array(turbulent_wind(settings, STATE, noise, begun, PERIOD, after)), after


@pytest.mark.parametrize(
    ("time", "share"),
    [(0.0, 0), (1.9, 0), (2.0, 0), (2.5, 0.146447), (3.0, 0.5), (4.0, 1), (5.0, 0.5), (6.0, 0)],
)
def test_a_gust_rises_and_falls(time, share):
    assert gust_share(time, 2.0, 4.0) == pytest.approx(share, abs=1e-6)


@pytest.mark.parametrize("start", [0.0, 0.001, 0.5 * PERIOD, 1.234])
@pytest.mark.parametrize("duration", [0.001, PERIOD, 0.1, 0.3333])
def test_a_push_has_its_impulse_whatever_its_times(start, duration):
    shares = [push_share(index * PERIOD, PERIOD, start, duration) for index in range(256)]
    assert PERIOD * sum(shares) == pytest.approx(duration, rel=1e-9)
    assert max(shares) <= 1.0


def test_wind_and_gust_add_up():
    settings = AirSettings(
        wind_x=1.0, wind_y=2.0, wind_z=3.0, gust_x=10.0, gust_y=20.0, gust_z=30.0
    )
    assert steady_wind(settings, 5.0) == (1.0, 2.0, 3.0)
    gusty = settings._replace(gust_start=4.0, gust_duration=2.0)
    assert steady_wind(gusty, 5.0) == pytest.approx([11.0, 22.0, 33.0])


@pytest.mark.parametrize("heading", [0.0, 0.5, 3.0, -2.0])
def test_turbulence_lies_along_the_mean_wind(heading):
    """The filters' first states alone, one after the other: u along, v left, w up."""
    along = np.array([math.cos(heading), math.sin(heading), 0.0])
    left = np.array([-along[1], along[0], 0.0])
    settings = AirSettings(wind_x=5 * along[0], wind_y=5 * along[1], turbulence=7.7)
    s_level, s_w = intensities(20.0, 7.7)
    for place, axis, s in ((0, along, s_level), (1, left, s_level), (3, [0.0, 0.0, 1.0], s_w)):
        noise = np.zeros(5)
        noise[place] = 1.0
        blown, _ = turbulence(settings, noise)
        assert np.cross(blown, axis) == pytest.approx(np.zeros(3), abs=1e-12)
        assert 0.3 * s < blown @ axis < 1.1 * s


def test_without_a_wind_turbulence_lies_along_x():
    noise = np.array([1.0, 0, 0, 0, 0])
    wind, _ = turbulence(AirSettings(turbulence=7.7), noise)
    assert wind[1:].tolist() == [0.0, 0.0]
    assert wind[0] > 0.1


def test_the_filters_begin_once():
    _, begun = turbulence(AirSettings(turbulence=7.7), np.ones(5))
    assert begun[5] == 1.0
    assert begun[0] == pytest.approx(1.0)
    _, later = turbulence(AirSettings(turbulence=7.7), np.zeros(5), begun)
    assert later[0] == pytest.approx(1.0, abs=0.01)


def test_the_drones_way_through_the_wind_says_how_fast_eddies_pass(case):
    """They fade as exp(-V T / L): a drone at 6 m/s against 4 meets them at 10, in any direction.

    Level the length is h / (0.177 + 0.000823 h)^1.2 in feet, upright it is h. A filter of second
    order begins with its first state alone, of which the second one gets V T / L.
    """
    h = 20.0 / 0.3048
    level, upright = 20.0 / (0.177 + 0.000823 * h) ** 1.2, 20.0
    wind = {10: "wind_x", 11: "wind_y", 12: "wind_z"}
    for place, name in wind.items():
        for first, length in ((0, level), (1, level), (3, upright)):
            with case(name, first):
                eddies, after, state = np.zeros(6), np.zeros(6), STATE.copy()
                eddies[[first, 5]] = 1.0
                state[place] = -6.0
                settings = AirSettings(**{name: 4.0}, turbulence=1.0)
                turbulent_wind(settings, state, np.zeros(5), eddies, PERIOD, after)
                share = 10.0 * PERIOD / length
                assert after[first] == pytest.approx(math.exp(-share), rel=1e-12)
                if first:
                    expected = share * math.exp(-share)
                    assert after[first + 1] == pytest.approx(expected, rel=1e-12)
