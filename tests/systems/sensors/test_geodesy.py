"""Oracle: the closed form of WGS84, geodetic to Cartesian to east, north, up, written out here."""

import math

import numpy as np
import pytest

from workbench.plant.geodesy import geodetic
from workbench.plant.home import DEFAULT_HOME, Home

A, F = 6_378_137.0, 1 / 298.257223563
E2 = F * (2 - F)


def cartesian(latitude, longitude, altitude):
    normal = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
    level = (normal + altitude) * math.cos(latitude)
    return np.array(
        [
            level * math.cos(longitude),
            level * math.sin(longitude),
            (normal * (1 - E2) + altitude) * math.sin(latitude),
        ]
    )


def seen_from(home, place):
    """Return east, north, up of a place."""
    sa, ca = math.sin(home.latitude), math.cos(home.latitude)
    so, co = math.sin(home.longitude), math.cos(home.longitude)
    axes = np.array([[-so, co, 0], [-sa * co, -sa * so, ca], [ca * co, ca * so, sa]])
    return axes @ (cartesian(*place) - cartesian(home.latitude, home.longitude, home.altitude))


def random_homes(count):
    rng = np.random.default_rng(0)
    for _ in range(count):
        latitude = math.asin(rng.uniform(-1, 1))
        home = Home(latitude, rng.uniform(-math.pi, math.pi), rng.uniform(-400, 4000))
        yield home, (*rng.uniform(-7071, 7071, 2).tolist(), rng.uniform(-500, 5000))


def test_places_within_ten_kilometres_are_those_of_the_closed_form_to_a_millimetre():
    for home, p_W in random_homes(300):
        assert seen_from(home, geodetic(p_W, home)) == pytest.approx(p_W, rel=0, abs=1e-6)


@pytest.mark.parametrize("latitude", [90.0, -90.0, 0.0, 89.9999])
@pytest.mark.parametrize("p_W", [(0.0, 0.0, 0.0), (3.0, -4.0, 5.0), (-10.0, 0.1, -2.0)])
def test_poles_and_equator_are_places_like_others(latitude, p_W):
    home = Home(math.radians(latitude), 0.3, 0.0)
    assert seen_from(home, geodetic(p_W, home)) == pytest.approx(p_W, rel=0, abs=1e-6)


def test_home_is_the_worlds_origin():
    found = geodetic((0.0, 0.0, 0.0), DEFAULT_HOME)
    assert found[:2] == pytest.approx((DEFAULT_HOME.latitude, DEFAULT_HOME.longitude), abs=1e-12)
    assert found.altitude == pytest.approx(DEFAULT_HOME.altitude, abs=1e-6)


def test_north_is_latitude_east_is_longitude_up_is_altitude():
    """A degree of latitude is some 111.2 km long in Zurich, one of longitude 75.5 km."""
    home = DEFAULT_HOME
    north, east, up = (geodetic(p, home) for p in [(0, 1000, 0), (1000, 0, 0), (0, 0, 1000)])
    assert math.degrees(north.latitude - home.latitude) == pytest.approx(1 / 111.2, rel=1e-3)
    assert north.longitude == pytest.approx(home.longitude, abs=1e-12)
    assert math.degrees(east.longitude - home.longitude) == pytest.approx(1 / 75.5, rel=1e-3)
    assert up.altitude - home.altitude == pytest.approx(1000.0, abs=1e-6)


def test_across_the_date_line_longitude_changes_its_sign():
    home = Home(0.0, math.radians(179.9999), 0.0)
    assert geodetic((100.0, 0.0, 0.0), home).longitude < -3.14
