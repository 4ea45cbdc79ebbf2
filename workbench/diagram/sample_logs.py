"""Logs of what sensors deliver, for those whose samples are to be kept."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from workbench.diagram.sensing import Mounted, Sensing
from workbench.systems.sensors.sampled_sensor import SampledSensor


@dataclass(frozen=True)
class SampleLog:
    """The log of a sensor."""

    mounted: Mounted
    system: SampledSensor
    sink: VectorLogSink

    def rows(self, root_context: Context) -> np.ndarray:
        """Return stamp [s] and values of every sample delivered so far, each once (N, 1 + size)."""
        # A log at a time comes before the update at that time, hence the present besides.
        present = self.system.delivered(self.system.GetMyContextFromRoot(root_context))
        rows = np.vstack([self.sink.FindLog(root_context).data().T, present])
        known = rows[~np.isnan(rows[:, 0])]
        first = np.diff(known[:, 0], prepend=-np.inf) > 0.0  # a silent sensor repeats its last
        return known[first].copy()


def add_sample_logs(builder: DiagramBuilder, sensing: Sensing) -> tuple[SampleLog, ...]:
    """Add a log for each sensor whose samples are kept; pictures are too large for one."""
    logs = []
    for mounted in sensing.mounted:
        system = mounted.system
        if mounted.choice.kept and isinstance(system, SampledSensor):
            sink = LogVectorOutput(system.measurement_output, builder, mounted.choice.period)
            sink.set_name(f"{system.get_name()}_log")
            logs.append(SampleLog(mounted, system, sink))
    return tuple(logs)
