"""From the world frame to latitude and longitude, and back, by pymap3d on WGS84."""

from typing import NamedTuple

from pymap3d.ellipsoid import Ellipsoid
from pymap3d.enu import enu2geodetic, geodetic2enu

from workbench.plant.home import Home

_WGS84 = Ellipsoid.from_name("wgs84")


class Geodetic(NamedTuple):
    """A place: latitude and longitude [rad], altitude above the ellipsoid [m]."""

    latitude: float
    longitude: float
    altitude: float


def geodetic(p_W: tuple[float, float, float], home: Home) -> Geodetic:
    """Return the place of a point in W [m]: east, north and up of the home."""
    found = enu2geodetic(*p_W, home.latitude, home.longitude, home.altitude, _WGS84, deg=False)
    return Geodetic(*map(float, found))


def world_position(place: Geodetic, home: Home) -> tuple[float, float, float]:
    """Return the point in W [m] of a place, the inverse of `geodetic`."""
    east, north, up = geodetic2enu(
        *place, home.latitude, home.longitude, home.altitude, _WGS84, deg=False
    )
    return float(east), float(north), float(up)
