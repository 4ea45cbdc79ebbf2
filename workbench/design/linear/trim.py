"""Find the attitude, rotor speeds and reference that make a flight steady."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.control.guidance import Guidance, Reference
from workbench.control.law_signals import FILTER_STATE_COUNT
from workbench.design.linear.derivatives import HELD_SIZE, REFERENCE_SIZE, Derivatives
from workbench.design.linear.model import Trim
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.seeds import MOTION_STATE_SIZE, angle_seeds
from workbench.plant.formats.values import listed_names
from workbench.plant.payload import payload_of, vehicle_with_payload
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

TRIM_HEIGHT_M = 10.0
"""Height of the trim: far from the ground, and from any ceiling but a low one [m]."""
CEILING_DISTANCE_M = 2.0
"""Smallest distance of the trim below the largest height, where climbs are slowed [m]."""
TRIM_TOLERANCE = 1e-9
"""Tolerance of accelerations [m/s², rad/s²], of commands as shares of their speeds, and of the
memory, relative for numbers above 1."""
MAX_TRIM_ROUNDS = 40
MAX_TRIM_TURN_RAD = 0.3
"""Largest change of the attitude, or of a joint, in an iteration [rad or m]."""
RESTLESS_ACCELERATION = 1e-3
"""Acceleration of a joint from which on a failed search names it [rad/s² or m/s²]."""
JOINT_STIFFNESS_SCALE = 100.0
"""Acceleration over position of a joint above which its residual is relative [1/s²]: rounding."""


def find_trim(
    derivatives: Derivatives,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    point: OperatingPoint,
    rate: float,
) -> Trim:
    """Return the trim of an operating point, by Newton's method.

    Unknowns are the tilt, the rotor speeds, the setpoints of servos, the commanded velocity and
    yaw rate, the memory of the law, and the positions of the joints. The equations are that
    accelerations are those of the point, commands equal the speeds and setpoints, the memory is
    constant, and joints stay at rest. While a position is held, its setpoint is unknown in place of
    the velocity: a law without integrator stays beside it if the vehicle is not the one it knows,
    as below an arm that sags.

    Args:
        derivatives: of what flies, with these gains set.
        vehicle: about the flying one, without its payload, as the start of the search.
        gains: parameter values by name.
        point: to be reached.
        rate: of the acceleration estimate, see `systems.acceleration_estimate` [1/s].

    Raises:
        WorkbenchError: if no command makes it fly like that.
    """
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
    places = _unknowns(trim)
    best, before, change = np.inf, trim, np.zeros(0)
    for _ in range(MAX_TRIM_ROUNDS):
        residual, jacobian = _residual(derivatives, trim, rate)
        worst = float(np.abs(residual).max())
        if vehicle.cables and worst > best and change.size:  # too far: a cable went slack
            change = 0.5 * change
            trim = _stepped_trim(derivatives, before, change)
            continue
        if not np.isfinite(worst) or not np.isfinite(jacobian).all():
            break
        best = min(best, worst)
        if worst < TRIM_TOLERANCE:
            return trim
        free = _free_unknowns(trim, jacobian)
        change = np.zeros(jacobian.shape[1])
        change[free] = np.linalg.lstsq(jacobian[:, free], -residual, rcond=1e-12)[0]
        turn = float(np.abs([*change[places.tilt], *change[places.joints]]).max())
        change *= min(1.0, MAX_TRIM_TURN_RAD / max(turn, 1e-12))
        before, trim = trim, _stepped_trim(derivatives, trim, change)
    raise WorkbenchError(
        f"there is no flight as '{point.label}' for {vehicle.name} with these gains: "
        f"{best:.2g} m/s², rad/s² or shares of a rotor's speed remain; "
        f"{_restless_joints(derivatives, residual)}it may be beyond "
        "max_speed, max_climb_rate, max_yaw_rate, max_tilt or what the rotors can give"
    )


def _restless_joints(derivatives: Derivatives, residual: np.ndarray) -> str:
    """Return a clause on the joints that accelerate, "" without any."""
    positions = derivatives.plant.joint_signals[: len(derivatives.plant.joint_signals) // 2]
    left = residual[len(residual) - len(positions) :]
    names = dict.fromkeys(  # a joint of several freedoms once
        f"'{signal.name.rpartition('_')[0]}'"
        for signal, acceleration in zip(positions, left, strict=True)
        if abs(acceleration) > RESTLESS_ACCELERATION
    )
    return f"no position keeps {listed_names(list(names))} at rest, or " if names else ""


def guidance_of(trim: Trim) -> np.ndarray:
    """Return the guidance (22) of a trim: motors on, and the position held if required."""
    hold = float(trim.point.hold)
    x, y, z = trim.p_WB_setpoint.tolist()
    return np.array(Guidance(1.0, 1.0, 1.0, 0.0, hold, hold, x, y, z), dtype=float)


def reference_of(trim: Trim) -> np.ndarray:
    """Return the pilot's reference (8) of a trim."""
    return np.concatenate([trim.reference, np.zeros(len(Reference._fields) - REFERENCE_SIZE)])


def filtered_of(trim: Trim, rate: float) -> np.ndarray:
    """Return the states of the filters before the law in a trim (10), see `FilterStates`."""
    velocity = trim.v_WB - trim.vdot_WB / rate
    return np.concatenate([velocity, trim.vdot_WB, trim.reference])


def update_inputs(trim: Trim, rate: float, measured_joints: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the inputs of `Derivatives.update` in a trimmed flight.

    Args:
        trim: where.
        rate: as in `find_trim`.
        measured_joints: see `Derivatives.measured_joints`.
    """
    state = trim.state
    if measured_joints.size:
        joints = np.concatenate([trim.joints, np.zeros_like(trim.joints)])
        state = np.concatenate([state, joints[measured_joints]])
    return (
        state,
        filtered_of(trim, rate),
        trim.commands,
        reference_of(trim),
        guidance_of(trim),
        trim.memory,
    )


def _first_guess(
    derivatives: Derivatives, vehicle: Vehicle, gains: Mapping[str, float], point: OperatingPoint
) -> Trim:
    frame = thrust_frame(vehicle_with_payload(vehicle, payload_of(gains)))
    attitude = RollPitchYaw(np.array(frame.roll_pitch_yaw([0.0, 0.0, 0.0])))
    height = min(TRIM_HEIGHT_M, max(0.0, gains["max_height"] - CEILING_DISTANCE_M))
    p_WB = np.array([0.0, 0.0, height])
    v_WB, w_WB = np.array(point.velocity), np.array([0.0, 0.0, point.yaw_rate])
    return Trim(
        point=point,
        q_WB=attitude.ToQuaternion().wxyz(),
        p_WB=p_WB,
        v_WB=v_WB,
        w_WB=w_WB,
        vdot_WB=np.array(point.acceleration) + np.cross(w_WB, v_WB),
        speeds=frame.hover_speeds.copy(),
        commands=np.concatenate(
            [
                derivatives.steady_commands(frame.hover_speeds)[0],
                np.zeros(len(derivatives.commanded_joints)),
            ]
        ),
        reference=np.array([*point.velocity, point.yaw_rate]),
        p_WB_setpoint=p_WB,
        memory=np.array(derivatives.controller.initial_memory),
        joints=derivatives.plant.joint_start,
    )


class _Unknowns(NamedTuple):
    """Places of the unknowns of a trim.

    Attributes:
        tilt: roll and pitch (2).
        commands: of rotors and servos (c).
        steered: velocity and yaw rate that the pilot commands (4).
        held: setpoint of the position (3).
        memory: of the law (k).
        joints: their positions (j).
    """

    tilt: slice
    commands: slice
    steered: slice
    held: slice
    memory: slice
    joints: slice


def _unknowns(trim: Trim) -> _Unknowns:
    """Return the places of the unknowns."""
    sizes = (2, trim.commands.size, REFERENCE_SIZE, HELD_SIZE, trim.memory.size, trim.joints.size)
    ends = np.cumsum(sizes).tolist()
    return _Unknowns(*(slice(end - size, end) for size, end in zip(sizes, ends, strict=True)))


def _free_unknowns(trim: Trim, jacobian: np.ndarray) -> np.ndarray:
    """Return which of the unknowns Newton's method changes (u).

    Any velocity that a pilot commands ends a hold, so the setpoint of the position takes its place
    along each axis that the law holds.
    """
    free = np.ones(jacobian.shape[1], dtype=bool)
    places = _unknowns(trim)
    if not trim.point.hold:
        free[places.held] = False
    elif trim.memory.size:
        free[places.steered] = False
    else:
        velocity = slice(places.steered.start, places.steered.start + HELD_SIZE)
        free[velocity] = ~jacobian[:, places.held].any(axis=0)
    return free


def _residual(derivatives: Derivatives, trim: Trim, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the residual of the equations (6 + c + k + j), and its derivatives by the unknowns."""
    n, k, j = trim.speeds.size, trim.memory.size, trim.joints.size
    c = trim.commands.size
    update = derivatives.settled_update(*update_inputs(trim, rate, derivatives.measured_joints))
    rotors, by_rotors = derivatives.steady_commands(trim.speeds)
    steady, by_speeds = np.concatenate([rotors, trim.commands[n:]]), np.eye(c)
    by_speeds[:n, :n] = by_rotors
    slopes, by = derivatives.slopes(trim.state, trim.speeds, steady, trim.joints)
    acceleration = slopes[6:MOTION_STATE_SIZE]
    first, size = MOTION_STATE_SIZE + n, len(slopes)
    # accelerations of the body and of the joints
    accelerations = [*range(6, MOTION_STATE_SIZE), *range(first + j, size)]
    moved = by[accelerations]
    held = moved[:, size:] @ by_speeds
    held[:, :n] += moved[:, MOTION_STATE_SIZE:first]
    placed = moved[:, first : first + j]
    stiff = np.maximum(np.abs(placed[6:]).max(axis=1, initial=0.0) / JOINT_STIFFNESS_SCALE, 1.0)
    wanted = np.concatenate([np.zeros(3), trim.vdot_WB])
    scale = np.maximum(np.concatenate([trim.speeds, np.zeros(c - n)]), 1.0)
    remembered = np.maximum(np.abs(trim.memory), 1.0)
    n = c  # speeds and setpoints are unknowns alike from here on
    left = np.concatenate(
        [
            acceleration - wanted,
            (update.commands - trim.commands) / scale,
            (update.memory - trim.memory) / remembered,
            slopes[first + j :] / stiff,
        ]
    )

    seen = MOTION_STATE_SIZE + derivatives.measured_joints.size
    before = slice(seen + FILTER_STATE_COUNT, seen + FILTER_STATE_COUNT + n)
    asked = slice(before.stop, before.stop + REFERENCE_SIZE)
    lowpass = slice(before.start - REFERENCE_SIZE, before.start)  # which has settled to the command
    places = _unknowns(trim)
    jacobian = np.zeros((6 + n + k + j, places.joints.stop))
    last = update.commands_by.shape[1] - k
    moves = [*range(6), *range(6 + n + k, 6 + n + k + j)]
    jacobian[moves, places.tilt] = moved[:, :2]
    jacobian[moves, places.commands] = held
    jacobian[moves, places.joints] = placed
    for rows, found, same in (
        (slice(6, 6 + n), update.commands_by, np.eye(n)),
        (slice(6 + n, 6 + n + k), update.memory_by, np.zeros((k, n))),
    ):
        jacobian[rows, places.tilt] = found[:, :2]
        jacobian[rows, places.commands] = (found[:, before] - same) @ by_speeds
        jacobian[rows, places.steered] = found[:, asked] + found[:, lowpass]
        jacobian[rows, places.held] = found[:, asked.stop : asked.stop + HELD_SIZE]
        jacobian[rows, places.memory] = found[:, last:]
        for column, place in enumerate(derivatives.measured_joints):
            if place < j:
                jacobian[rows, places.joints.start + place] = found[:, MOTION_STATE_SIZE + column]
    jacobian[6 + n : 6 + n + k, places.memory] -= np.eye(k)
    jacobian[6 : 6 + n] /= scale[:, None]
    jacobian[6 + n : 6 + n + k] /= remembered[:, None]
    jacobian[6 + n + k :] /= stiff[:, None]
    return left, jacobian


def _stepped_trim(derivatives: Derivatives, trim: Trim, change: np.ndarray) -> Trim:
    """Return a trim after a Newton step."""
    rotors = trim.speeds.size
    tilt, commanded, steered, held, remembered, joints = (change[each] for each in _unknowns(trim))
    speeds = np.maximum(trim.speeds + commanded[:rotors], 0.0)
    q = trim.q_WB + angle_seeds(trim.q_WB)[:, :2] @ tilt
    commands = [derivatives.steady_commands(speeds)[0], trim.commands[rotors:] + commanded[rotors:]]
    return replace(
        trim,
        q_WB=q / np.linalg.norm(q),
        speeds=speeds,
        commands=np.concatenate(commands),
        reference=trim.reference + steered,
        p_WB_setpoint=trim.p_WB_setpoint + held,
        memory=trim.memory + remembered,
        joints=trim.joints + joints,
    )
