"""Wind, turbulence and push in a control period, as pure functions of numbers.

Turbulence is Dryden's at low altitude, from 10 to 1000 ft: MIL-F-8785C (1980), section 3.7. With
the height h in feet, lengths of scale are L_u = L_v = h / (0.177 + 0.000823 h)^1.2 and L_w = h;
intensities are s_w = 0.1 W20 and s_u = s_v = s_w / (0.177 + 0.000823 h)^0.4. Spectra over the
spatial frequency k, from 0 up:

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

from workbench.common.jitable import register_jitable
from workbench.common.vectors import MutableNumbers, Numbers, Vector3
from workbench.dynamics.air.settings import AirSettings

FOOT_IN_M = 0.3048
MIN_MODEL_HEIGHT_FT = 10.0
MAX_MODEL_HEIGHT_FT = 1000.0
"""Range of heights of the model; other heights are clipped to it [ft]."""
MIN_EDDY_AIRSPEED = 1.0
"""Smallest airspeed at which a drone meets eddies [m/s]."""
EDDIES_STARTED_INDEX = 5
"""Place of 1 if the filters have started, after their states: one for u, two for v, two for w."""
EDDY_MEMORY_SIZE = 6
"""Size of the memory of the turbulence."""
FORGETTING_TIME_CONSTANTS = 50.0
"""Number of time constants after which the initial state of a filter has no effect."""


@register_jitable
def intensities(height: float, w20: float) -> tuple[float, float]:
    """Return standard deviations of u and v, and of w [m/s].

    Args:
        height: above the ground [m].
        w20: wind speed at 20 ft [m/s]: 7.7 in light turbulence, 15.4 in moderate, 23.2 in severe.
    """
    h = min(max(height / FOOT_IN_M, MIN_MODEL_HEIGHT_FT), MAX_MODEL_HEIGHT_FT)
    s_w = 0.1 * w20
    return s_w / (0.177 + 0.000823 * h) ** 0.4, s_w


@register_jitable
def lengths(height: float) -> tuple[float, float]:
    """Return lengths of scale of u and v, and of w [m], at a height above the ground [m]."""
    h = min(max(height / FOOT_IN_M, MIN_MODEL_HEIGHT_FT), MAX_MODEL_HEIGHT_FT)
    return FOOT_IN_M * h / (0.177 + 0.000823 * h) ** 1.2, FOOT_IN_M * h


@register_jitable
def step_filters(
    eddies: Numbers,
    noise: Numbers,
    height: float,
    airspeed: float,
    period: float,
    after: MutableNumbers,
) -> None:
    """Step the filters over a period.

    Args:
        eddies: states of the filters (5).
        noise: independent standard normal numbers (5).
        height: above the ground [m].
        airspeed: of the drone through the turbulence [m/s].
        period: elapsed time [s]; infinity draws new states from their stationary distribution.
        after: 5 places for the states after it.
    """
    level, upright = lengths(height)
    speed = max(airspeed, MIN_EDDY_AIRSPEED)
    after[0] = _step_first(
        eddies[0], noise[0], min(period * speed / level, FORGETTING_TIME_CONSTANTS)
    )
    for i, length in ((1, level), (3, upright)):
        share = min(period * speed / length, FORGETTING_TIME_CONSTANTS)
        after[i], after[i + 1] = _step_second(eddies[i : i + 2], noise[i : i + 2], share)


@register_jitable
def velocities(eddies: Numbers, height: float, w20: float) -> Vector3:
    """Return u, v and w of the turbulence [m/s]: along, left of and above the mean wind.

    Args:
        eddies: states of the filters (5).
        height: above the ground [m].
        w20: see `intensities`.
    """
    level, upright = intensities(height, w20)
    root = math.sqrt(3.0)
    return (
        level * eddies[0],
        level * (root * eddies[1] + (1.0 - root) * eddies[2]),
        upright * (root * eddies[3] + (1.0 - root) * eddies[4]),
    )


@register_jitable
def _step_first(x: float, noise: float, share: float) -> float:
    """Return the state of 1 / (1 + T s) after `share` of T; its variance is 1."""
    return x * math.exp(-share) + math.sqrt(-math.expm1(-2.0 * share)) * noise


@register_jitable
def _step_second(state: Numbers, noise: Numbers, share: float) -> tuple[float, float]:
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
    y += math.sqrt(max(0.0, yy - xy * xy / xx)) * noise[1]  # negative only by rounding
    return x, y


@register_jitable(forceinline=True)
def gust_share(time: float, start: float, duration: float) -> float:
    """Return a gust's share of its peak, 0 .. 1.

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
def steady_wind(settings: AirSettings, time: float) -> Vector3:
    """Return the velocity of mean wind and gust at a time, in W [m/s].

    Args:
        settings: of the air, or of the wind alone.
        time: [s].
    """
    share = gust_share(time, settings.gust_start, settings.gust_duration)
    return (
        settings.wind_x + share * settings.gust_x,
        settings.wind_y + share * settings.gust_y,
        settings.wind_z + share * settings.gust_z,
    )


@register_jitable(forceinline=True)
def turbulent_wind(
    settings: AirSettings,
    state: Numbers,
    noise: Numbers,
    eddies: Numbers,
    period: float,
    after: MutableNumbers,
) -> Vector3:
    """Return the velocity of the turbulence in W [m/s], and step its filters.

    Its axes are along the mean wind's level part, left of it and up; without wind they are those of
    a wind along x. The drone's airspeed, which says how fast it meets the eddies, is its speed
    relative to the mean wind.

    Args:
        settings: see `steady_wind`.
        state: of the body (13).
        noise: see `step_filters`.
        eddies: states of the filters, and whether they have begun (6).
        period: since the last step [s].
        after: 6 places for the next eddies.
    """
    e_x = state[10] - settings.wind_x
    e_y = state[11] - settings.wind_y
    e_z = state[12] - settings.wind_z
    airspeed = math.sqrt(e_x * e_x + e_y * e_y + e_z * e_z)
    passed = period if eddies[EDDIES_STARTED_INDEX] > 0.0 else math.inf
    step_filters(eddies[0:EDDIES_STARTED_INDEX], noise, state[6], airspeed, passed, after)
    after[EDDIES_STARTED_INDEX] = 1.0
    u, v, w = velocities(after[0:EDDIES_STARTED_INDEX], state[6], settings.turbulence)
    heading = math.atan2(settings.wind_y, settings.wind_x)
    c = math.cos(heading)
    s = math.sin(heading)
    return c * u - s * v, s * u + c * v, w
