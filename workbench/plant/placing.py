"""Set the state of a vehicle."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RollPitchYaw


def body_state(
    *,
    p_WB: Sequence[float],
    roll_pitch_yaw: Sequence[float],
    v_WB: Sequence[float],
    w_WB: Sequence[float],
) -> np.ndarray:
    """Return the state of a body (13): q_WB, p_WB, w_WB_W, v_WB_W.

    Args:
        p_WB: position [m].
        roll_pitch_yaw: orientation [rad].
        v_WB: velocity in W [m/s].
        w_WB: angular velocity in W [rad/s].
    """
    q_WB = RollPitchYaw(np.array(roll_pitch_yaw)).ToQuaternion().wxyz()
    return np.concatenate([q_WB, p_WB, w_WB, v_WB])
