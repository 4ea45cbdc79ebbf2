"""The earth's magnetic field at the home."""

import numpy as np
from pymap3d.ecef import ecef2enuv, geodetic2ecef
from pymap3d.ellipsoid import Ellipsoid

from workbench.plant.home import Home

_FIELD_ELLIPSOID = Ellipsoid.from_name("wgs84")
_REFERENCE_RADIUS_M = 6_371_200.0
"""Reference radius of the coefficients [m]."""
_DIPOLE_T = np.array([-1410.3e-9, 4545.5e-9, -29350.0e-9])
"""Coefficients g11, h11 and g10 of the IGRF-14 for 2025.0: along the earth's axes x, y, z [T]."""


def earth_magnetic_field(home: Home) -> np.ndarray:
    """Return the magnetic field in W: east, north, up (3) [T]; it is uniform in the world.

    It is the field stated by the home, or else that of a tilted dipole at the earth's centre, the
    first degree of the International Geomagnetic Reference Field (IGRF-14, Alken et al., Earth,
    Planets and Space 73, 49, 2021, has the series): B = (a / r)^3 (3 (m.u) u - m) with m = (g11,
    h11, g10), u the unit vector from the earth's centre to the home, and r its distance. Compared
    with the World Magnetic Model of 2025 between 60 degrees south and 70 north, the RMS error is a
    quarter in strength and 13 degrees in direction. In Zurich the errors are 0.3 % and 7.5 degrees.
    In the South Atlantic they are worst: the field is almost twice as strong and 40 degrees off. A
    world that needs a better field states it.

    Args:
        home: the origin of the world.
    """
    if home.magnetic_field is not None:
        return np.array(home.magnetic_field)
    place = (home.latitude, home.longitude)
    r = np.array(geodetic2ecef(*place, home.altitude, _FIELD_ELLIPSOID, deg=False))
    distance = np.linalg.norm(r)
    u = r / distance
    field = (_REFERENCE_RADIUS_M / distance) ** 3 * (3.0 * (_DIPOLE_T @ u) * u - _DIPOLE_T)
    return np.array(ecef2enuv(*field, *place, deg=False))
