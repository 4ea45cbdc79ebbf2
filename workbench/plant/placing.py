"""Put a vehicle somewhere."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from workbench.plant.vehicle import Vehicle


def place_vehicle(
    plant: MultibodyPlant,
    context: Context,
    vehicle: Vehicle,
    *,
    p_WB: Sequence[float],
    roll_pitch_yaw: Sequence[float],
    v_WB: Sequence[float],
    w_WB: Sequence[float],
) -> None:
    """Write a vehicle's pose and motion into the plant's Context.

    Args:
        plant: with the vehicle in it.
        context: the plant's own.
        vehicle: its record.
        p_WB: position [m].
        roll_pitch_yaw: orientation [rad].
        v_WB: velocity in W [m/s].
        w_WB: angular velocity in W [rad/s].
    """
    base = plant.GetBodyByName(vehicle.base_link)
    pose = RigidTransform(RollPitchYaw(np.array(roll_pitch_yaw)), np.array(p_WB))
    plant.SetFreeBodyPose(context, base, pose)
    velocity = SpatialVelocity(np.array(w_WB), np.array(v_WB))
    plant.SetFreeBodySpatialVelocity(context, base, velocity)
