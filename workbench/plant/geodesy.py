"""Convert between geodetic positions and positions in the world, east, north and up of the home."""

from typing import Any, NamedTuple

from pymap3d.ellipsoid import Ellipsoid
from pymap3d.enu import enu2geodetic, geodetic2enu

from workbench.plant.home import Home

_WGS84 = Ellipsoid.from_name("wgs84")


class Geodetic(NamedTuple):
    """A position: latitude and longitude [rad], altitude above the ellipsoid [m]."""

    latitude: float
    longitude: float
    altitude: float


def geodetic(p_W: tuple[float, float, float], home: Home) -> Geodetic:
    """Return the geodetic position of a point in W [m]."""
    found = enu2geodetic(*p_W, home.latitude, home.longitude, home.altitude, _WGS84, deg=False)
    return Geodetic(*map(float, found))


def in_world(latitude: Any, longitude: Any, altitude: Any, home: Home) -> tuple[Any, Any, Any]:
    """Return the point in W [m] of a geodetic position, or of arrays of them.

    Args:
        latitude: geodetic [rad].
        longitude: geodetic [rad].
        altitude: above the ellipsoid [m].
        home: the origin of the world.
    """
    origin = (home.latitude, home.longitude, home.altitude)
    found: tuple[Any, Any, Any] = geodetic2enu(
        latitude, longitude, altitude, *origin, _WGS84, deg=False
    )
    return found
