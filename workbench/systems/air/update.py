"""What the air does in a control period: wind at the drone, drag and push, as pure functions."""

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable

from workbench.systems.air.drag import cross, drag_wrench, into_body
from workbench.systems.air.normals import COUNT, draw_normals
from workbench.systems.air.turbulence import step_filters, velocities

Signal = Any
"""A sequence of numbers: a list in Python, an array in compiled code."""

BEGUN = 5
"""Place, behind the filters' states, of whether they have begun."""
EDDIES = 6
"""Size of what the turbulence remembers."""


@register_jitable
def gust_share(time: float, start: float, duration: float) -> float:
    """Return how much of its peak a gust has, 0 .. 1.

    It rises as the 1 - cos gust of MIL-F-8785C (section 3.7.1.3) does, in half of its duration,
    and falls along the mirror image.
    """
    if not start < time < start + duration:
        return 0.0
    return 0.5 * (1.0 - math.cos(2.0 * math.pi * (time - start) / duration))


@register_jitable
def push_share(time: float, period: float, start: float, duration: float) -> float:
    """Return the share of the period from `time` on in which a push acts: its impulse is exact."""
    begin = max(time, start)
    end = min(time + period, start + duration)
    return max(0.0, end - begin) / period


@register_jitable
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
    airspeed = math.sqrt(e_x * e_x + e_y * e_y + e_z * e_z)
    passed = period if eddies[BEGUN] > 0.0 else math.inf
    step_filters(eddies[0:BEGUN], noise, state[6], airspeed, passed, next_eddies)
    next_eddies[BEGUN] = 1.0
    u, v, w = velocities(next_eddies[0:BEGUN], state[6], w20)
    heading = math.atan2(w_y, w_x)
    c = math.cos(heading)
    s = math.sin(heading)
    gust = gust_share(time, gust_start, gust_duration)
    return (
        w_x + gust * g_x + c * u - s * v,
        w_y + gust * g_y + s * u + c * v,
        w_z + gust * g_z + w,
    )


@register_jitable
def air_update(
    time: float,
    state: np.ndarray,
    speeds: np.ndarray,
    noise: np.ndarray,
    settings: np.ndarray,
    p_BoBcm_B: np.ndarray,
    rotors: np.ndarray,
    period: float,
    eddies: np.ndarray,
    wrench: np.ndarray,
    wind: np.ndarray,
    next_eddies: np.ndarray,
) -> None:
    """Do one sampled update of the air.

    Args:
        time: now [s].
        state: of the plant (13).
        speeds: of the rotors, n or more of which the first n count [rad/s].
        noise: independent standard normal numbers, 5 or more.
        settings: see `AirSettings`.
        p_BoBcm_B: the centre of mass (3) [m].
        rotors: n rows, see `rotor_rows`.
        period: between updates [s].
        eddies: what the turbulence remembers (6).
        wrench: 6 places for force [N] and moment about the body's origin [N·m], in B.
        wind: 3 places for the velocity of the air in W [m/s].
        next_eddies: 6 places for what the turbulence remembers.
    """
    air = wind_at(time, state, noise, settings, period, eddies, next_eddies)
    wind[0], wind[1], wind[2] = air
    p_x, p_y, p_z, at_x, at_y, at_z, start, duration, area, density = settings[9:19]
    share = push_share(time, period, start, duration)
    push = into_body(state[0:4], (share * p_x, share * p_y, share * p_z))
    turn = cross((at_x, at_y, at_z), push)
    drag = drag_wrench(state, speeds, air, 0.5 * density * area, p_BoBcm_B, rotors)
    for i in range(3):
        wrench[i] = drag[i] + push[i]
        wrench[3 + i] = drag[3 + i] + turn[i]


def seeded_update(
    time: float,
    seed: np.ndarray,
    state: np.ndarray,
    speeds: np.ndarray,
    settings: np.ndarray,
    p_BoBcm_B: np.ndarray,
    rotors: np.ndarray,
    period: float,
    eddies: np.ndarray,
    wrench: np.ndarray,
    wind: np.ndarray,
    next_eddies: np.ndarray,
) -> None:
    """Do `air_update` with the noise that belongs to a seed (1) and the time; it gets compiled."""
    noise = np.empty(COUNT)
    draw_normals(seed[0], int(time / period + 0.5), noise)
    air_update(
        time,
        state,
        speeds,
        noise,
        settings,
        p_BoBcm_B,
        rotors,
        period,
        eddies,
        wrench,
        wind,
        next_eddies,
    )
