"""The position of the world's origin on the earth."""

import math
from dataclasses import dataclass

WorldVector = tuple[float, float, float]

MAX_FIELD_T = 1e-3
"""Limit of the components of a stated magnetic field [T]; those of the earth are below 7e-5."""


@dataclass(frozen=True)
class Home:
    """The origin of the world frame on the WGS84 ellipsoid; it defines east, north and up.

    Attributes:
        latitude: geodetic, north is positive [rad].
        longitude: east is positive [rad].
        altitude: above the ellipsoid [m].
        magnetic_field: east, north and up [T], or None to compute it from the position, see
            `magnetic_field.earth_magnetic_field`.
    """

    latitude: float
    longitude: float
    altitude: float
    magnetic_field: WorldVector | None = None


DEFAULT_HOME = Home(math.radians(47.397742), math.radians(8.545594), 488.0)
"""The default home: Irchel in Zurich, as in PX4's simulations."""
