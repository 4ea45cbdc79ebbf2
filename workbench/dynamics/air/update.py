"""What the air does in a physics step: wind at the drone, and push, as pure functions."""

import math
from typing import Any

from workbench.common.jitable import register_jitable
from workbench.dynamics.air.drag import cross
from workbench.dynamics.air.turbulence import step_filters, velocities
from workbench.dynamics.rigid_body import into_world, rotation, turned

Signal = Any
"""A sequence of numbers: a list in Python, an array in compiled code."""

BEGUN = 5
"""Place, behind the filters' states, of whether they have begun."""
EDDIES = 6
"""Size of what the turbulence remembers."""


@register_jitable(forceinline=True)
def gust_share(time: float, start: float, duration: float) -> float:
    """Return how much of its peak a gust has, 0 .. 1.

    It rises as the 1 - cos gust of MIL-F-8785C (section 3.7.1.3) does, in half of its duration,
    and falls along the mirror image.
    """
    if not start < time < start + duration:
        return 0.0
    return 0.5 * (1.0 - math.cos(2.0 * math.pi * (time - start) / duration))


@register_jitable(forceinline=True)
def push_share(time: float, period: float, start: float, duration: float) -> float:
    """Return the share of the period from `time` on in which a push acts: its impulse is exact."""
    begin = max(time, start)
    end = min(time + period, start + duration)
    return max(0.0, end - begin) / period


@register_jitable(forceinline=True)
def wind_at(
    time: float,
    state: Signal,
    noise: Signal,
    settings: Signal,
    period: float,
    eddies: Signal,
    next_eddies: Signal,
) -> tuple[float, float, float]:
    """Return the velocity of the air at the drone, in W [m/s], and step the turbulence up to it.

    Turbulence has its axes along the mean wind's level part, left of it and up; without one it
    is that of a wind along x. The drone's airspeed, which says how fast it meets the eddies, is
    its speed relative to the mean wind.

    Args:
        time: now [s].
        state: of the plant (13).
        noise: see `step_filters`, and so `eddies`.
        settings: see `AirSettings`.
        period: since the last call [s].
        eddies: what the turbulence remembers (6).
        next_eddies: 6 places for it.
    """
    w_x, w_y, w_z, w20, g_x, g_y, g_z, gust_start, gust_duration = settings[0:9]
    e_x = state[10] - w_x
    e_y = state[11] - w_y
    e_z = state[12] - w_z
    gust = gust_share(time, gust_start, gust_duration)
    if w20 == 0.0:  # where turbulence begins, it begins as it is at any time
        next_eddies[BEGUN] = 0.0
        return w_x + gust * g_x, w_y + gust * g_y, w_z + gust * g_z
    airspeed = math.sqrt(e_x * e_x + e_y * e_y + e_z * e_z)
    passed = period if eddies[BEGUN] > 0.0 else math.inf
    step_filters(eddies[0:BEGUN], noise, state[6], airspeed, passed, next_eddies)
    next_eddies[BEGUN] = 1.0
    u, v, w = velocities(next_eddies[0:BEGUN], state[6], w20)
    heading = math.atan2(w_y, w_x)
    c = math.cos(heading)
    s = math.sin(heading)
    return (
        w_x + gust * g_x + c * u - s * v,
        w_y + gust * g_y + s * u + c * v,
        w_z + gust * g_z + w,
    )


@register_jitable(forceinline=True)
def push_at(time: float, state: Signal, settings: Signal, period: float) -> tuple[Any, ...]:
    """Return force [N] and moment about the body's origin [N·m] of the push, in W (6).

    They are the mean over a period from `time` on, for the body as it stands at its beginning; the
    torque turns along with it.

    Args:
        time: now [s].
        state: of the body (13).
        settings: see `AirSettings`.
        period: that follows [s].
    """
    p_x, p_y, p_z, at_x, at_y, at_z, torque_x, torque_y, torque_z, start, duration = settings[9:20]
    share = push_share(time, period, start, duration)
    if share == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    force = (share * p_x, share * p_y, share * p_z)
    R_WB = rotation(state[0:4])
    arm = (
        R_WB[0] * at_x + R_WB[1] * at_y + R_WB[2] * at_z,
        R_WB[3] * at_x + R_WB[4] * at_y + R_WB[5] * at_z,
        R_WB[6] * at_x + R_WB[7] * at_y + R_WB[8] * at_z,
    )
    m_x, m_y, m_z = cross(arm, force)
    # a torque that turns along with the body is taken in the middle of the step, as forces are
    R_WM = rotation(turned(state[0:4], state[7:10], 0.25 * period))
    t_x, t_y, t_z = into_world(R_WM, (share * torque_x, share * torque_y, share * torque_z))
    return force + (m_x + t_x, m_y + t_y, m_z + t_z)
