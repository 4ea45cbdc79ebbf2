"""Places on the earth from places in the world, and back: east, north and up of the home."""

from typing import Any, NamedTuple

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
    """Return the place of a point in W [m]."""
    found = enu2geodetic(*p_W, home.latitude, home.longitude, home.altitude, _WGS84, deg=False)
    return Geodetic(*map(float, found))


def in_world(latitude: Any, longitude: Any, altitude: Any, home: Home) -> tuple[Any, Any, Any]:
    """Return the point in W [m] of a place, or of many as arrays.

    Args:
        latitude: geodetic [rad].
        longitude: likewise.
        altitude: above the ellipsoid [m].
        home: where the world's origin lies.
    """
    origin = (home.latitude, home.longitude, home.altitude)
    found: tuple[Any, Any, Any] = geodetic2enu(
        latitude, longitude, altitude, *origin, _WGS84, deg=False
    )
    return found
