"""Estimate acceleration from velocity: the filtered derivative that PD control needs."""

import math

import numpy as np
from pydrake.systems.primitives import LinearSystem

TIME_CONSTANT = 0.02
"""Of the filter [s]: a third of the fastest rotor and attitude response, well over a sample."""

_STATE_SIZE = 13


def make_acceleration_estimate(*, period: float) -> LinearSystem:
    """Return a system from the plant's state (13) to an acceleration in W (3) [m/s²].

    It is s / (1 + s TIME_CONSTANT) applied to the velocity in W.

    Args:
        period: 0 for the continuous filter; else its discrete equivalent at that period [s],
            exact for a steady acceleration.
    """
    pick = np.hstack([np.zeros((3, _STATE_SIZE - 3)), np.eye(3)])  # v_WB out of the state
    one = np.eye(3)
    if period == 0.0:
        rate = 1.0 / TIME_CONSTANT
        return LinearSystem(A=-rate * one, B=rate * pick, C=-rate * one, D=rate * pick)
    share = -math.expm1(-period / TIME_CONSTANT)
    rate = share / period
    return LinearSystem(
        A=(1.0 - share) * one,
        B=share * pick,
        C=-rate * one,
        D=rate * pick,
        time_period=period,
    )
