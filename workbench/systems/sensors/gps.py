"""Satellite navigation: latitude, longitude, altitude and velocity of the antenna."""

import math

import numpy as np
from pydrake.systems.framework import Context

from workbench.plant.geodesy import geodetic
from workbench.plant.home import Home
from workbench.plant.sensors import Gps as GpsRecord
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import GpsReading

COLUMNS = (
    "latitude [rad]",
    "longitude [rad]",
    "altitude [m]",
    "v_east [m/s]",
    "v_north [m/s]",
    "v_up [m/s]",
)
"""What a sample's numbers are."""

USUAL = (1.5, 1.5, 3.0, 0.1, 0.1, 0.2)
"""Deviations of a common one: position [m] and velocity [m/s], east, north and up."""


class Gps(NoisySensor):
    """Measures the antenna's position on the earth and its velocity.

    A sample (6) is latitude and longitude [rad], altitude above the ellipsoid [m], and velocity
    east, north and up [m/s]. Noise is added in metres east, north and up of the home, before the
    conversion to angles. East, north and up are the world's axes everywhere: 10 km from home, they
    differ from the local ones by 0.0016 rad.

    Input ports:
        state (13): of the plant.
        noise (18): see `NoisySensor`.

    Args:
        sensor: the description's record.
        home: where the world's origin lies.
        period: between samples [s].
        latency: from a sample to its delivery [s].
    """

    def __init__(
        self, *, sensor: GpsRecord, home: Home, period: float, latency: float = 0.0
    ) -> None:
        super().__init__(
            size=6,
            noises=sensor.noises,
            usual=USUAL,
            period=period,
            latency=latency,
        )
        self._frame = sensor.frame
        self._home = home
        self._p_BS = np.array(sensor.p_BS)
        self.state_input = self.DeclareVectorInputPort("state", 13)

    def exact(self, context: Context) -> np.ndarray:
        moves = motion(self.state_input.Eval(context), self._p_BS)
        return np.concatenate([moves.p_WS, moves.v_WS])

    def shown(self, values: np.ndarray) -> np.ndarray:
        east, north, up = values[:3].tolist()
        return np.concatenate([geodetic((east, north, up), self._home), values[3:]])

    def reading(self, context: Context) -> GpsReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, latitude, longitude, altitude, east, north, up = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return GpsReading(stamp, self._frame, latitude, longitude, altitude, (east, north, up))
