"""The range finder: the distance to the nearest surface along its axis."""

import math

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import QueryObject
from pydrake.systems.framework import Context

from workbench.plant.sensors import RangeFinder as RangeFinderRecord
from workbench.systems.casting.caster import Caster
from workbench.systems.sensors.mounting import motion
from workbench.systems.sensors.noisy_sensor import NoisySensor
from workbench.systems.sensors.readings import RangeReading

COLUMNS = ("distance [m]",)
"""What a sample's numbers are."""

USUAL = (0.01,)
"""Deviation of a common one [m]."""


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

    def __init__(
        self, *, sensor: RangeFinderRecord, caster: Caster, period: float, latency: float = 0.0
    ) -> None:
        super().__init__(size=1, noises=sensor.noises, usual=USUAL, period=period, latency=latency)
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
