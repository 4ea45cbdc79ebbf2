"""Sensors of a few numbers: an exact measurement, and noise from a random input port.

`NoisySensor` is the system. What it measures is a `SensorInstrument`: `imu_instrument`,
`gps_instrument`, `magnetometer_instrument` and `range_finder_instrument` here, and `barometer`
beside the standard atmosphere.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue
from pydrake.geometry import QueryObject
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context

from workbench.plant.gravity import GRAVITY
from workbench.plant.home import Home
from workbench.plant.sensors import Gps, Imu, Magnetometer, Noise, RangeFinder
from workbench.systems.sensors.measuring import SensorInstrument
from workbench.systems.sensors.mounting import cross_product, sensor_motion
from workbench.systems.sensors.readings import (
    GpsReading,
    ImuReading,
    MagnetometerReading,
    RangeReading,
    Reading,
)
from workbench.systems.sensors.sampled_sensor import SampledSensor
from workbench.systems.sensors.samples import SampleTable

if TYPE_CHECKING:
    from workbench.systems.casting.caster import Caster  # slow to load

DRAWS_PER_CHANNEL = 3
"""Normal numbers of a channel for a sample."""


class NoiseModel(NamedTuple):
    """Parameters of the noise of n channels, an array (n) each.

    Attributes:
        mean: offset.
        stddev: of a sample's white noise.
        faulty: the deviation that a noisy sensor multiplies.
        bias_mean: of the bias, which is drawn once.
        bias_stddev: of the bias.
        kept: share of the drift that remains after a period.
        driven: deviation added to the drift in a period.
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
        usual: deviations of a common sensor of the kind, for a fault of a sensor without noise.
        period: between samples [s].
    """
    drifts = [noise.drift(period) for noise in noises]
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
    """Return the memory of n channels before the first sample: no biases, no drift."""
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
    """Return noisy values (n).

    Args:
        model: of the noise.
        exact: exact values (n).
        memory: see `next_memory`.
        draws: see `next_memory`.
        scale: factor of the white noise of a faulty sensor, else 1.
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
    """Return the biases (n), drawn at the first sample."""
    n = model.mean.size
    missing = np.isnan(memory[:n])
    if not missing.any():
        return memory[:n]
    drawn = model.bias_mean + model.bias_stddev * draws[2 * n :]
    return np.where(missing, drawn, memory[:n])


class NoisySensor(SampledSensor):
    """Samples an instrument, with noise on its exact values.

    Input ports:
        those of the instrument; one that is not connected has no value.
        noise (3 n): standard normal numbers, new ones for each sample; see `noise_model`.
    Memory (2 n): biases and their drift.

    Args:
        instrument: what it measures.
        period: between samples [s], a multiple of the physics step.
        latency: from a sample to its delivery [s].
    """

    def __init__(
        self, instrument: SensorInstrument, *, period: float, latency: float = 0.0
    ) -> None:
        n = len(instrument.noises)
        super().__init__(
            size=len(instrument.columns),
            period=period,
            latency=latency,
            memory=first_memory(n).tolist(),
            settings=instrument.settings,
        )
        self.instrument = instrument
        self.noise_model = noise_model(instrument.noises, instrument.usual, period)
        self._inputs = {
            name: self.DeclareVectorInputPort(name, size)
            if size
            else self.DeclareAbstractInputPort(name, AbstractValue.Make(QueryObject()))
            for name, size in instrument.inputs.items()
        }
        self._noise = self.DeclareVectorInputPort(
            "noise", DRAWS_PER_CHANNEL * n, RandomDistribution.kGaussian
        )

    def exact(self, context: Context) -> np.ndarray:
        """Return the values that noise is added to, as they are now."""
        inputs = self._inputs.items()
        values = {name: port.Eval(context) for name, port in inputs if port.HasValue(context)}
        return self.instrument.exact(values, self.settings(context))

    def truth(self, context: Context) -> np.ndarray:
        return self.instrument.shown(self.exact(context))

    def sampled(self, context: Context, scale: float) -> np.ndarray:
        values, n = self.exact(context), len(self.instrument.noises)
        memory, draws = self._memory(context), self._noise.Eval(context)
        values[:n] = noisy(self.noise_model, values[:n], memory, draws, scale)
        return self.instrument.shown(values)

    def next_memory(self, context: Context) -> np.ndarray:
        return next_memory(self.noise_model, self._memory(context), self._noise.Eval(context))

    def reading(self, context: Context) -> Reading | None:
        """Return the last delivered sample, None if there is none."""
        stamp, *values = self.delivered(context).tolist()
        return None if math.isnan(stamp) else self.instrument.reading(stamp, values)

    def recorded(self, name: str, stamps: np.ndarray, values: np.ndarray) -> SampleTable:
        return SampleTable(name, self.instrument.columns, stamps, values, self.latency)

    def _memory(self, context: Context) -> np.ndarray:
        return context.get_discrete_state(self.memory_index).CopyToVector()


def imu_instrument(sensor: Imu, period: float) -> SensorInstrument:
    """Return accelerometer and gyroscope with any mounting, and an orientation without noise.

    A sample is the specific force and the angular velocity along the axes of the sensor S, and its
    orientation. The specific force is the acceleration minus gravity: at rest it is g, upwards. The
    declared deviations are those at the sensor's own rate; other rates have the same density.
    """
    p_BS, R_BS = np.array(sensor.p_BS), np.array(sensor.R_BS)
    q_BS = RotationMatrix(R_BS).ToQuaternion()

    def exact(inputs: Mapping[str, Any], settings: Sequence[float]) -> np.ndarray:
        moves = sensor_motion(inputs["state"], p_BS)
        wdot_WB, vdot_WB = inputs["acceleration"][:3], inputs["acceleration"][3:]
        inwards = cross_product(moves.w_WB, cross_product(moves.w_WB, moves.p_BoSo_W))
        force_W = vdot_WB + cross_product(wdot_WB, moves.p_BoSo_W) + inwards
        force_W[2] += GRAVITY
        R_SW = (moves.R_WB @ R_BS).T
        q_WS = Quaternion(moves.q_WB).multiply(q_BS).wxyz()
        return np.concatenate([R_SW @ force_W, R_SW @ moves.w_WB, q_WS])

    def reading(stamp: float, values: list[float]) -> ImuReading:
        fx, fy, fz, wx, wy, wz, qw, qx, qy, qz = values
        return ImuReading(stamp, sensor.frame, (fx, fy, fz), (wx, wy, wz), (qw, qx, qy, qz))

    noises = (*sensor.linear_acceleration, *sensor.angular_velocity)
    return SensorInstrument(
        columns=(
            *(f"f_{axis} [m/s^2]" for axis in "xyz"),
            *(f"w_{axis} [rad/s]" for axis in "xyz"),
            *(f"q_WS.{axis} [1]" for axis in "wxyz"),
        ),
        usual=(0.03, 0.03, 0.03, 0.002, 0.002, 0.002),
        noises=[noise.at_rate(sensor.rate, 1.0 / period) for noise in noises],
        inputs={"state": 13, "acceleration": 6},
        exact=exact,
        reading=reading,
    )


def gps_instrument(sensor: Gps, home: Home) -> SensorInstrument:
    """Return a receiver for the antenna's position on the earth and its velocity.

    A sample is latitude, longitude, altitude above the ellipsoid, and velocity east, north and up.
    Noise is added in metres east, north and up of the home, before the conversion to angles. East,
    north and up are the world's axes everywhere: 10 km from home, they differ from the local ones
    by 0.0016 rad.
    """
    p_BS = np.array(sensor.p_BS)

    def exact(inputs: Mapping[str, Any], settings: Sequence[float]) -> np.ndarray:
        moves = sensor_motion(inputs["state"], p_BS)
        return np.concatenate([moves.p_WS, moves.v_WS])

    def shown(values: np.ndarray) -> np.ndarray:
        from workbench.plant.geodesy import geodetic  # imports pymap3d

        east, north, up = values[:3].tolist()
        return np.concatenate([geodetic((east, north, up), home), values[3:]])

    def reading(stamp: float, values: list[float]) -> GpsReading:
        latitude, longitude, altitude, east, north, up = values
        return GpsReading(stamp, sensor.frame, latitude, longitude, altitude, (east, north, up))

    return SensorInstrument(
        columns=(
            "latitude [rad]",
            "longitude [rad]",
            "altitude [m]",
            "v_east [m/s]",
            "v_north [m/s]",
            "v_up [m/s]",
        ),
        usual=(1.5, 1.5, 3.0, 0.1, 0.1, 0.2),
        noises=sensor.noises,
        inputs={"state": 13},
        exact=exact,
        reading=reading,
        shown=shown,
    )


def magnetometer_instrument(sensor: Magnetometer, home: Home) -> SensorInstrument:
    """Return a magnetometer with any mounting.

    A sample is the field along the axes of the sensor S: that of the home, see
    `earth_magnetic_field`, wherever the drone is, plus disturbances on board, for example by iron
    or by the current of a battery's wire. The settings are these disturbances along the axes of B
    (3) [T].
    """
    from workbench.plant.magnetic_field import earth_magnetic_field  # imports pymap3d

    p_BS, R_BS, field_W = np.array(sensor.p_BS), np.array(sensor.R_BS), earth_magnetic_field(home)

    def exact(inputs: Mapping[str, Any], settings: Sequence[float]) -> np.ndarray:
        field = (sensor_motion(inputs["state"], p_BS).R_WB @ R_BS).T @ field_W
        return field + R_BS.T @ settings if any(settings) else field

    def reading(stamp: float, values: list[float]) -> MagnetometerReading:
        x, y, z = values
        return MagnetometerReading(stamp, sensor.frame, (x, y, z))

    return SensorInstrument(
        columns=("B_x [T]", "B_y [T]", "B_z [T]"),
        usual=(0.5e-6, 0.5e-6, 0.5e-6),
        noises=sensor.noises,
        inputs={"state": 13},
        exact=exact,
        reading=reading,
        settings=(0.0, 0.0, 0.0),
    )


def range_finder_instrument(sensor: RangeFinder, caster: "Caster") -> SensorInstrument:
    """Return a range finder along the x axis of its frame.

    A sample is the distance: inf if nothing is within `max_range`, -inf if something is nearer than
    `min_range`, as for the lidar. Noise does not take it out of these limits. The caster has the
    scene without the vehicle itself.
    """
    p_BS, x_B = np.array(sensor.p_BS), np.array(sensor.R_BS)[:, 0]

    def exact(inputs: Mapping[str, Any], settings: Sequence[float]) -> np.ndarray:
        moves = sensor_motion(inputs["state"], p_BS)
        view = (moves.R_WB @ x_B).reshape(1, 3)
        poses = [inputs["geometry_query"].GetPoseInWorld(frame) for frame in caster.scene.frames]
        ranges = caster.cast(moves.p_WS, view, poses, sensor.max_range)
        return np.where(ranges < sensor.min_range, -math.inf, ranges)

    def shown(values: np.ndarray) -> np.ndarray:
        within = np.clip(values, sensor.min_range, sensor.max_range)
        return np.where(np.isfinite(values), within, values)

    def reading(stamp: float, values: list[float]) -> RangeReading:
        (distance,) = values
        return RangeReading(stamp, sensor.frame, distance, sensor.min_range, sensor.max_range)

    return SensorInstrument(
        columns=("distance [m]",),
        usual=(0.01,),
        noises=sensor.noises,
        inputs={"state": 13, "geometry_query": 0},
        exact=exact,
        reading=reading,
        shown=shown,
    )
