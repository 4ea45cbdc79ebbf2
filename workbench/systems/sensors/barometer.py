"""The barometer: air pressure, and the height above home that follows from it."""

import math

import numpy as np
from pydrake.systems.framework import Context

from workbench.plant.home import Home
from workbench.plant.sensors import Barometer as BarometerRecord
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import BarometerReading

COLUMNS = ("pressure [Pa]", "altitude [m]")
"""What a sample's numbers are."""

USUAL = (2.0,)
"""Deviation of a common one [Pa]."""
_SEA_LEVEL_PRESSURE = 101_325.0
_SEA_LEVEL_TEMPERATURE = 288.15
_LAPSE = 0.0065
_GRAVITY = 9.80665
_GAS_CONSTANT = 287.05287
_EARTH_RADIUS = 6_356_766.0
_TROPOPAUSE = 11_000.0
_EXPONENT = _GRAVITY / (_GAS_CONSTANT * _LAPSE)
_COLD = _SEA_LEVEL_TEMPERATURE - _LAPSE * _TROPOPAUSE
_COLD_PRESSURE = _SEA_LEVEL_PRESSURE * (_COLD / _SEA_LEVEL_TEMPERATURE) ** _EXPONENT
_COLD_HEIGHT = _GAS_CONSTANT * _COLD / _GRAVITY
"""Over which pressure falls by the factor e above the tropopause [m]."""
_LEAST_PRESSURE = 1.0
"""Below this no altitude is asked for: a faulty barometer may measure nonsense [Pa]."""


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


def pressure_at(altitude: float) -> float:
    """Return the pressure [Pa] at an altitude above the sea [m]."""
    geopotential = _EARTH_RADIUS * altitude / (_EARTH_RADIUS + altitude)
    if geopotential > _TROPOPAUSE:
        return _COLD_PRESSURE * math.exp(-(geopotential - _TROPOPAUSE) / _COLD_HEIGHT)
    return _SEA_LEVEL_PRESSURE * (1.0 - _LAPSE * geopotential / _SEA_LEVEL_TEMPERATURE) ** _EXPONENT


def altitude_at(pressure: float) -> float:
    """Return the altitude above the sea [m] at which a pressure [Pa] is found."""
    pressure = max(pressure, _LEAST_PRESSURE)
    if pressure < _COLD_PRESSURE:
        geopotential = _TROPOPAUSE + _COLD_HEIGHT * math.log(_COLD_PRESSURE / pressure)
    else:
        share = (pressure / _SEA_LEVEL_PRESSURE) ** (1.0 / _EXPONENT)
        geopotential = _SEA_LEVEL_TEMPERATURE / _LAPSE * (1.0 - share)
    return _EARTH_RADIUS * geopotential / (_EARTH_RADIUS - geopotential)
