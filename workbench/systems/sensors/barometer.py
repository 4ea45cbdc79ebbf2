"""The barometer: air pressure, and the height above home that follows from it."""

import math

import numpy as np
from pydrake.systems.framework import Context

from workbench.plant.home import Home
from workbench.plant.sensors import Barometer as BarometerRecord
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import BarometerReading
from workbench.systems.sensors.standard_atmosphere import altitude_at, pressure_at

COLUMNS = ("pressure [Pa]", "altitude [m]")
"""What a sample's numbers are."""

USUAL = (2.0,)
"""Deviation of a common one [Pa]."""


class Barometer(NoisySensor):
    """Measures the pressure of the standard atmosphere, with noise on the pressure.

    A sample (2) is the pressure [Pa] and the altitude above home [m] at which the standard
    atmosphere has it. The world's origin is as high above the sea as the home above the
    ellipsoid, or as the description's reference altitude says.

    Input ports:
        state (13): of the plant.
        noise (3): see `NoisySensor`.

    Args:
        sensor: the description's record.
        home: where the world's origin lies.
        period: between samples [s].
        latency: from a sample to its delivery [s].
    """

    def __init__(
        self, *, sensor: BarometerRecord, home: Home, period: float, latency: float = 0.0
    ) -> None:
        super().__init__(
            size=2, noises=(sensor.noise,), usual=USUAL, period=period, latency=latency
        )
        given = sensor.reference_altitude
        self._reference = home.altitude if given is None else given
        self._frame = sensor.frame
        self._p_BS = np.array(sensor.p_BS)
        self.state_input = self.DeclareVectorInputPort("state", 13)

    def exact(self, context: Context) -> np.ndarray:
        height = motion(self.state_input.Eval(context), self._p_BS).p_WS[2]
        return np.array([pressure_at(self._reference + height)])

    def shown(self, values: np.ndarray) -> np.ndarray:
        pressure = float(values[0])
        return np.array([pressure, altitude_at(pressure) - self._reference])

    def reading(self, context: Context) -> BarometerReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, pressure, altitude = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return BarometerReading(stamp, self._frame, pressure, altitude)
