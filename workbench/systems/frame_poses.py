"""All frames as one message on a port, in the form of ROS's tf2."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from workbench.plant.frame_tree import FrameTree, Transform
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.weak_callback import weakly

TOPIC = "/dh_drone/frames"
"""Where `FrameTransforms` go."""


@dataclass(frozen=True)
class FrameTransforms:
    """Every frame's pose in its parent's at a time [s], as in ROS's tf2_msgs/TFMessage."""

    time: float
    transforms: tuple[Transform, ...]

    def __deepcopy__(self, memo: dict[int, object]) -> "FrameTransforms":
        """Return itself, because it is immutable: Drake copies the values of ports."""
        return self


class FramePoses(DiscreteSystem):
    """The tree of frames at the plant's state; computed only when it is read.

    Input port:
        state (13): of the plant.
    Output port:
        frames: a `FrameTransforms`.
    """

    def __init__(self, tree: FrameTree) -> None:
        super().__init__()
        self._tree = tree
        self._state = self.DeclareVectorInputPort("state", 13)
        self.frames_output = self.DeclareAbstractOutputPort(
            "frames",
            lambda: Value(FrameTransforms(0.0, ())),
            weakly(self._calc_frames),
            {self.input_port_ticket(self._state.get_index()), self.time_ticket()},
        )

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Parent and child of every frame, in the order of the transforms."""
        return [(frame.parent, frame.name) for frame in self._tree.frames]

    def pose(self, context: Context, a: str, b: str) -> RigidTransform:
        """Return X_AB, the pose of frame B in frame A.

        Raises:
            WorkbenchError: if there is no frame of a name.
        """
        return self._tree.X(a, b, self._pose_of_base(context), context.get_time())

    def transforms(self, context: Context) -> FrameTransforms:
        """Return all of them, as they are now."""
        message: FrameTransforms = self.frames_output.Eval(context)
        return message

    def _pose_of_base(self, context: Context) -> RigidTransform:
        state = self._state.Eval(context)
        q_WB = Quaternion(state[0:4] / np.linalg.norm(state[0:4]))
        return RigidTransform(q_WB, state[4:7])

    def _calc_frames(self, context: Context, output: Any) -> None:
        time = context.get_time()
        transforms = self._tree.transforms(self._pose_of_base(context), time)
        output.set_value(FrameTransforms(time, transforms))
