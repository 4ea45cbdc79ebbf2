"""Telemetry: the topics of a flight, sampled in publish events and kept until drained."""

import math
import time
from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, LeafSystem

from workbench.link.backplane import Published, Sampled
from workbench.systems.bridge import Bridge
from workbench.systems.frame_poses import FrameTransforms
from workbench.systems.sensors.scan_pattern import ScanPattern
from workbench.systems.topic_values import NS, Payload, Signals, TopicValues

SLOW_SHARE = 6
"""Slow topics are published with every sixth sample."""


class Telemetry(LeafSystem):
    """Publishes topics. It reads signals that exist anyway, and nothing depends on it.

    Input ports:
        signals (n): stacked as the recorder has them.
        frames: a `FrameTransforms`.
        imu, gps, lidar, magnetometer: stamp [s] and values delivered last, where there is such a
            sensor.
    """

    def __init__(
        self,
        bridge: Bridge,
        values: TopicValues,
        signals: Signals,
        *,
        period: float,
        sizes: dict[str, int],
        pattern: ScanPattern | None = None,
        sent: np.ndarray | None = None,
    ) -> None:
        """Declare the event.

        Args:
            bridge: where samples wait.
            values: makes the payloads.
            signals: their places.
            period: between samples [s].
            sizes: of the input ports of the sensors, by their kind.
            pattern: of the lidar's rays.
            sent: indices of the rays that are published.
        """
        super().__init__()
        self._bridge, self._values, self._places = bridge, values, signals
        self._pattern, self._sent = pattern, sent
        self._period = period
        size = max(place.stop for place in signals.places.values())
        self._signals = self.DeclareVectorInputPort("signals", size)
        self._frames = self.DeclareAbstractInputPort(
            "frames", AbstractValue.Make(FrameTransforms(0.0, ()))
        )
        self._sensors = {
            kind: self.DeclareVectorInputPort(kind, size) for kind, size in sizes.items()
        }
        self._stamps = dict.fromkeys(sizes, math.nan)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)

    def begin(self, start: Sequence[float]) -> None:
        """Begin with a new flight at a place in W [m]."""
        self._values.start = start
        self._stamps = dict.fromkeys(self._stamps, math.nan)

    def _publish(self, context: Context) -> None:
        if not self._bridge.wanted:
            return
        now = context.get_time()
        t_ns = round(now * NS)
        signals = self._places.named(self._signals.Eval(context))
        payloads = self._values.fast(t_ns, signals)
        if round(now / self._period) % SLOW_SHARE == 0:
            payloads += self._values.slow(signals)
            transforms = self._frames.Eval(context).transforms
            if transforms:
                payloads += self._values.frames([(each.p, each.q) for each in transforms])
        for kind in self._sensors:
            payloads += self._measured(context, kind)
        published = Published(t_ns, time.time_ns(), tuple(payloads))
        self._bridge.publish(Sampled(published, tuple(signals["state"])))

    def _measured(self, context: Context, kind: str) -> list[Payload]:
        """Return the payloads of what a sensor delivered since the last time."""
        measurement = self._sensors[kind].Eval(context)
        stamp = float(measurement[0])
        if math.isnan(stamp) or stamp == self._stamps[kind]:
            return []
        self._stamps[kind] = stamp
        if kind == "imu":
            return self._values.imu(measurement.tolist())
        if kind == "gps":
            return self._values.gps(measurement.tolist())
        if kind == "magnetometer":
            return self._values.magnetometer(measurement.tolist())
        assert self._pattern is not None and self._sent is not None
        ranges = measurement[1 : 1 + len(self._pattern.directions_S)]
        return self._values.lidar(stamp, ranges, self._pattern.directions_S, self._sent)
