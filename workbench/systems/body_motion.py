"""The motion of chosen bodies, from the plant's ports."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform_
from pydrake.multibody.math import SpatialAcceleration_, SpatialVelocity_
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import BasicVector, Context, LeafSystem, LeafSystem_

from workbench.systems.convertible import convertible


@convertible
def BodyMotion_(T: type) -> type[LeafSystem]:
    """The states of bodies that hang on joints, in the form of that of a free body.

    Input ports:
        body_poses, spatial_velocities: of all bodies, from the plant.
        spatial_accelerations: likewise; needed by the second output only.
    Output ports:
        state (13 k): of each body L: q_WL (w, x, y, z), p_WL [m], w_WL_W [rad/s], v_WL_W [m/s].
        acceleration (6 k): angular acceleration [rad/s²] and that of the origin [m/s²] in W.

    Args:
        T: the scalar type.
        bodies: indices of the bodies (k).
    """

    class Impl(LeafSystem_[T]):
        def declare(self, *, bodies: Sequence[BodyIndex]) -> None:
            self._bodies = tuple(bodies)
            poses = Value[list[RigidTransform_[T]]]()
            velocities = Value[list[SpatialVelocity_[T]]]()
            self._poses = self.DeclareAbstractInputPort("body_poses", poses)
            self._velocities = self.DeclareAbstractInputPort("spatial_velocities", velocities)
            self._accelerations = self.DeclareAbstractInputPort(
                "spatial_accelerations", Value[list[SpatialAcceleration_[T]]]()
            )
            self.DeclareVectorOutputPort(
                "acceleration",
                6 * len(self._bodies),
                self._calc_acceleration,
                {self._accelerations.ticket()},
            )
            self.DeclareVectorOutputPort(
                "state",
                13 * len(self._bodies),
                self._calc_state,
                {self._poses.ticket(), self._velocities.ticket()},
            )

        def _calc_acceleration(self, context: Context, output: BasicVector) -> None:
            accelerations = self._accelerations.Eval(context)
            chosen = [accelerations[int(body)] for body in self._bodies]
            parts = [part for A in chosen for part in (A.rotational(), A.translational())]
            output.SetFromVector(np.concatenate(parts))

        def _calc_state(self, context: Context, output: BasicVector) -> None:
            poses, velocities = self._poses.Eval(context), self._velocities.Eval(context)
            parts: list[Any] = []
            for body in map(int, self._bodies):
                X, V = poses[body], velocities[body]
                q = X.rotation().ToQuaternion().wxyz()
                parts += [q, X.translation(), V.rotational(), V.translational()]
            output.SetFromVector(np.concatenate(parts))

    return Impl
