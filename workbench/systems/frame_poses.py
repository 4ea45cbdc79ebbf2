"""All frames as one message on a port, in the form of ROS's tf2."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from workbench.plant.frame_tree import FrameTree, Transform
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.weak_callback import weakly


@dataclass(frozen=True)
class FrameTransforms:
    """Every frame's pose in its parent's at a time [s], as in ROS's tf2_msgs/TFMessage."""

    time: float
    transforms: tuple[Transform, ...]

    def __deepcopy__(self, memo: dict[int, object]) -> "FrameTransforms":
        """Return itself, because it is immutable: Drake copies the values of ports."""
        return self


class JointFrame(NamedTuple):
    """A frame F that a joint moves in its parent P, and the bodies L that have the two.

    Attributes:
        name: of the frame.
        parent: index of the body that has P.
        X_LP: pose of P on it.
        body: index of the body that has F.
        X_LF: pose of F on it.
    """

    name: str
    parent: int
    X_LP: RigidTransform
    body: int
    X_LF: RigidTransform


class FramePoses(DiscreteSystem):
    """The tree of frames at the plant's state; computed only when it is read.

    Input ports:
        state (13): of the base link.
        body_poses: of all bodies, from the plant; only where joints move frames.
    Output port:
        frames: a `FrameTransforms`.

    Args:
        tree: of the frames.
        moved: of each frame that a joint moves.
    """

    def __init__(self, tree: FrameTree, moved: Sequence[JointFrame] = ()) -> None:
        super().__init__()
        self._tree, self._moved = tree, moved
        self._state = self.DeclareVectorInputPort("state", 13)
        needs = {self.input_port_ticket(self._state.get_index()), self.time_ticket()}
        if moved:
            bodies = Value[list[RigidTransform]]()
            self._bodies = self.DeclareAbstractInputPort("body_poses", bodies)
            needs.add(self.input_port_ticket(self._bodies.get_index()))
        self.frames_output = self.DeclareAbstractOutputPort(
            "frames",
            lambda: Value(FrameTransforms(0.0, ())),
            weakly(self._calc_frames),
            needs,
        )

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Parent and child of every frame, in the order of the transforms."""
        return [(frame.parent, frame.name) for frame in self._tree.frames]

    @property
    def moving(self) -> list[str]:
        """Names of the frames that move in their parents."""
        return [frame.name for frame in self._tree.frames if frame.motion]

    @property
    def optical(self) -> tuple[str, ...]:
        """Names of the optical frames, in the order of the vehicle's depth cameras."""
        return self._tree.optical

    def pose(self, context: Context, a: str, b: str) -> RigidTransform:
        """Return X_AB, the pose of frame B in frame A.

        Raises:
            WorkbenchError: if there is no frame of a name.
        """
        tree = self._posed(context)
        return tree.X(a, b, self._pose_of_base(context), context.get_time())

    def transforms(self, context: Context) -> FrameTransforms:
        """Return all of them, as they are now."""
        message: FrameTransforms = self.frames_output.Eval(context)
        return message

    def _posed(self, context: Context) -> FrameTree:
        """Return the tree as its joints stand now."""
        if not self._moved:
            return self._tree
        X_WL = self._bodies.Eval(context)
        return self._tree.posed(
            {
                each.name: (X_WL[each.parent] @ each.X_LP).InvertAndCompose(
                    X_WL[each.body] @ each.X_LF
                )
                for each in self._moved
            }
        )

    def _pose_of_base(self, context: Context) -> RigidTransform:
        state = self._state.Eval(context)
        q_WB = Quaternion(state[0:4] / np.linalg.norm(state[0:4]))
        return RigidTransform(q_WB, state[4:7])

    def _calc_frames(self, context: Context, output: AbstractValue) -> None:
        time = context.get_time()
        transforms = self._posed(context).transforms(self._pose_of_base(context), time)
        output.set_value(FrameTransforms(time, transforms))
