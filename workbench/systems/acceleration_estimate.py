"""Estimate acceleration from velocity by a filtered derivative, as PD control needs.

The filter is s / (1 + s TIME_CONSTANT), applied to the velocity in W.
"""

import math

import numpy as np
from pydrake.systems.primitives import LinearSystem

ESTIMATE_TIME_CONSTANT_S = 0.02
"""[s]: a third of the fastest rotor and attitude response, and much longer than a sample."""

_STATE_SIZE = 13


def make_acceleration_estimate() -> LinearSystem:
    """Return a continuous system from the plant's state (13) to an acceleration in W (3) [m/s²]."""
    pick = np.hstack([np.zeros((3, _STATE_SIZE - 3)), np.eye(3)])  # v_WB out of the state
    rate = 1.0 / ESTIMATE_TIME_CONSTANT_S
    return LinearSystem(A=-rate * np.eye(3), B=rate * pick, C=-rate * np.eye(3), D=rate * pick)


def sampled_estimate(period: float) -> tuple[float, float]:
    """Return share and rate of the same filter sampled every `period` seconds.

    With f the filtered velocity, the estimate is rate (v - f), then f becomes f + share (v - f);
    for a steady acceleration it is exact.
    """
    share = -math.expm1(-period / ESTIMATE_TIME_CONSTANT_S)
    return share, share / period
