"""The plant's state where flights begin."""

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.design.step_response import START_HEIGHT
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Start


def start_state(vehicle: Vehicle, start: Start) -> np.ndarray:
    """Return the plant's state (13), see `rigid_body.State`, at a start in the air.

    Args:
        vehicle: whose attitude is that of the frame in which its rotors lift upwards.
        start: of a scenario; without a position, where steps begin.
    """
    attitude = RollPitchYaw(np.array(thrust_frame(vehicle).roll_pitch_yaw(start.roll_pitch_yaw)))
    q_WB = attitude.ToRotationMatrix().ToQuaternion().wxyz()
    p_WB = start.position or [0.0, 0.0, START_HEIGHT]
    return np.array([*q_WB, *p_WB, *start.angular_velocity, *start.velocity])
