"""Sensors of a few numbers, with noise from a random input port.

They are the IMU, the GPS receiver, the magnetometer and the range finder. The barometer is in
`barometer`, with the standard atmosphere.
"""

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue
from pydrake.geometry import QueryObject
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context

from workbench.plant.gravity import GRAVITY
from workbench.plant.home import Home
from workbench.plant.sensors import Gps as GpsRecord
from workbench.plant.sensors import Imu as ImuRecord
from workbench.plant.sensors import Magnetometer as MagnetometerRecord
from workbench.plant.sensors import Noise
from workbench.plant.sensors import RangeFinder as RangeFinderRecord
from workbench.systems.sensors.mounting import cross, motion
from workbench.systems.sensors.readings import (
    GpsReading,
    ImuReading,
    MagnetometerReading,
    RangeReading,
)
from workbench.systems.sensors.sampled_sensor import SampledSensor

if TYPE_CHECKING:
    from workbench.systems.casting.caster import Caster  # slow to load

DRAWS = 3
"""Normal numbers that a channel takes for a sample."""


class NoiseModel(NamedTuple):
    """What the functions below need, an array (n) each.

    Attributes:
        mean: offset.
        stddev: of a sample's white noise.
        faulty: that of which a noisy sensor has a multiple.
        bias_mean: of the bias drawn once.
        bias_stddev: of the bias drawn once.
        kept: share of the drift that is left after a period.
        driven: deviation of what a period adds to it.
        precision: to which samples are rounded, 0 for none.
    """

    mean: np.ndarray
    stddev: np.ndarray
    faulty: np.ndarray
    bias_mean: np.ndarray
    bias_stddev: np.ndarray
    kept: np.ndarray
    driven: np.ndarray
    precision: np.ndarray


def noise_model(noises: Sequence[Noise], usual: Sequence[float], period: float) -> NoiseModel:
    """Return the noise of channels that are sampled every `period` [s]; `Noise` has the formulas.

    A sample takes three normal numbers for each of its n channels: n for white noise, n for the
    driven drift, n for the bias that is drawn once.

    Args:
        noises: of the channels.
        usual: deviations of a common sensor of the kind, from which a fault makes noise where the
            description has none.
        period: between samples [s].
    """
    drifts = [_drift(noise, period) for noise in noises]
    return NoiseModel(
        mean=np.array([noise.mean for noise in noises]),
        stddev=np.array([noise.stddev for noise in noises]),
        faulty=np.array([n.stddev or common for n, common in zip(noises, usual, strict=True)]),
        bias_mean=np.array([noise.bias_mean for noise in noises]),
        bias_stddev=np.array([noise.bias_stddev for noise in noises]),
        kept=np.array([kept for kept, _ in drifts]),
        driven=np.array([driven for _, driven in drifts]),
        precision=np.array([noise.precision for noise in noises]),
    )


def first_memory(n: int) -> np.ndarray:
    """Return what is remembered of n channels before their first sample: no biases, no drift."""
    return np.concatenate([np.full(n, math.nan), np.zeros(n)])


def next_memory(model: NoiseModel, memory: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return the biases and the drift after a sample (2 n).

    Args:
        model: of the noise.
        memory: biases, NaN before they are drawn, and drift at the sample (2 n).
        draws: standard normal numbers (3 n).
    """
    n = model.mean.size
    drift = model.kept * memory[n:] + model.driven * draws[n : 2 * n]
    return np.concatenate((_biases(model, memory, draws), drift))


def noisy(
    model: NoiseModel, exact: np.ndarray, memory: np.ndarray, draws: np.ndarray, scale: float
) -> np.ndarray:
    """Return what is measured (n).

    Args:
        model: of the noise.
        exact: what is to be measured (n).
        memory: see `next_memory`.
        draws: see `next_memory`.
        scale: 1, or so many times its usual deviation has the white noise of a faulty sensor.
    """
    n = model.mean.size
    deviation = model.stddev if scale == 1.0 else scale * model.faulty
    bias = _biases(model, memory, draws) + memory[n:]
    values = exact + (model.mean + bias + deviation * draws[:n])
    if not model.precision.any():
        return values
    step = np.where(model.precision > 0.0, model.precision, 1.0)
    return np.where(model.precision > 0.0, step * np.round(values / step), values)


def _biases(model: NoiseModel, memory: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return the biases remembered (n), or at the first sample those drawn."""
    n = model.mean.size
    drawn = model.bias_mean + model.bias_stddev * draws[2 * n :]
    return np.where(np.isnan(memory[:n]), drawn, memory[:n])


def _drift(noise: Noise, period: float) -> tuple[float, float]:
    """Return the share of the drift that remains after a period, and the deviation that is added.

    The drift is a first-order Gauss-Markov process with time constant T and driving density s:
    after dt it is exp(-dt / T) times itself plus a normal number of variance
    s² T / 2 (1 - exp(-2 dt / T)). Source: Maybeck, Stochastic Models, Estimation, and Control,
    volume 1, section 4.9; gz-sensors and RotorS use the same.
    """
    time, density = noise.dynamic_bias_correlation_time, noise.dynamic_bias_stddev
    if time == 0.0:
        return 1.0, 0.0
    variance = -0.5 * density**2 * time * math.expm1(-2.0 * period / time)
    return math.exp(-period / time), math.sqrt(variance)


class NoisySensor(SampledSensor):
    """Adds noise to exact values, then says what a sensor shows of them.

    Input port:
        noise (3 n): standard normal numbers, new ones for each sample; see `noise_model`.
    Memory (2 n): biases and their drift.
    """

    columns: tuple[str, ...]
    """Names and units of a sample's numbers (size)."""
    usual: tuple[float, ...]
    """Deviations of a common sensor of the kind (n)."""

    def __init__(
        self,
        *,
        noises: Sequence[Noise],
        period: float,
        latency: float,
        settings: Sequence[float] = (),
    ) -> None:
        """Declare what `SampledSensor` has, and the port of the noise.

        Args:
            noises: of the first n exact values; any others have none.
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
            settings: see `SampledSensor`.
        """
        n = len(noises)
        super().__init__(
            size=len(self.columns),
            period=period,
            latency=latency,
            memory=first_memory(n).tolist(),
            settings=settings,
        )
        self.noise_model = noise_model(noises, self.usual, period)
        self.noise_input = self.DeclareVectorInputPort(
            "noise", DRAWS * n, RandomDistribution.kGaussian
        )

    @abstractmethod
    def exact(self, context: Context) -> np.ndarray:
        """Return the values that noise is added to, as they are now."""

    def shown(self, values: np.ndarray) -> np.ndarray:
        """Return a sample (size) from exact or noisy values."""
        return values

    def truth(self, context: Context) -> np.ndarray:
        return self.shown(self.exact(context))

    def sampled(self, context: Context, scale: float) -> np.ndarray:
        values = self.exact(context)
        n = self.noise_model.mean.size
        values[:n] = noisy(
            self.noise_model,
            values[:n],
            self._memory(context),
            self.noise_input.Eval(context),
            scale,
        )
        return self.shown(values)

    def next_memory(self, context: Context) -> np.ndarray:
        draws = self.noise_input.Eval(context)
        return next_memory(self.noise_model, self._memory(context), draws)

    def _memory(self, context: Context) -> np.ndarray:
        return context.get_discrete_state(self.memory_index).CopyToVector()


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

    columns = (
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
    usual = (0.03, 0.03, 0.03, 0.002, 0.002, 0.002)
    """Deviations of a common one along x, y, z: specific force [m/s²], angular velocity [rad/s]."""

    def __init__(self, *, sensor: ImuRecord, period: float, latency: float = 0.0) -> None:
        noises = (*sensor.linear_acceleration, *sensor.angular_velocity)
        super().__init__(
            noises=[noise.at_rate(sensor.rate, 1.0 / period) for noise in noises],
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

    columns = (
        "latitude [rad]",
        "longitude [rad]",
        "altitude [m]",
        "v_east [m/s]",
        "v_north [m/s]",
        "v_up [m/s]",
    )
    usual = (1.5, 1.5, 3.0, 0.1, 0.1, 0.2)
    """Deviations of a common one: position [m] and velocity [m/s], east, north and up."""

    def __init__(
        self, *, sensor: GpsRecord, home: Home, period: float, latency: float = 0.0
    ) -> None:
        super().__init__(
            noises=sensor.noises,
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
        from workbench.plant.geodesy import geodetic  # imports pymap3d

        east, north, up = values[:3].tolist()
        return np.concatenate([geodetic((east, north, up), self._home), values[3:]])

    def reading(self, context: Context) -> GpsReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, latitude, longitude, altitude, east, north, up = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return GpsReading(stamp, self._frame, latitude, longitude, altitude, (east, north, up))


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

    columns = ("B_x [T]", "B_y [T]", "B_z [T]")
    usual = (0.5e-6, 0.5e-6, 0.5e-6)
    """Deviations of a common one along x, y, z [T]."""

    def __init__(
        self, *, sensor: MagnetometerRecord, home: Home, period: float, latency: float = 0.0
    ) -> None:
        from workbench.plant.magnetic_field import magnetic_field  # imports pymap3d

        super().__init__(
            noises=sensor.noises,
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


class RangeFinder(NoisySensor):
    """Measures along one ray, the x axis of its frame.

    A sample (1) is the distance [m]: inf where nothing is within `max_range`, -inf where something
    is nearer than `min_range`, as the lidar has it. Noise does not take it out of these limits.

    Input ports:
        state (13): of the plant.
        geometry_query: of the scene graph, asked for the poses of what moves.
        noise (3): see `NoisySensor`.

    Args:
        sensor: the description's record.
        caster: of the scene without the vehicle itself.
        period: between samples [s].
        latency: from a sample to its delivery [s].
    """

    columns = ("distance [m]",)
    usual = (0.01,)
    """Deviation of a common one [m]."""

    def __init__(
        self, *, sensor: RangeFinderRecord, caster: "Caster", period: float, latency: float = 0.0
    ) -> None:
        super().__init__(noises=sensor.noises, period=period, latency=latency)
        self._sensor = sensor
        self._caster = caster
        self._p_BS = np.array(sensor.p_BS)
        self._x_B = np.array(sensor.R_BS)[:, 0]
        self.state_input = self.DeclareVectorInputPort("state", 13)
        self.query_input = self.DeclareAbstractInputPort(
            "geometry_query", AbstractValue.Make(QueryObject())
        )

    def exact(self, context: Context) -> np.ndarray:
        moves = motion(self.state_input.Eval(context), self._p_BS)
        view = (moves.R_WB @ self._x_B).reshape(1, 3)
        frames, poses = self._caster.scene.frames, []
        if frames:
            query = self.query_input.Eval(context)
            poses = [query.GetPoseInWorld(frame) for frame in frames]
        ranges, _ = self._caster.cast(moves.p_WS, view, poses, self._sensor.max_range)
        return np.where(ranges < self._sensor.min_range, -math.inf, ranges)

    def shown(self, values: np.ndarray) -> np.ndarray:
        within = np.clip(values, self._sensor.min_range, self._sensor.max_range)
        return np.where(np.isfinite(values), within, values)

    def reading(self, context: Context) -> RangeReading | None:
        """Return the sample delivered last, None if none was."""
        stamp, distance = self.delivered(context).tolist()
        if math.isnan(stamp):
            return None
        return RangeReading(
            stamp, self._sensor.frame, distance, self._sensor.min_range, self._sensor.max_range
        )
