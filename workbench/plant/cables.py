"""Cables in Drake's plant: where they end, and how the distance between their ends changes."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Context

from workbench.plant.model import Cable

CableEnd = tuple[RigidBody, np.ndarray]
"""A body of the plant, and the place of a cable's end in its frame (3) [m]."""


TAUT_TOLERANCE_M = 1e-9
"""A cable is taut from this much below its length [m]."""


def cable_ends(
    plant: MultibodyPlant, cable: Cable, drone: ModelInstanceIndex
) -> tuple[CableEnd, CableEnd]:
    """Return the ends of a cable: A on its parent, B on its child.

    Args:
        plant: with the vehicle; links are frames in it.
        cable: of the vehicle.
        drone: the vehicle's model instance.
    """
    first, second = (
        (frame.body(), frame.GetFixedPoseInBodyFrame().multiply(np.array(p)))
        for frame, p in (
            (plant.GetFrameByName(cable.parent, drone), cable.p_parent),
            (plant.GetFrameByName(cable.child, drone), cable.p_child),
        )
    )
    return first, second


def cable_distance(plant: MultibodyPlant, context: Context, ends: Sequence[CableEnd]) -> float:
    """Return the distance between the ends [m]."""
    return float(np.linalg.norm(_from_a_to_b(plant, context, ends)))


def cable_stretch(plant: MultibodyPlant, context: Context, ends: Sequence[CableEnd]) -> np.ndarray:
    """Return the rate of the distance between the ends by the velocities of the plant (nv).

    Ends at one place have no direction; then that is downwards in the world.
    """
    world = plant.world_frame()
    first, second = (
        plant.CalcJacobianTranslationalVelocity(
            context, JacobianWrtVariable.kV, body.body_frame(), p, world, world
        )
        for body, p in ends
    )
    apart = _from_a_to_b(plant, context, ends)
    distance = float(np.linalg.norm(apart))
    direction = apart / distance if distance > 1e-9 else np.array([0.0, 0.0, -1.0])
    pull: np.ndarray = direction @ (second - first)
    return pull


def _from_a_to_b(plant: MultibodyPlant, context: Context, ends: Sequence[CableEnd]) -> np.ndarray:
    """Return the vector from the first end to the second in the world (3) [m]."""
    first, second = (
        plant.EvalBodyPoseInWorld(context, body).multiply(np.asarray(p)) for body, p in ends
    )
    apart: np.ndarray = second - first
    return apart
