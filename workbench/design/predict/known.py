"""What a flight computer takes its motion for: the truth, and an error that goes on.

A flight computer that is told positions and reckons with thrust and weight alone takes drag for
tilt. With e the error of its level velocity, eta that of its level acceleration, which is g times
the error of its tilt, and d the drag over mass and speed,

    de/dt = eta + d v - L e,   deta/dt = -W e

are the slow part of a Kalman filter with the gains L [1/s] and W [1/s²]: in steady flight the tilt
is wrong by d v / g. Both begin with what the log shows at the start.
"""

from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.design.rollout.fields import fetch, store
from workbench.design.rollout.gyro import KNOW_TRUTH
from workbench.plant.gravity import GRAVITY

ERROR = 11
"""Numbers of an estimate's error: position (3) [m] and velocity (3) [m/s] in W, eta x and y [m/s²],
and the rotation from B to where B is taken to be (3) [rad]."""
POSITION_GAIN = 2.0
"""At which an estimate's error of position fades [1/s]."""


class Observer(NamedTuple):
    """How the estimate's error goes on, see above.

    Attributes:
        velocity_gain: L [1/s].
        tilt_gain: W [1/s²].
        drag: d [1/s].
    """

    velocity_gain: float = 7.0
    tilt_gain: float = 10.0
    drag: float = 0.41


@register_jitable
def times(a, b):
    """Return the product of two quaternions (4)."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@register_jitable
def turn(x, y, z):
    """Return the quaternion of a small rotation vector, right to its third power [rad]."""
    square = x * x + y * y + z * z
    half = 0.5 - square / 48.0
    return 1.0 - square / 8.0, half * x, half * y, half * z


@register_jitable
def seen(state, error):
    """Return what the flight computer takes a state for (13), see `ERROR`."""
    tilt = turn(-error[7] / GRAVITY, error[6] / GRAVITY, 0.0)
    known = times(tilt, times(state[0:4], turn(error[8], error[9], error[10])))
    _, _, _, _, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    p = (p_x + error[0], p_y + error[1], p_z + error[2])
    v = (v_x + error[3], v_y + error[4], v_z + error[5])
    return known + p + (w_x, w_y, w_z) + v


@register_jitable
def step_error(error, velocity, observer, dt):
    """Let an estimate's error go on, in place."""
    gain, tilt, drag = observer
    for i in range(2):
        slope = error[6 + i] + drag * velocity[i] - gain * error[3 + i]
        error[6 + i] -= dt * tilt * error[3 + i]
        error[3 + i] += dt * slope
    error[5] -= dt * gain * error[5]
    for i in range(3):
        error[i] -= dt * POSITION_GAIN * error[i]


@register_jitable
def _know(flight, clock, observer):
    """Write what the flight computer knows; its error goes on."""
    state = fetch(flight, "state")
    store(flight, "known", seen(state, flight.error))
    step_error(flight.error, state[10:13], observer, clock.period)


@register_jitable(forceinline=True)
def _look(flight, clock, observer, passed):
    return fetch(flight, "known")


KNOW_WRONG = KNOW_TRUTH._replace(know=_know, look=_look, key="wrong")
"""The law knows the motion, but for the estimate's error."""
