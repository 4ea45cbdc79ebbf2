"""Find the attitude, rotor speeds and reference that make a flight steady."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.control.flight_law import FILTERED
from workbench.control.guidance import Guidance, Reference
from workbench.design.linear.derivatives import REFERENCE, Derivatives
from workbench.design.linear.model import Trim
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.seeds import STATE, angle_seeds
from workbench.plant.payload import laden, payload_of
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

HEIGHT = 10.0
"""Height of the trim: far from the ground, and from any ceiling but a low one [m]."""
BELOW_CEILING = 2.0
"""Smallest distance of the trim below the largest height, where climbs are slowed [m]."""
TOLERANCE = 1e-9
"""Tolerance of accelerations [m/s², rad/s²], of commands as shares of their speeds, and of the
memory, relative for numbers above 1."""
ROUNDS = 40
LARGEST_TURN = 0.3
"""Largest rotation of the attitude in an iteration [rad]."""


def find_trim(
    derivatives: Derivatives,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    point: OperatingPoint,
    rate: float,
) -> Trim:
    """Return the trim of an operating point, by Newton's method.

    Unknowns are the tilt, the rotor speeds, the commanded velocity and yaw rate, and the memory of
    the law. The equations are that accelerations are those of the point, commands equal the speeds,
    and the memory is constant.

    Args:
        derivatives: of what flies, with these gains set.
        vehicle: about the flying one, without its payload, as the start of the search.
        gains: parameter values by name.
        point: to be reached.
        rate: of the acceleration estimate, see `systems.acceleration_estimate` [1/s].

    Raises:
        WorkbenchError: if no command makes it fly like that.
    """
    n = len(vehicle.rotors)
    if point.yaw_rate and derivatives.controller.memory:
        raise WorkbenchError(
            f"a turn cannot be linearised with {derivatives.controller.name}, whose memory has "
            "vectors that turn as well: set the yaw rate to 0"
        )
    lagging = [name for name in ("setpoint_lowpass", "derivative_lowpass") if gains[name]]
    if point.yaw_rate and lagging:
        raise WorkbenchError(
            f"a turn cannot be linearised with {' and '.join(lagging)}, whose vectors turn late: "
            "set the yaw rate to 0, or switch them off"
        )
    trim = _first_guess(derivatives, vehicle, gains, point)
    best = np.inf
    for _ in range(ROUNDS):
        residual, jacobian = _residual(derivatives, trim, rate)
        worst = float(np.abs(residual).max())
        if not np.isfinite(worst) or not np.isfinite(jacobian).all():
            break
        best = min(best, worst)
        if worst < TOLERANCE:
            return trim
        free = np.ones(jacobian.shape[1], dtype=bool)
        if point.hold and trim.memory.size:  # any command of a pilot ends the hold
            free[2 + n : 2 + n + REFERENCE] = False
        change = np.zeros(jacobian.shape[1])
        change[free] = np.linalg.lstsq(jacobian[:, free], -residual, rcond=1e-12)[0]
        turn = float(np.abs(change[:2]).max())
        share = min(1.0, LARGEST_TURN / max(turn, 1e-12))
        trim = _moved(derivatives, trim, share * change, n)
    raise WorkbenchError(
        f"there is no flight as '{point.label}' for {vehicle.name} with these gains: "
        f"{best:.2g} m/s², rad/s² or shares of a rotor's speed remain; it may be beyond "
        "max_speed, max_climb_rate, max_yaw_rate, max_tilt or what the rotors can give"
    )


def guidance_of(trim: Trim) -> np.ndarray:
    """Return the guidance (22) of a trim: motors on, and the position held if required."""
    hold = float(trim.point.hold)
    x, y, z = trim.p_WB.tolist()
    return np.array(Guidance(1.0, 1.0, 1.0, 0.0, hold, hold, x, y, z), dtype=float)


def reference_of(trim: Trim) -> np.ndarray:
    """Return the pilot's reference (8) of a trim."""
    return np.concatenate([trim.reference, np.zeros(len(Reference._fields) - REFERENCE)])


def filtered_of(trim: Trim, rate: float) -> np.ndarray:
    """Return the states of the filters before the law in a trim (10), see `FilterStates`."""
    velocity = trim.v_WB - trim.vdot_WB / rate
    return np.concatenate([velocity, trim.vdot_WB, trim.reference])


def update_inputs(trim: Trim, rate: float) -> tuple[np.ndarray, ...]:
    """Return the inputs of `Derivatives.update` in a trimmed flight; `rate` as in `find_trim`."""
    return (
        trim.state,
        filtered_of(trim, rate),
        trim.commands,
        reference_of(trim),
        guidance_of(trim),
        trim.memory,
    )


def _first_guess(
    derivatives: Derivatives, vehicle: Vehicle, gains: Mapping[str, float], point: OperatingPoint
) -> Trim:
    frame = thrust_frame(laden(vehicle, payload_of(gains)))
    attitude = RollPitchYaw(np.array(frame.roll_pitch_yaw([0.0, 0.0, 0.0])))
    height = min(HEIGHT, max(0.0, gains["max_height"] - BELOW_CEILING))
    v_WB, w_WB = np.array(point.velocity), np.array([0.0, 0.0, point.yaw_rate])
    return Trim(
        point=point,
        q_WB=attitude.ToQuaternion().wxyz(),
        p_WB=np.array([0.0, 0.0, height]),
        v_WB=v_WB,
        w_WB=w_WB,
        vdot_WB=np.array(point.acceleration) + np.cross(w_WB, v_WB),
        speeds=frame.hover_speeds.copy(),
        commands=derivatives.steady_commands(frame.hover_speeds)[0],
        reference=np.array([*point.velocity, point.yaw_rate]),
        memory=np.array(derivatives.controller.initial_memory),
    )


def _residual(derivatives: Derivatives, trim: Trim, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual of the equations (6 + n + k), and its derivatives by the unknowns."""
    n, k = trim.speeds.size, trim.memory.size
    update = derivatives.settled_update(*update_inputs(trim, rate))
    steady, by_speeds = derivatives.steady_commands(trim.speeds)
    slopes, by = derivatives.slopes(trim.state, trim.speeds, steady)
    acceleration = slopes[6:STATE]
    held = by[6:STATE, STATE : STATE + n] + by[6:STATE, STATE + n :] @ by_speeds
    wanted = np.concatenate([np.zeros(3), trim.vdot_WB])
    scale, remembered = np.maximum(trim.speeds, 1.0), np.maximum(np.abs(trim.memory), 1.0)
    left = np.concatenate(
        [
            acceleration - wanted,
            (update.commands - trim.commands) / scale,
            (update.memory - trim.memory) / remembered,
        ]
    )

    before = slice(STATE + FILTERED, STATE + FILTERED + n)
    tilt, asked = slice(0, 2), slice(before.stop, before.stop + REFERENCE)
    lowpass = slice(before.start - REFERENCE, before.start)  # which has settled to the command
    jacobian = np.zeros((6 + n + k, 2 + n + REFERENCE + k))
    last = update.commands_by.shape[1] - k
    jacobian[:6, tilt] = by[6:STATE, tilt]
    jacobian[:6, 2 : 2 + n] = held
    for rows, found, same in (
        (slice(6, 6 + n), update.commands_by, np.eye(n)),
        (slice(6 + n, 6 + n + k), update.memory_by, np.zeros((k, n))),
    ):
        jacobian[rows, tilt] = found[:, tilt]
        jacobian[rows, 2 : 2 + n] = (found[:, before] - same) @ by_speeds
        jacobian[rows, 2 + n : 2 + n + REFERENCE] = found[:, asked] + found[:, lowpass]
        jacobian[rows, 2 + n + REFERENCE :] = found[:, last:]
    jacobian[6 + n :, 2 + n + REFERENCE :] -= np.eye(k)
    jacobian[6 : 6 + n] /= scale[:, None]
    jacobian[6 + n :] /= remembered[:, None]
    return left, jacobian


def _moved(derivatives: Derivatives, trim: Trim, change: np.ndarray, n: int) -> Trim:
    """Return a trim after a Newton step."""
    speeds = np.maximum(trim.speeds + change[2 : 2 + n], 0.0)
    q = trim.q_WB + angle_seeds(trim.q_WB)[:, :2] @ change[:2]
    return replace(
        trim,
        q_WB=q / np.linalg.norm(q),
        speeds=speeds,
        commands=derivatives.steady_commands(speeds)[0],
        reference=trim.reference + change[2 + n : 2 + n + REFERENCE],
        memory=trim.memory + change[2 + n + REFERENCE :],
    )
