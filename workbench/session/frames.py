"""The frames of a flown flight: any-to-any transform at any of its times."""

from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.frame_tree import FrameTree
from workbench.session.recording import Recording

_LATE = 1e-9
"""A time this little outside of a flight is its end [s]."""


@dataclass(frozen=True)
class FlightFrames:
    """A tree of frames with the flight that moves its base link."""

    tree: FrameTree
    recording: Recording

    def X(self, a: str, b: str, time: float) -> RigidTransform:
        """Return X_AB at a time of the flight [s], see `FrameTree.X`.

        Raises:
            WorkbenchError: if there is no such frame, or the flight has no such time.
        """
        return self.tree.X(a, b, self.X_WB(time), time)

    def X_WB(self, time: float) -> RigidTransform:
        """Return the pose of the base link at a time of the flight [s].

        Between samples the position goes straight and the orientation turns evenly about one axis
        (slerp). With h between samples that is off by up to h²/8 times the acceleration there, and
        times the angular acceleration: at 1/128 s, 0.08 mm for 10 m/s² and 0.4 mrad for 50 rad/s².

        Raises:
            WorkbenchError: if the flight has no such time.
        """
        times = self.recording.time
        if not len(times):
            raise WorkbenchError("the flight has no samples yet: fly it first")
        start, end = float(times[0]), float(times[-1])
        if not start - _LATE <= time <= end + _LATE:
            raise WorkbenchError(
                f"the flight has no time {time:g} s: give one from {start:g} to {end:g} s"
            )
        after = int(np.clip(np.searchsorted(times, time), min(1, len(times) - 1), len(times) - 1))
        before = max(0, after - 1)
        step = float(times[after] - times[before])
        share = (min(max(time, start), end) - float(times[before])) / step if step else 0.0
        p_WB, q_WB = self.recording.p_WB, self.recording.q_WB
        turned = Quaternion(q_WB[before]).slerp(share, Quaternion(q_WB[after]))
        return RigidTransform(turned, (1.0 - share) * p_WB[before] + share * p_WB[after])
