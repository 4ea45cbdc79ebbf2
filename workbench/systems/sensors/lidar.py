"""The lidar: rays cast against the scene at the time of a sample."""

import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue
from pydrake.geometry import QueryObject
from pydrake.math import RotationMatrix
from pydrake.systems.framework import BasicVector, Context

from workbench.common.errors import WorkbenchError
from workbench.plant.sensors import Lidar as LidarRecord
from workbench.systems.casting.caster import Caster
from workbench.systems.noise import drawn_sensor_bias, sample_draws
from workbench.systems.sensors.mounting import sensor_motion, unit_rotation
from workbench.systems.sensors.readings import LidarScan, read_only
from workbench.systems.sensors.sampled_sensor import SampledSensor
from workbench.systems.sensors.samples import ScanStack
from workbench.systems.sensors.scan_pattern import make_scan_pattern
from workbench.systems.weak_callback import weakly

LIDAR_DEVIATION_M = 0.01
"""Deviation of a common one, from which a fault makes noise where the description has none [m]."""
POSE_SIZE = 7
"""Numbers of a pose: p_WS [m] and q_WS (w, x, y, z)."""


class LidarSensor(SampledSensor):
    """Ranges of all rays, and where the sensor was when they were measured.

    A sample (n + 7) is n ranges [m], layer by layer, then p_WS [m] and q_WS (w, x, y, z). A range
    is inf if nothing is within `max_range`, and -inf if something is nearer than `min_range`, as in
    ROS (REP 117). So a finite range is a return. All rays of a scan have the same time.

    Input ports:
        state (13): of the plant.
        geometry_query: of the scene graph, asked for the poses of what moves.
    Output ports, besides those of `SampledSensor`:
        ranges (n): of the sample delivered last [m], NaN before the first.
        scan: that sample as `LidarScan`, stamp and ranges NaN before the first; made when somebody
            reads it.
    """

    def __init__(
        self,
        *,
        sensor: LidarRecord,
        caster: Caster,
        period: float,
        latency: float = 0.0,
        seed: int = 0,
    ) -> None:
        """Declare ports, state and sampling.

        Args:
            sensor: what the description says.
            caster: of the scene without the vehicle itself.
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
            seed: of the noise, not negative.

        Raises:
            WorkbenchError: if its ranges or rays are not possible.
        """
        if not 0.0 <= sensor.min_range < sensor.max_range:
            raise WorkbenchError(
                f"sensor '{sensor.name}': ranges from {sensor.min_range:g} to "
                f"{sensor.max_range:g} m: let the first be 0 or more and the second larger"
            )
        self.sensor = sensor
        self.caster = caster
        self.pattern = make_scan_pattern(sensor)
        self._n = len(self.pattern.directions_S)
        super().__init__(size=self._n + POSE_SIZE, period=period, latency=latency)
        self._seed = seed
        self._bias = drawn_sensor_bias(sensor.noise, seed)
        self._p_BS = np.array(sensor.p_BS)
        self._R_BS = np.array(sensor.R_BS)
        self._q_BS = RotationMatrix(self._R_BS).ToQuaternion()
        self.state_input = self.DeclareVectorInputPort("state", 13)
        self.query_input = self.DeclareAbstractInputPort(
            "geometry_query", AbstractValue.Make(QueryObject())
        )
        delivery = {self.xd_ticket(), self.time_ticket()}
        self.ranges_output = self.DeclareVectorOutputPort(
            "ranges", self._n, self._calc_ranges, delivery
        )
        blank = self._scan(np.full(1 + self.size, math.nan))
        self.scan_output = self.DeclareAbstractOutputPort(
            "scan",
            lambda: AbstractValue.Make(blank),
            weakly(self._calc_scan),
            delivery,
        )

    def truth(self, context: Context) -> np.ndarray:
        moves = sensor_motion(self.state_input.Eval(context), self._p_BS)
        directions = self.pattern.directions_S @ (moves.R_WB @ self._R_BS).T
        frames = self.caster.scene.frames
        poses = []
        if frames:
            query = self.query_input.Eval(context)
            poses = [query.GetPoseInWorld(frame) for frame in frames]
        ranges = self.caster.cast(moves.p_WS, directions, poses, self.sensor.max_range)
        ranges[ranges < self.sensor.min_range] = -math.inf
        q_WS = Quaternion(moves.q_WB).multiply(self._q_BS).wxyz()
        return np.concatenate([ranges, moves.p_WS, q_WS])

    def sampled(self, context: Context, scale: float) -> np.ndarray:
        """Return a sample with noise on its returns, which never leave the sensor's limits."""
        truth, noise = self.truth(context), self.sensor.noise
        deviation = noise.stddev if scale == 1.0 else scale * (noise.stddev or LIDAR_DEVIATION_M)
        offset = noise.mean + self._bias
        grain = self.sensor.resolution or noise.precision
        if deviation == 0.0 and offset == 0.0 and grain == 0.0:
            return truth
        ranges = truth[: self._n].copy()
        seen = np.isfinite(ranges)
        if deviation > 0.0:
            number = round(context.get_time() / self.period)
            normal = sample_draws(self._seed, number).standard_normal(self._n)
            ranges += offset + deviation * normal
        else:
            ranges += offset
        if grain > 0.0:
            ranges = grain * np.round(ranges / grain)
        within = np.clip(ranges, self.sensor.min_range, self.sensor.max_range)
        return np.concatenate([np.where(seen, within, ranges), truth[self._n :]])

    def reading(self, context: Context) -> LidarScan | None:
        """Return the sample delivered last, None if none was."""
        sample = self.delivered(context)
        return None if math.isnan(sample[0]) else self._scan(sample)

    def recorded(self, name: str, stamps: np.ndarray, values: np.ndarray) -> ScanStack:
        ranges, p_WS, q_WS = np.split(values, [self._n, self._n + 3], axis=1)
        return ScanStack(
            sensor=name,
            azimuths=self.pattern.azimuths,
            elevations=self.pattern.elevations,
            stamps=stamps,
            ranges=ranges.reshape(-1, *self.pattern.shape),
            p_WS=p_WS,
            q_WS=q_WS,
            latency=self.latency,
        )

    def _scan(self, sample: np.ndarray) -> LidarScan:
        """Return what is delivered (1 + size) as a record."""
        ranges, p_WS, q_WS = np.split(sample[1:], [self._n, self._n + 3])
        return LidarScan(
            stamp=float(sample[0]),
            frame=self.sensor.frame,
            p_WS=read_only(p_WS),
            R_WS=read_only(unit_rotation(q_WS)),
            pattern=self.pattern,
            ranges=read_only(ranges.reshape(self.pattern.shape)),
        )

    def _calc_ranges(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.delivered(context)[1 : 1 + self._n])

    def _calc_scan(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._scan(self.delivered(context)))
