"""Oracles: a dipole's field by hand at the pole and at the equator, the gradient of its potential
elsewhere, and the World Magnetic Model of 2025 for how far off a dipole is."""

import math

import numpy as np
import pytest

from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.magnetic_field import earth_magnetic_field

G10, G11, H11 = -29350.0, -1410.3, 4545.5
"""Of the IGRF-14 for 2025.0 [nT]."""
A = 6371.2
"""To which they belong [km]."""
EQUATOR, POLE = 6378.137, 6356.752314245
"""The ellipsoid's semi-axes [km]."""
MICRO = 1e-6
CALCULATED = (
    (47.397742, 8.545594, 488.0, (1.287, 21.520, -43.242), 0.01, 8.0),
    (40.0, -105.0, 0.0, (2.772, 20.593, -46.963), 0.07, 2.0),
    (-34.0, 151.0, 0.0, (5.425, 23.943, 51.565), 0.25, 7.0),
)
"""Latitude, longitude [deg], altitude [m], field of the WMM2025 at 2025.0 (east, north, up) [µT] by
pygeomag 1.1.0, and how far off a dipole is: share of the strength, angle [deg]."""


def home(latitude, longitude, altitude=0.0):
    return Home(math.radians(latitude), math.radians(longitude), altitude)


def test_at_the_equator_it_is_that_of_the_formula_by_hand(case):
    """There u = (cos, sin, 0) of the longitude, so up is 2 m.u, and east and north are -m."""
    for longitude, east, up in ((0.0, -H11, 2.0 * G11), (90.0, G11, 2.0 * H11)):
        with case(longitude):
            weaker = (A / EQUATOR) ** 3 * 1e-9
            expected = weaker * np.array([east, -G10, up])
            assert earth_magnetic_field(home(0.0, longitude)) == pytest.approx(expected, abs=1e-15)


def test_at_the_pole_it_is_twice_as_strong_and_downwards():
    """Looked at along longitude 0: east is the earth's y, north its -x, up its z."""
    found = earth_magnetic_field(home(90.0, 0.0, 2000.0))
    weaker = (A / (POLE + 2.0)) ** 3 * 1e-9
    assert found == pytest.approx(weaker * np.array([-H11, G11, 2.0 * G10]), abs=1e-15)


def test_it_is_the_gradient_of_the_igrfs_first_degree(case):
    """By differences of V = a (a/r)^2 (g10 sin t + (g11 cos p + h11 sin p) cos t), t geocentric."""

    def potential(x, y, z):
        r, p = math.hypot(x, y, z), math.atan2(y, x)
        sine, cosine = z / r, math.hypot(x, y) / r
        return A * (A / r) ** 2 * (G10 * sine + (G11 * math.cos(p) + H11 * math.sin(p)) * cosine)

    rng = np.random.default_rng(4)
    for latitude, longitude in rng.uniform((-80.0, -180.0), (80.0, 180.0), (5, 2)):
        with case((latitude, longitude)):
            t, p = math.radians(latitude), math.radians(longitude)
            flat = 1.0 - (POLE / EQUATOR) ** 2
            normal = EQUATOR / math.sqrt(1.0 - flat * math.sin(t) ** 2)
            place = np.array([normal * math.cos(t) * math.cos(p),
                              normal * math.cos(t) * math.sin(p),
                              normal * (1.0 - flat) * math.sin(t)])  # fmt: skip
            steps = 0.5 * np.eye(3)
            B = np.array([potential(*(place - s)) - potential(*(place + s)) for s in steps])
            east = (-math.sin(p), math.cos(p), 0.0)
            up = (math.cos(t) * math.cos(p), math.cos(t) * math.sin(p), math.sin(t))
            expected = 1e-9 * np.array([B @ east, B @ np.cross(up, east), B @ up])
            found = earth_magnetic_field(home(latitude, longitude))
            assert found == pytest.approx(expected, abs=1e-12)


def test_it_is_as_near_to_the_earths_field_as_is_said(case):
    for latitude, longitude, altitude, real, share, angle in CALCULATED:
        with case((latitude, longitude)):
            found = earth_magnetic_field(home(latitude, longitude, altitude)) / MICRO
            strength, true = np.linalg.norm(found), np.linalg.norm(real)
            assert strength == pytest.approx(true, rel=share)
            assert math.degrees(math.acos(found @ real / strength / true)) < angle
    assert earth_magnetic_field(DEFAULT_HOME) == pytest.approx(
        earth_magnetic_field(home(*CALCULATED[0][:3]))
    )


def test_a_field_that_is_stated_is_taken():
    stated = (1e-6, 2e-5, -4e-5)
    assert tuple(earth_magnetic_field(Home(0.8, 0.1, 488.0, stated))) == stated
