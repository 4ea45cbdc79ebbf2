"""Dryden turbulence of MIL-F-8785C at low altitude, as pure functions of numbers.

MIL-F-8785C (1980), section 3.7, with heights in feet: lengths of scale L_u = L_v = h / (0.177 +
0.000823 h)^1.2 and L_w = h; intensities s_w = 0.1 W20 and s_u = s_v = s_w / (0.177 + 0.000823
h)^0.4; from 10 to 1000 ft. Spectra over the spatial frequency k, from 0 up:

    u    s² 2 L / pi / (1 + (L k)²)
    v, w s² L / pi (1 + 3 (L k)²) / (1 + (L k)²)²

For a drone with the air speed V, k becomes the frequency k V. So the turbulence is white noise
filtered by 1 / (1 + T s) or (1 + sqrt(3) T s) / (1 + T s)², with T = L / V. The filters' states
are dimensionless: x for u, and x, y with dx = -x dt/T + noise, dy = (x - y) dt/T for v and w. They
are stepped in closed form, so at constant height and speed, samples have the covariances of the
spectra whatever the period. MIL-HDBK-1797 has half of L_v and L_w and a factor of 2 with each: the
same spectra.
"""

import math
from typing import Any

from workbench.common.jitable import register_jitable

Signal = Any
"""A sequence of numbers: a list in Python, an array in compiled code."""

FOOT = 0.3048
LOWEST = 10.0
HIGHEST = 1000.0
"""Heights within which the model holds; those beyond count as these [ft]."""
LEAST_AIRSPEED = 1.0
"""A drone that moves no faster through the air is met by eddies at this speed [m/s]."""
STATES = 5
"""Of the filters: one for u, two for v, two for w."""
ANY_TIME = 50.0
"""After so many time constants a filter has forgotten how it began."""


@register_jitable
def intensities(height: float, w20: float) -> tuple[float, float]:
    """Return standard deviations of u and v, and of w [m/s].

    Args:
        height: above the ground [m].
        w20: wind speed at 20 ft [m/s]: 7.7 in light turbulence, 15.4 in moderate, 23.2 in severe.
    """
    h = min(max(height / FOOT, LOWEST), HIGHEST)
    s_w = 0.1 * w20
    return s_w / (0.177 + 0.000823 * h) ** 0.4, s_w


@register_jitable
def lengths(height: float) -> tuple[float, float]:
    """Return lengths of scale of u and v, and of w [m], at a height above the ground [m]."""
    h = min(max(height / FOOT, LOWEST), HIGHEST)
    return FOOT * h / (0.177 + 0.000823 * h) ** 1.2, FOOT * h


@register_jitable
def step_filters(
    eddies: Signal, noise: Signal, height: float, airspeed: float, period: float, after: Signal
) -> None:
    """Step the filters over a period.

    Args:
        eddies: states of the filters (5).
        noise: independent standard normal numbers (5).
        height: above the ground [m].
        airspeed: of the drone through the turbulence [m/s].
        period: time passed [s]; infinity begins anew, with states drawn as they are at any time.
        after: 5 places for the states then.
    """
    level, upright = lengths(height)
    speed = max(airspeed, LEAST_AIRSPEED)
    after[0] = _step_first(eddies[0], noise[0], min(period * speed / level, ANY_TIME))
    for i, length in ((1, level), (3, upright)):
        share = min(period * speed / length, ANY_TIME)
        after[i], after[i + 1] = _step_second(eddies[i : i + 2], noise[i : i + 2], share)


@register_jitable
def velocities(eddies: Signal, height: float, w20: float) -> tuple[float, float, float]:
    """Return u, v and w of the turbulence [m/s]: along, left of and above the mean wind.

    Args:
        eddies: states of the filters (5).
        height: above the ground [m].
        w20: see `intensities`.
    """
    level, upright = intensities(height, w20)
    root = math.sqrt(3.0)
    u, v_x, v_y, w_x, w_y = eddies
    return (
        level * u,
        level * (root * v_x + (1.0 - root) * v_y),
        upright * (root * w_x + (1.0 - root) * w_y),
    )


@register_jitable
def _step_first(x: float, noise: float, share: float) -> float:
    """Return the state of 1 / (1 + T s) after `share` of T; its variance is 1."""
    return x * math.exp(-share) + math.sqrt(-math.expm1(-2.0 * share)) * noise


@register_jitable
def _step_second(state: Signal, noise: Signal, share: float) -> tuple[float, float]:
    """Return the states of 1 / (1 + T s) and 1 / (1 + T s)² after `share` of T.

    Their variances are 1/2 and 1/4, as that makes 1 for the filter's output. The noise of a step
    has the covariance of the integrals of exp(-t) and t exp(-t) over white noise.
    """
    decay = math.exp(-share)
    square = decay * decay
    xx = -0.5 * math.expm1(-2.0 * share)
    xy = 0.25 * (1.0 - square * (1.0 + 2.0 * share))
    yy = 0.25 * (1.0 - square * (1.0 + 2.0 * share + 2.0 * share * share))
    root = math.sqrt(xx)
    x = decay * state[0] + root * noise[0]
    y = decay * (state[1] + share * state[0]) + xy / root * noise[0]
    y += math.sqrt(max(0.0, yy - xy * xy / xx)) * noise[1]  # what rounding leaves may be negative
    return x, y
