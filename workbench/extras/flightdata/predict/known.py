"""What a flight computer takes its motion for: the truth, and an error that goes on.

A flight computer that is told positions and reckons with thrust and weight alone takes drag for
tilt. With e the error of its level velocity, eta that of its level acceleration, which is g times
the error of its tilt, and d the drag over mass and speed,

    de/dt = eta + d v - L e,   deta/dt = -W e

are the slow part of a Kalman filter with the gains L [1/s] and W [1/s²]: in steady flight the tilt
is wrong by d v / g. Both begin with what the log shows at the start.
"""

from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Quaternion
from workbench.control.quaternions import product
from workbench.design.rollout.fields import get_field, set_field
from workbench.design.rollout.gyro import TRUE_STATE
from workbench.design.rollout.lane_times import PeriodClock
from workbench.plant.gravity import GRAVITY

ESTIMATE_ERROR_SIZE = 11
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
def rotation_quaternion(x: float, y: float, z: float) -> Quaternion:
    """Return the quaternion of a small rotation vector, right to its third power [rad]."""
    square = x * x + y * y + z * z
    half = 0.5 - square / 48.0
    return 1.0 - square / 8.0, half * x, half * y, half * z


@register_jitable
def state_with_error(state: Numbers, error: Numbers) -> tuple[float, ...]:
    """Return what the flight computer takes a state for (13), see `ESTIMATE_ERROR_SIZE`."""
    q_w, q_x, q_y, q_z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    tilt = rotation_quaternion(-error[7] / GRAVITY, error[6] / GRAVITY, 0.0)
    turned = product((q_w, q_x, q_y, q_z), rotation_quaternion(error[8], error[9], error[10]))
    known = product(tilt, turned)
    p = (p_x + error[0], p_y + error[1], p_z + error[2])
    v = (v_x + error[3], v_y + error[4], v_z + error[5])
    return known + p + (w_x, w_y, w_z) + v


@register_jitable
def step_error(error: np.ndarray, velocity: Numbers, observer: Observer, dt: float) -> None:
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
def _write_wrong_state(flight: np.record, clock: PeriodClock, observer: Observer) -> None:
    """Write what the flight computer knows; its error goes on."""
    state = get_field(flight, "state")
    set_field(flight, "known", state_with_error(state, flight.error))
    step_error(flight.error, state[10:13], observer, clock.period)


@register_jitable(forceinline=True)
def _wrong_state(
    flight: np.record, clock: PeriodClock, observer: Observer, passed: float
) -> tuple[float, ...]:
    return get_field(flight, "known")


WRONG_STATE = TRUE_STATE._replace(sense=_write_wrong_state, sense_between=_wrong_state, key="wrong")
"""The law knows the motion, but for the estimate's error."""
