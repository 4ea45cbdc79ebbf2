"""Convert between geodetic positions and positions in the world, east, north and up of the home."""

from typing import TYPE_CHECKING, NamedTuple, TypeVar

from pymap3d.ellipsoid import Ellipsoid
from pymap3d.enu import enu2geodetic, geodetic2enu

from workbench.plant.home import Home

if TYPE_CHECKING:
    import numpy as np

Coordinate = TypeVar("Coordinate", float, "np.ndarray")
_GEODESY_ELLIPSOID = Ellipsoid.from_name("wgs84")


class Geodetic(NamedTuple):
    """A position: latitude and longitude [rad], altitude above the ellipsoid [m]."""

    latitude: float
    longitude: float
    altitude: float


def geodetic(p_W: tuple[float, float, float], home: Home) -> Geodetic:
    """Return the geodetic position of a point in W [m]."""
    found = enu2geodetic(
        *p_W, home.latitude, home.longitude, home.altitude, _GEODESY_ELLIPSOID, deg=False
    )
    return Geodetic(*map(float, found))


def point_in_world(
    latitude: Coordinate, longitude: Coordinate, altitude: Coordinate, home: Home
) -> tuple[Coordinate, Coordinate, Coordinate]:
    """Return the point in W [m] of a geodetic position, or of arrays of them.

    Args:
        latitude: geodetic [rad].
        longitude: geodetic [rad].
        altitude: above the ellipsoid [m].
        home: the origin of the world.
    """
    origin = (home.latitude, home.longitude, home.altitude)
    found: tuple[Coordinate, Coordinate, Coordinate] = geodetic2enu(
        latitude, longitude, altitude, *origin, _GEODESY_ELLIPSOID, deg=False
    )
    return found
