"""The output port of a system whose forces act on bodies of a `MultibodyPlant`."""

from collections.abc import Callable, Iterable

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.multibody.math import SpatialForce_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DependencyTicket, LeafSystem

from workbench.common.vectors import Numbers
from workbench.systems.weak_callback import weakly

BodyLoads = Iterable[tuple[BodyIndex, Numbers]]
"""Index of each body, with moment [N·m] and force [N] in W at its origin (6)."""


def declare_spatial_forces(
    system: LeafSystem,
    T: type,
    calculate: Callable[[Context], BodyLoads],
    needs: set[DependencyTicket],
) -> None:
    """Declare the port `spatial_forces`, for the plant's port of applied forces.

    Args:
        system: that has it.
        T: its scalar type.
        calculate: method of the system that returns the loads.
        needs: what they are calculated from.
    """
    Force, SpatialForce = ExternallyAppliedSpatialForce_[T], SpatialForce_[T]
    origin = np.array([T(0.0)] * 3)
    loads_of = weakly(calculate)

    def store(context: Context, output: AbstractValue) -> None:
        forces = []
        for body, load in loads_of(context):
            force = Force()
            force.body_index = body
            force.p_BoBq_B = origin  # without, it is not a number in Drake 1.51
            # from an array: a tenth of the time that two tuples take
            force.F_Bq_W = SpatialForce(np.array(load))
            forces.append(force)
        output.set_value(forces)

    system.DeclareAbstractOutputPort(
        "spatial_forces", lambda: Value[list[Force]]([Force()]), store, needs
    )
