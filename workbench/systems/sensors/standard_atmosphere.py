"""Pressure and altitude in the standard atmosphere, up to 20 km.

ISO 2533:1975, whose figures up to there are those of the U.S. Standard Atmosphere 1976 and of
ICAO: temperature falls by 6.5 K a kilometre up to 11 km, and stays there. Altitudes are geometric;
geopotential ones, in which gravity counts as constant, only occur inside.
"""

import math

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
