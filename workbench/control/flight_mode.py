"""The flight mode: its transitions, and the guidance of each mode.

Pure functions of plain numbers; `mode_manager` runs them as a Drake system.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.control.guidance import BRAKE_FIELD, Guidance, Reference
from workbench.control.mode import FlightMode, ModeRequest, Reason
from workbench.control.obstacle_brake import MAX_WALLS

SPOOL_UP_TIME_S = 0.5
"""Rotors idle this long before a take-off [s]."""
MAX_HOVERING_SPEED = 0.2
"""Below this speed a drone counts as hovering [m/s]."""
STOPPING_TIME_S = 0.25
"""A drone that starts to hold uses the point that it reaches in this time [s]."""
MAX_TOUCH_DOWN_SPEED = 0.05
MIN_TOUCH_DOWN_TIME_S = 0.5
MAX_TOUCH_DOWN_HEIGHT_M = 0.1
"""A landing drone slower than this for this long, this near the ground, has landed [m/s, s, m]."""
SINK_RATE = 0.5
SLOW_DESCENT_HEIGHT_M = 2.0
MAX_SINK_SPEED = 2.0
"""A landing descends at SINK_RATE [1/s] times the height above
SLOW_DESCENT_HEIGHT_M, up to MAX_SINK_SPEED [m/s], if that is faster than the landing speed."""
MIN_DOWNWARD_COMPONENT = 0.7
"""A wall whose direction points down by this much or more is below the drone."""
MIN_STANDING_TIME_S = 2.0
"""Above that height, a drone slower for this long has landed if something carries it [s]."""
MIN_CARRYING_COMPONENT = 0.7
"""A contact force whose direction points up by this much or more carries the drone. That of a wall
never does, with a friction coefficient below 0.98."""
MIN_ARREST_TIME_S = 0.2
MAX_ARREST_HEIGHT_M = 0.5
"""With a lost position, a landing ends when the descent has stopped for this long below this
height: on the ground the estimate still moves, so the usual test would not end it [s, m]."""
MAX_GPS_AGE_S = 1.0
"""Without a GPS sample for longer, the position is dead reckoning [s]."""
MAX_HEADING_AGE_S = 2.0
"""Without a magnetometer sample for longer, the heading follows the gyro alone [s]."""
TAKE_OFF_TIMEOUT_S = 3.0
"""A take-off that no longer climbs, for example under a ceiling, becomes a hover after this [s]."""


HOVERING, ASCENDING, DESCENDING, CRUISING = map(
    float, (FlightMode.HOVERING, FlightMode.ASCENDING, FlightMode.DESCENDING, FlightMode.CRUISING)
)
HOLD_HEIGHT_M = 0.01
"""Height that aborts a landing without a climb: no drone in the air is that low [m]."""


class FlightModeSettings(NamedTuple):
    """Live parameters of the flight mode."""

    take_off_speed: float
    landing_speed: float
    battery_reserve: float
    obstacle_brake: float = 0.0
    stop_distance: float = 0.5
    position_deviation_limit: float = 5.0
    gps_timeout: float = 5.0
    imu_timeout: float = 0.1


class EstimateHealth(NamedTuple):
    """The state of health of an estimate.

    Attributes:
        deviation: standard deviation of the horizontal position, root of the sum of both variances
            [m]; NaN if the estimator has none.
        gps_age: time since the estimate used a GPS sample [s].
        imu_age: for how long the gyro readings have been the same [s].
        heading_age: time since it used a magnetometer sample, 0 without a magnetometer [s].
    """

    deviation: float
    gps_age: float
    imu_age: float
    heading_age: float


class ModeState(NamedTuple):
    """The state of the flight mode; only numbers, so that it is a Drake state vector.

    `serial` counts requests seen; `since` is the start of the mode [s]; `still_since` when the
    drone last moved [s]; `target` the take-off height [m]; `holding` 1 while (x, y, z) is held [m],
    in a landing once it has braked; `reason` is a `mode.Reason`.
    """

    mode: float
    serial: float
    since: float
    still_since: float
    target: float
    holding: float
    x: float
    y: float
    z: float
    reason: float = 0.0


REASON_INDEX = ModeState._fields.index("reason")


class FlightModeInputs(NamedTuple):
    """The inputs of the flight mode at an update; frames and units as in `pd`.

    `health` is that of the estimate of position and velocity, None with the true state. The true
    `charge` decides when the rotors stop, the `known_charge` when the drone lands. `ended` is
    whether the program that runs the law has ended. `contact_force` is the total one on the drone
    in W [N].
    """

    time: float
    p_WB: list[float]
    v_WB: list[float]
    reference: Reference
    request: int
    serial: float
    height: float
    charge: float
    standing_height: float
    health: EstimateHealth | None = None
    known_charge: float | None = None
    ended: bool = False
    contact_force: Vector3 = (0.0, 0.0, 0.0)


def accepts_request(mode: FlightMode, request: ModeRequest) -> bool:
    """Return whether a request has an effect in a mode, or is already fulfilled."""
    if request is ModeRequest.ARM:
        return mode is FlightMode.OFF
    if request is ModeRequest.TAKE_OFF:
        return mode in (FlightMode.OFF, FlightMode.ARMED, FlightMode.TAKING_OFF)
    if request is ModeRequest.ABORT_LANDING:
        return mode is FlightMode.LANDING
    return True


def in_the_air(height: float, standing_height: float) -> bool:
    """Return whether a drone is too high to stand on the ground [m]."""
    return height > standing_height + MAX_TOUCH_DOWN_HEIGHT_M


def is_carried(contact_force: Vector3) -> bool:
    """Return whether a contact force in W [N] carries the drone."""
    return contact_force[2] > MIN_CARRYING_COMPONENT * math.hypot(*contact_force)


def initial_state(mode: FlightMode, p_WB: list[float]) -> ModeState:
    """Return the state of a flight that begins in a mode at a position."""
    holding = float(mode is FlightMode.HOVERING)
    return ModeState(float(mode), 0.0, 0.0, 0.0, 0.0, holding, *p_WB)


def next_state(state: ModeState, now: FlightModeInputs, settings: FlightModeSettings) -> ModeState:
    """Return the state after one update."""
    request = ModeRequest(now.request) if now.serial != state.serial else ModeRequest.NONE
    state = state._replace(serial=now.serial)
    mode = FlightMode(int(state.mode))
    if request is ModeRequest.STOP:
        return _enter(FlightMode.OFF, state, now)
    if now.ended:  # without a controller, no other mode can be flown
        return state._replace(reason=float(Reason.AUTOPILOT_ENDED))
    if now.charge <= 0.0 and mode is not FlightMode.OFF:
        return _enter(FlightMode.OFF, state, now, Reason.BATTERY_EMPTY)
    if imu_failed(now.health, settings) and mode is not FlightMode.OFF:
        return _enter(FlightMode.OFF, state, now, Reason.IMU_FAILED)
    if mode in (FlightMode.OFF, FlightMode.ARMED):
        return _on_the_ground(mode, request, state, now)
    lost = position_lost(now.health, settings)
    if mode is FlightMode.LANDING:
        if lost and state.reason != Reason.POSITION_LOST:
            state = _losing_position(state, now)
        return _landing(request, state, now, settings)
    if request is ModeRequest.LAND:
        return _enter(FlightMode.LANDING, state, now, _missing_aid(now.health))
    known = now.charge if now.known_charge is None else now.known_charge
    if known <= settings.battery_reserve:
        return _enter(FlightMode.LANDING, state, now, Reason.BATTERY_LOW)
    if lost:
        return _losing_position(_enter(FlightMode.LANDING, state, now), now)
    state = state._replace(reason=float(_missing_aid(now.health)))
    if mode is FlightMode.TAKING_OFF:
        return _taking_off(request, state, now)
    return _flying(state, now)


def position_lost(health: EstimateHealth | None, settings: FlightModeSettings) -> bool:
    """Return whether an estimate no longer knows the drone's position.

    The criterion is its standard deviation, as in PX4's COM_POS_FS_EPH and ArduPilot's
    FS_EKF_THRESH. Without one, it is the time since the last GPS sample, as in PX4's
    EKF2_NOAID_TOUT.
    """
    if health is None:
        return False
    if math.isnan(health.deviation):
        return health.gps_age > settings.gps_timeout
    return health.deviation > settings.position_deviation_limit


def imu_failed(health: EstimateHealth | None, settings: FlightModeSettings) -> bool:
    """Return whether the IMU's readings no longer change; those of a working one always do.

    PX4's DataValidator uses repeated values as the sign of a stuck sensor, too.
    """
    return health is not None and health.imu_age > settings.imu_timeout


def guidance(state: ModeState, p_WB: list[float], settings: FlightModeSettings) -> Guidance:
    """Return the guidance of a state."""
    mode = FlightMode(int(state.mode))
    motors = float(mode is not FlightMode.OFF)
    if mode in (FlightMode.OFF, FlightMode.ARMED):
        return Guidance(motors, 0.0, 0.0, 0.0, 0.0, 0.0, state.x, state.y, state.z)
    if mode is FlightMode.TAKING_OFF:
        climb = min(settings.take_off_speed, 1.5 * (state.target - p_WB[2]))
        return Guidance(motors, 1.0, 0.0, climb, 1.0, 0.0, state.x, state.y, state.z)
    if mode is FlightMode.LANDING:
        fast = min(MAX_SINK_SPEED, SINK_RATE * (p_WB[2] - SLOW_DESCENT_HEIGHT_M))
        sink = -state.holding * max(settings.landing_speed, fast)  # brake before sinking
        # an unknown position is not held
        hold_xy = 0.0 if state.reason == Reason.POSITION_LOST else state.holding
        return Guidance(motors, 1.0, 0.0, sink, hold_xy, 0.0, state.x, state.y, state.z)
    hold = state.holding
    return Guidance(motors, 1.0, 1.0, 0.0, hold, hold, state.x, state.y, state.z)


def with_walls(
    guide: Guidance,
    walls: Sequence[float],
    p_WB: Sequence[float],
    mode: FlightMode,
    settings: FlightModeSettings,
) -> Guidance:
    """Return guidance that also limits the speed towards obstacles.

    In a landing, walls below the drone do not count.

    Args:
        guide: without walls.
        walls: (4 `MAX_WALLS`) direction in W and clearance [m] of each, nearest first; an infinite
            clearance means none.
        p_WB: position [m].
        mode: the present one.
        settings: brake and the distance at which to stop.
    """
    if settings.obstacle_brake <= 0.0:
        return guide
    numbers = [settings.obstacle_brake] + [0.0] * (4 * MAX_WALLS)
    for wall in range(MAX_WALLS):
        *n_W, clearance = walls[4 * wall : 4 * wall + 4]
        below = mode is FlightMode.LANDING and n_W[2] <= -MIN_DOWNWARD_COMPONENT
        if math.isfinite(clearance) and not below:
            along = sum(n * p for n, p in zip(n_W, p_WB, strict=True))
            offset = along + clearance - settings.stop_distance
            numbers[1 + 4 * wall : 5 + 4 * wall] = [*n_W, offset]
    return Guidance(*guide[:BRAKE_FIELD], *numbers)


def _enter(
    mode: FlightMode, state: ModeState, now: FlightModeInputs, reason: Reason = Reason.NONE
) -> ModeState:
    """Begin a mode here and now."""
    x, y, z = now.p_WB
    begun = now.time
    return ModeState(float(mode), state.serial, begun, begun, 0.0, 0.0, x, y, z, float(reason))


def _missing_aid(health: EstimateHealth | None) -> Reason:
    """Return what a usable estimate lacks."""
    if health is None:
        return Reason.NONE
    if health.gps_age > MAX_GPS_AGE_S:
        return Reason.DEAD_RECKONING
    if health.heading_age > MAX_HEADING_AGE_S:
        return Reason.HEADING_DRIFTS
    return Reason.NONE


def _on_the_ground(
    mode: FlightMode, request: ModeRequest, state: ModeState, now: FlightModeInputs
) -> ModeState:
    if request is ModeRequest.TAKE_OFF:
        armed = state if mode is FlightMode.ARMED else _enter(FlightMode.ARMED, state, now)
        return armed._replace(target=now.height)
    if request is ModeRequest.ARM and mode is FlightMode.OFF:
        return _enter(FlightMode.ARMED, state, now)
    if request is ModeRequest.LAND:
        return _enter(FlightMode.OFF, state, now)
    if request is ModeRequest.HOLD:
        return state._replace(target=0.0)
    if state.target > 0.0 and now.time - state.since >= SPOOL_UP_TIME_S:
        return _enter(FlightMode.TAKING_OFF, state, now)._replace(target=state.target)
    return state


def _taking_off(request: ModeRequest, state: ModeState, now: FlightModeInputs) -> ModeState:
    if request is ModeRequest.TAKE_OFF:
        return state._replace(target=now.height)
    reason = Reason(int(state.reason))
    if request is ModeRequest.HOLD:
        return _enter(FlightMode.HOVERING, state, now, reason)
    z = now.p_WB[2]
    arrived = abs(z - state.target) < 0.05 and abs(now.v_WB[2]) < MAX_HOVERING_SPEED
    if abs(now.v_WB[2]) > MAX_TOUCH_DOWN_SPEED:
        state = state._replace(still_since=now.time)
    stuck = now.time - state.still_since > TAKE_OFF_TIMEOUT_S
    if arrived or stuck:
        height = state.target if arrived else z
        return _enter(FlightMode.HOVERING, state, now, reason)._replace(
            holding=1.0, x=state.x, y=state.y, z=height
        )
    return state


def _losing_position(state: ModeState, now: FlightModeInputs) -> ModeState:
    """Let a landing descend at once: without a position it cannot brake."""
    return state._replace(
        holding=1.0, since=now.time, still_since=now.time, reason=float(Reason.POSITION_LOST)
    )


def _landing(
    request: ModeRequest, state: ModeState, now: FlightModeInputs, settings: FlightModeSettings
) -> ModeState:
    z = now.p_WB[2]
    if request is ModeRequest.ABORT_LANDING and in_the_air(z, now.standing_height):
        if now.height > z:
            return _enter(FlightMode.TAKING_OFF, state, now)._replace(target=now.height)
        return _enter(FlightMode.HOVERING, state, now)
    if not state.holding:
        v_x, v_y, _ = now.v_WB
        if (v_x * v_x + v_y * v_y) ** 0.5 > MAX_HOVERING_SPEED:
            return state
        x, y = (p + STOPPING_TIME_S * v for p, v in zip(now.p_WB[:2], now.v_WB[:2], strict=True))
        return state._replace(holding=1.0, since=now.time, still_since=now.time, x=x, y=y)
    moving = abs(now.v_WB[2]) > MAX_TOUCH_DOWN_SPEED
    high = in_the_air(z, now.standing_height)
    unsupported = (high or now.health is not None) and not is_carried(now.contact_force)
    enough = MIN_STANDING_TIME_S if high else MIN_TOUCH_DOWN_TIME_S
    if state.reason == Reason.POSITION_LOST and z < now.standing_height + MAX_ARREST_HEIGHT_M:
        moving = now.v_WB[2] < -0.5 * settings.landing_speed
        enough = MIN_ARREST_TIME_S
        unsupported = False
    if moving or unsupported or now.time - state.since < 2.0 * MIN_TOUCH_DOWN_TIME_S:
        return state._replace(still_since=now.time)
    if now.time - state.still_since >= enough:
        return _enter(FlightMode.OFF, state, now, Reason(int(state.reason)))
    return state


def _flying(state: ModeState, now: FlightModeInputs) -> ModeState:
    """Choose among the flying modes, and hold the position without a command."""
    mode, holding, x, y, z = flying(
        state.holding, (state.x, state.y, state.z), now.p_WB, now.v_WB, now.reference
    )
    since = state.since if mode == int(state.mode) else now.time
    return state._replace(mode=mode, since=since, holding=holding, x=x, y=y, z=z)


@register_jitable
def flying(
    holding: float, held: Numbers, p_WB: Numbers, v_WB: Numbers, reference: Numbers
) -> tuple[float, float, float, float, float]:
    """Return the flying mode, whether a position is held (0 or 1), and that position (3) [m].

    Compiled flights have only these modes.

    Args:
        holding: whether a position was held until now.
        held: that position (3) [m].
        p_WB: position (3) [m].
        v_WB: velocity in W (3) [m/s].
        reference: see `guidance.Reference` (8).
    """
    v_x, v_y, v_z = v_WB
    x, y, z = held
    level = (v_x * v_x + v_y * v_y) ** 0.5
    mode = HOVERING
    if level > MAX_HOVERING_SPEED and level >= abs(v_z):
        mode = CRUISING
    elif abs(v_z) > MAX_HOVERING_SPEED:
        mode = ASCENDING if v_z > 0.0 else DESCENDING
    ask_x, ask_y, ask_z, _, _, _, _, follow = reference
    if ask_x != 0.0 or ask_y != 0.0 or ask_z != 0.0 or follow != 0.0:
        holding = 0.0
    elif mode == HOVERING and holding == 0.0:
        holding = 1.0
        x = p_WB[0] + STOPPING_TIME_S * v_x
        y = p_WB[1] + STOPPING_TIME_S * v_y
        z = p_WB[2] + STOPPING_TIME_S * v_z
    return mode, holding, x, y, z
