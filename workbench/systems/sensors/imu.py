"""The inertial measurement unit: specific force, angular velocity, orientation."""

import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context

from workbench.plant.gravity import GRAVITY
from workbench.plant.sensors import Imu as ImuRecord
from workbench.systems.sensors.mounting import cross, motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import ImuReading

COLUMNS = (
    "f_x [m/s^2]",
    "f_y [m/s^2]",
    "f_z [m/s^2]",
    "w_x [rad/s]",
    "w_y [rad/s]",
    "w_z [rad/s]",
    "q_WS.w [1]",
    "q_WS.x [1]",
    "q_WS.y [1]",
    "q_WS.z [1]",
)
"""What a sample's numbers are."""

USUAL = (0.03, 0.03, 0.03, 0.002, 0.002, 0.002)
"""Deviations of a common one: specific force [m/s²] and angular velocity [rad/s] along x, y, z."""


class Imu(NoisySensor):
    """Accelerometer and gyroscope with any mounting, and an orientation without noise.

    A sample (10) is the specific force [m/s²] and the angular velocity [rad/s] along the axes of
    the sensor S, and its orientation q_WS (w, x, y, z). The specific force is the acceleration
    minus gravity: at rest it is g, upwards.

    Input ports:
        state (13): of the plant.
        acceleration (6): wdot_WB_W [rad/s²], vdot_WB_W [m/s²].
        noise (18): see `NoisySensor`.

    Args:
        sensor: the description's record; its deviations are those of a sample at its own rate,
            and at another rate those of the same density.
        period: between samples [s].
        latency: from a sample to its delivery [s].
    """

    def __init__(self, *, sensor: ImuRecord, period: float, latency: float = 0.0) -> None:
        noises = (*sensor.linear_acceleration, *sensor.angular_velocity)
        super().__init__(
            size=10,
            noises=[noise.at_rate(sensor.rate, 1.0 / period) for noise in noises],
            usual=USUAL,
            period=period,
            latency=latency,
        )
        self._frame = sensor.frame
        self._p_BS = np.array(sensor.p_BS)
        self._R_BS = np.array(sensor.R_BS)
        self._q_BS = RotationMatrix(self._R_BS).ToQuaternion()
        self.state_input = self.DeclareVectorInputPort("state", 13)
        self.acceleration_input = self.DeclareVectorInputPort("acceleration", 6)

    def exact(self, context: Context) -> np.ndarray:
        moves = motion(self.state_input.Eval(context), self._p_BS)
        acceleration = self.acceleration_input.Eval(context)
        wdot_WB, vdot_WB = acceleration[:3], acceleration[3:]
        inwards = cross(moves.w_WB, cross(moves.w_WB, moves.p_BoSo_W))
        force_W = vdot_WB + cross(wdot_WB, moves.p_BoSo_W) + inwards
        force_W[2] += GRAVITY
        R_SW = (moves.R_WB @ self._R_BS).T
        q_WS = Quaternion(moves.q_WB).multiply(self._q_BS).wxyz()
        return np.concatenate([R_SW @ force_W, R_SW @ moves.w_WB, q_WS])

    def reading(self, context: Context) -> ImuReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, fx, fy, fz, wx, wy, wz, qw, qx, qy, qz = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return ImuReading(stamp, self._frame, (fx, fy, fz), (wx, wy, wz), (qw, qx, qy, qz))
