"""Where on the earth the world's origin lies."""

import math
from dataclasses import dataclass

Triple = tuple[float, float, float]

STRONGEST_FIELD = 1e-3
"""No magnetic field that is stated has a component beyond this [T]; the earth's are below 7e-5."""


@dataclass(frozen=True)
class Home:
    """The origin of the world frame on the WGS84 ellipsoid; east, north and up are seen from it.

    Attributes:
        latitude: geodetic, north is positive [rad].
        longitude: east is positive [rad].
        altitude: above the ellipsoid [m].
        magnetic_field: east, north and up, where it is stated [T]; else it follows from the
            place, see `magnetic_field.magnetic_field`.
    """

    latitude: float
    longitude: float
    altitude: float
    magnetic_field: Triple | None = None


DEFAULT_HOME = Home(math.radians(47.397742), math.radians(8.545594), 488.0)
"""Where nothing says another place: Irchel in Zurich, the home of PX4's simulations, whose users
know its figures."""
