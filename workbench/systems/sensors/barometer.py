"""The barometer: air pressure, and the height above home that follows from it."""

import math

import numpy as np
from pydrake.systems.framework import Context

from workbench.common.jitable import register_jitable
from workbench.plant.home import Home
from workbench.plant.sensors import Barometer as BarometerRecord
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import BarometerReading

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
GROUND_EFFECT_HEIGHT = 0.5
"""What the ground adds has fallen by the factor e at this height of the sensor [m]: PX4 allows for
it up to there (EKF2_GND_MAX_HGT)."""
_LEAST_PRESSURE = 1.0
"""Smallest pressure for an altitude: a faulty barometer may measure nonsense [Pa]."""


class Barometer(NoisySensor):
    """Measures the pressure of the standard atmosphere, with noise on the pressure.

    A sample (2) is the pressure [Pa] and the altitude above home [m] at which the standard
    atmosphere has it. The world's origin is as high above the sea as the home above the
    ellipsoid, or as the description's reference altitude says.

    Near the ground the rotors' downwash raises the pressure, so a barometer shows too little
    height. The effect depends on the frame and on the sensor's position, so it is a setting, and it
    is proportional to the thrust. PX4 allows for an error of 4 m (EKF2_GND_EFF_DZ), which is 48 Pa.

    Input ports:
        state (13): of the plant.
        thrusts (n): of the rotors [N]; unconnected, there is no such effect.
        noise (3): see `NoisySensor`.
    Numeric parameter 0: the fault, and the additional pressure at the ground while the thrust
        carries the weight [Pa].

    Args:
        sensor: the description's record.
        home: where the world's origin lies.
        period: between samples [s].
        latency: from a sample to its delivery [s].
        rotors: how many.
        weight: of the vehicle [N].
    """

    columns = ("pressure [Pa]", "altitude [m]")
    usual = (2.0,)
    """Deviation of a common one [Pa]."""

    def __init__(
        self,
        *,
        sensor: BarometerRecord,
        home: Home,
        period: float,
        latency: float = 0.0,
        rotors: int = 0,
        weight: float = 1.0,
    ) -> None:
        super().__init__(
            noises=sensor.noises,
            period=period,
            latency=latency,
            settings=(0.0,),
        )
        self._weight = weight
        given = sensor.reference_altitude
        self._reference = home.altitude if given is None else given
        self._frame = sensor.frame
        self._p_BS = np.array(sensor.p_BS)
        self.state_input = self.DeclareVectorInputPort("state", 13)
        self.thrusts_input = self.DeclareVectorInputPort("thrusts", rotors)

    def exact(self, context: Context) -> np.ndarray:
        height = motion(self.state_input.Eval(context), self._p_BS).p_WS[2]
        return np.array([pressure_at(self._reference + height) + self._held_up(context, height)])

    def _held_up(self, context: Context, height: float) -> float:
        """Return the additional pressure near the ground [Pa]."""
        (most,) = self.settings(context)
        if most == 0.0 or not self.thrusts_input.HasValue(context):
            return 0.0
        share = float(self.thrusts_input.Eval(context).sum()) / self._weight
        return most * share * math.exp(-max(0.0, height) / GROUND_EFFECT_HEIGHT)

    def shown(self, values: np.ndarray) -> np.ndarray:
        pressure = float(values[0])
        return np.array([pressure, altitude_at(pressure) - self._reference])

    def reading(self, context: Context) -> BarometerReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, pressure, altitude = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return BarometerReading(stamp, self._frame, pressure, altitude)


@register_jitable
def pressure_at(altitude: float) -> float:
    """Return the pressure [Pa] at an altitude above the sea [m]."""
    geopotential = _EARTH_RADIUS * altitude / (_EARTH_RADIUS + altitude)
    if geopotential > _TROPOPAUSE:
        return _COLD_PRESSURE * math.exp(-(geopotential - _TROPOPAUSE) / _COLD_HEIGHT)
    return _SEA_LEVEL_PRESSURE * (1.0 - _LAPSE * geopotential / _SEA_LEVEL_TEMPERATURE) ** _EXPONENT


@register_jitable
def altitude_at(pressure: float) -> float:
    """Return the altitude above the sea [m] at which a pressure [Pa] is found."""
    pressure = max(pressure, _LEAST_PRESSURE)
    if pressure < _COLD_PRESSURE:
        geopotential = _TROPOPAUSE + _COLD_HEIGHT * math.log(_COLD_PRESSURE / pressure)
    else:
        share = (pressure / _SEA_LEVEL_PRESSURE) ** (1.0 / _EXPONENT)
        geopotential = _SEA_LEVEL_TEMPERATURE / _LAPSE * (1.0 - share)
    return _EARTH_RADIUS * geopotential / (_EARTH_RADIUS - geopotential)
