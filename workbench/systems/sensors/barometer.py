"""The barometer: air pressure, and the height above home that follows from it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.plant.home import Home
from workbench.plant.sensors import Barometer
from workbench.systems.sensors.measuring import SensorInstrument
from workbench.systems.sensors.mounting import sensor_motion
from workbench.systems.sensors.readings import BarometerReading

_SEA_LEVEL_PRESSURE = 101_325.0
_SEA_LEVEL_TEMPERATURE = 288.15
_LAPSE_RATE = 0.0065
_STANDARD_GRAVITY = 9.80665
_GAS_CONSTANT = 287.05287
_EARTH_RADIUS = 6_356_766.0
_TROPOPAUSE = 11_000.0
_EXPONENT = _STANDARD_GRAVITY / (_GAS_CONSTANT * _LAPSE_RATE)
_TROPOPAUSE_TEMPERATURE = _SEA_LEVEL_TEMPERATURE - _LAPSE_RATE * _TROPOPAUSE
_TROPOPAUSE_PRESSURE = (
    _SEA_LEVEL_PRESSURE * (_TROPOPAUSE_TEMPERATURE / _SEA_LEVEL_TEMPERATURE) ** _EXPONENT
)
_STRATOSPHERE_SCALE_M = _GAS_CONSTANT * _TROPOPAUSE_TEMPERATURE / _STANDARD_GRAVITY
"""Height in which pressure falls by the factor e above the tropopause [m]."""
GROUND_EFFECT_HEIGHT_M = 0.5
"""Height in which the pressure added near the ground falls by the factor e [m]; PX4 allows for it
up to this height (EKF2_GND_MAX_HGT)."""
_MIN_PRESSURE_PA = 1.0
"""Smallest pressure that is converted to an altitude [Pa]; a faulty barometer may show less."""


def barometer_instrument(
    sensor: Barometer, home: Home, rotors: int = 0, weight: float = 1.0
) -> SensorInstrument:
    """Return a barometer in the standard atmosphere, with noise on the pressure.

    A sample is the pressure, and the altitude above home at which the standard atmosphere has it.
    The world's origin is as high above the sea as the home above the ellipsoid, or as the
    description's reference altitude says.

    Near the ground the rotors' downwash raises the pressure, so a barometer shows too little
    height. The effect depends on the frame and on the sensor's position, so it is a setting, and it
    is proportional to the thrust: the additional pressure at the ground while the thrust carries
    the weight [Pa]. PX4 allows for an error of 4 m (EKF2_GND_EFF_DZ), which is 48 Pa.

    Args:
        sensor: the description's record.
        home: location of the world's origin.
        rotors: number of rotors; without their thrusts there is no such effect.
        weight: of the vehicle [N].
    """
    p_BS = np.array(sensor.p_BS)
    given = sensor.reference_altitude
    reference = home.altitude if given is None else given

    def exact(inputs: Mapping[str, Any], settings: Sequence[float]) -> np.ndarray:
        height = sensor_motion(inputs["state"], p_BS).p_WS[2]
        (most,) = settings
        added = 0.0
        if most and "thrusts" in inputs:
            share = float(inputs["thrusts"].sum()) / weight
            added = most * share * math.exp(-max(0.0, height) / GROUND_EFFECT_HEIGHT_M)
        return np.array([pressure_at(reference + height) + added])

    def shown(values: np.ndarray) -> np.ndarray:
        pressure = float(values[0])
        return np.array([pressure, altitude_at(pressure) - reference])

    def reading(stamp: float, values: list[float]) -> BarometerReading:
        pressure, altitude = values
        return BarometerReading(stamp, sensor.frame, pressure, altitude)

    return SensorInstrument(
        columns=("pressure [Pa]", "altitude [m]"),
        usual=(2.0,),
        noises=sensor.noises,
        inputs={"state": 13} | ({"thrusts": rotors} if rotors else {}),
        exact=exact,
        reading=reading,
        shown=shown,
        settings=(0.0,),
    )


@register_jitable
def pressure_at(altitude: float) -> float:
    """Return the pressure [Pa] at an altitude above the sea [m]."""
    geopotential = _EARTH_RADIUS * altitude / (_EARTH_RADIUS + altitude)
    if geopotential > _TROPOPAUSE:
        return _TROPOPAUSE_PRESSURE * math.exp(
            -(geopotential - _TROPOPAUSE) / _STRATOSPHERE_SCALE_M
        )
    return (
        _SEA_LEVEL_PRESSURE
        * (1.0 - _LAPSE_RATE * geopotential / _SEA_LEVEL_TEMPERATURE) ** _EXPONENT
    )


@register_jitable
def altitude_at(pressure: float) -> float:
    """Return the altitude above the sea [m] with a pressure [Pa]."""
    pressure = max(pressure, _MIN_PRESSURE_PA)
    if pressure < _TROPOPAUSE_PRESSURE:
        geopotential = _TROPOPAUSE + _STRATOSPHERE_SCALE_M * math.log(
            _TROPOPAUSE_PRESSURE / pressure
        )
    else:
        share = (pressure / _SEA_LEVEL_PRESSURE) ** (1.0 / _EXPONENT)
        geopotential = _SEA_LEVEL_TEMPERATURE / _LAPSE_RATE * (1.0 - share)
    return _EARTH_RADIUS * geopotential / (_EARTH_RADIUS - geopotential)
