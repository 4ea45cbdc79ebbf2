"""Where on the earth the world's origin lies."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Home:
    """The origin of the world frame on the WGS84 ellipsoid; east, north and up are seen from it.

    Attributes:
        latitude: geodetic, north is positive [rad].
        longitude: east is positive [rad].
        altitude: above the ellipsoid [m].
    """

    latitude: float
    longitude: float
    altitude: float


DEFAULT_HOME = Home(math.radians(47.397742), math.radians(8.545594), 488.0)
"""Where nothing says another place: Irchel in Zurich, the home of PX4's simulations, whose users
know its figures."""
