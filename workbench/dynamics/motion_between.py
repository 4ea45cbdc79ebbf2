"""The motion of a body between two instants, from its motion at both.

Attitude and position are the cubics with the values and derivatives of both instants (Hermite's).
At a share s of the time h between them

    x(s) = (1 + 2 s) (1 - s)² x_0 + s (1 - s)² h v_0 + s² (3 - 2 s) x_1 - s² (1 - s) h v_1

Their error falls with the fourth power of h: over a control period of 8 ms at 20 rad/s the angular
velocity is exact within 1e-4 rad/s. The mean velocity is always exact, also through an impact.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers
from workbench.dynamics.rigid_body import (
    Vector3,
    into_body,
    into_world,
    quaternion_rate,
    rotation,
)


@register_jitable(forceinline=True)
def point_motion(state: Numbers, p_BS: Numbers) -> tuple[float, ...]:
    """Return attitude, position, and the derivatives of both, of a point of a body.

    Args:
        state: of the body (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        p_BS: of the point S [m].

    Returns:
        q_WB, p_WS [m], dq_WB [1/s], v_WS_W [m/s] (14).
    """
    q_WB, w_W = state[0:4], state[7:10]
    l_x, l_y, l_z = into_world(rotation(q_WB), p_BS)
    w_x, w_y, w_z = w_W
    q_w, q_x, q_y, q_z = q_WB
    d_w, d_x, d_y, d_z = quaternion_rate(q_WB, w_W)
    return (
        q_w,
        q_x,
        q_y,
        q_z,
        state[4] + l_x,
        state[5] + l_y,
        state[6] + l_z,
        d_w,
        d_x,
        d_y,
        d_z,
        state[10] + w_y * l_z - w_z * l_y,
        state[11] + w_z * l_x - w_x * l_z,
        state[12] + w_x * l_y - w_y * l_x,
    )


@register_jitable
def motion_between(
    before: Numbers, now: Numbers, period: float, share: float, found: np.ndarray
) -> None:
    """Write the motion at a share of a period to 14 places, see `motions_between`."""
    x_0, v_0, x_1, v_1 = _position_weights(share)
    a_0, b_0, a_1, b_1 = _velocity_weights(share)
    for k in range(7):
        first, last = period * before[7 + k], period * now[7 + k]
        found[k] = x_0 * before[k] + v_0 * first + x_1 * now[k] + v_1 * last
        found[7 + k] = (a_0 * before[k] + b_0 * first + a_1 * now[k] + b_1 * last) / period


def motions_between(
    before: Sequence[float], now: Sequence[float], period: float, count: int, share: float
) -> np.ndarray:
    """Return the motion at the end and in the middle of each of some equal parts of a period.

    Args:
        before: at the beginning of the period, see `point_motion` (14).
        now: at its end (14).
        period: its length [s].
        count: of the parts, from the beginning on.
        share: of the period that each takes.

    Returns:
        At the ends of the parts (count, 14), then in their middles (count, 14), as (2, count, 14).
    """
    ends = np.array([before, now])
    ends[:, 7:] *= period
    weights, slopes = _weights(count, share)
    known = ends.reshape(4, 7)  # x_0, h v_0, x_1, h v_1
    found = np.concatenate([weights @ known, slopes @ known / period], axis=1)
    return found.reshape(2, count, 14)


@register_jitable
def body_rate(motion: Numbers) -> Vector3:
    """Return w_WB in B [rad/s] of a motion (14), see `point_motion`."""
    w, x, y, z = motion[0], motion[1], motion[2], motion[3]
    d_w, d_x, d_y, d_z = motion[7], motion[8], motion[9], motion[10]
    # twice the vector of the quaternion q⁻¹ dq, whose length |q|² may differ from 1
    share = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        share * (w * d_x - x * d_w - y * d_z + z * d_y),
        share * (w * d_y - y * d_w - z * d_x + x * d_z),
        share * (w * d_z - z * d_w - x * d_y + y * d_x),
    )


@register_jitable
def mean_specific_force(
    before: Numbers, middle: Numbers, now: Numbers, period: float, gravity: float
) -> Vector3:
    """Return the mean specific force in a period, in B as it is in the middle [m/s²].

    It is that of the change of velocity. The force at an instant would miss an impact, or take its
    peak for the mean: a landing at 0.4 m/s is over within a millisecond of 1500 m/s².

    Args:
        before: the motion at the beginning (14), see `point_motion`.
        middle: that in the middle.
        now: that at the end.
        period: between them [s].
        gravity: [m/s²].
    """
    a_x = (now[11] - before[11]) / period
    a_y = (now[12] - before[12]) / period
    a_z = (now[13] - before[13]) / period
    q_WB = (middle[0], middle[1], middle[2], middle[3])
    return into_body(rotation(q_WB), (a_x, a_y, a_z + gravity))


@lru_cache(maxsize=64)
def _weights(count: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights of x_0, h v_0, x_1, h v_1 in x and in h v (2 count, 4)."""
    ends = share * np.arange(1, count + 1)
    s: Any = np.concatenate([ends, ends - 0.5 * share])
    return np.stack(_position_weights(s), axis=1), np.stack(_velocity_weights(s), axis=1)


@register_jitable
def _position_weights(s: float) -> tuple[float, float, float, float]:
    """Return the weights of x_0, h v_0, x_1, h v_1 in x."""
    r = 1.0 - s
    return (1.0 + 2.0 * s) * r * r, s * r * r, s * s * (3.0 - 2.0 * s), -s * s * r


@register_jitable
def _velocity_weights(s: float) -> tuple[float, float, float, float]:
    """Return the weights of x_0, h v_0, x_1, h v_1 in h v."""
    r = 1.0 - s
    return -6.0 * s * r, r * (1.0 - 3.0 * s), 6.0 * s * r, s * (3.0 * s - 2.0)
