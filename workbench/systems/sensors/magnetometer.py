"""The magnetometer: the earth's magnetic field along the axes of the sensor."""

import math

import numpy as np
from pydrake.systems.framework import Context

from workbench.plant.home import Home
from workbench.plant.magnetic_field import magnetic_field
from workbench.plant.sensors import Magnetometer as MagnetometerRecord
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import MagnetometerReading

COLUMNS = ("B_x [T]", "B_y [T]", "B_z [T]")
"""What a sample's numbers are."""

USUAL = (0.5e-6, 0.5e-6, 0.5e-6)
"""Deviations of a common one along x, y, z [T]."""


class Magnetometer(NoisySensor):
    """Measures the magnetic field, with any mounting.

    A sample (3) is the field along the axes of the sensor S [T]: that of the home, see
    `magnetic_field`, wherever the drone is, plus disturbances on board.

    Input ports:
        state (13): of the plant.
        noise (9): see `NoisySensor`.
    Numeric parameter 0: the fault, and the field of on-board disturbances along the axes of B
        (3) [T], such as iron or the current of a battery's wire.

    Args:
        sensor: the description's record.
        home: where the world's origin lies.
        period: between samples [s].
        latency: from a sample to its delivery [s].
    """

    def __init__(
        self, *, sensor: MagnetometerRecord, home: Home, period: float, latency: float = 0.0
    ) -> None:
        super().__init__(
            size=3,
            noises=sensor.noises,
            usual=USUAL,
            period=period,
            latency=latency,
            settings=(0.0, 0.0, 0.0),
        )
        self._frame = sensor.frame
        self._p_BS = np.array(sensor.p_BS)
        self._R_BS = np.array(sensor.R_BS)
        self._field_W = magnetic_field(home)
        self.state_input = self.DeclareVectorInputPort("state", 13)

    def exact(self, context: Context) -> np.ndarray:
        R_WB = motion(self.state_input.Eval(context), self._p_BS).R_WB
        disturbance = self.settings(context)
        field = (R_WB @ self._R_BS).T @ self._field_W
        return field + self._R_BS.T @ disturbance if any(disturbance) else field

    def reading(self, context: Context) -> MagnetometerReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, x, y, z = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return MagnetometerReading(stamp, self._frame, (x, y, z))
