"""A drone's topics as MAVLink messages: north-east-down, forward-right-down, MAVLink's integers.

Source: MAVLink's common message set, version 2.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

SYSTEM_ID, COMPONENT_ID = 1, mavlink.MAV_COMP_ID_AUTOPILOT1
MAX_PARAMETER_ID_CHARS = 16
"""Largest number of characters of a parameter name in MAVLink."""
MAX_STATUSTEXT_CHARS = 50
"""Largest number of characters of a STATUSTEXT; longer sentences are split."""
VOWELS = "aeiou"
UNKNOWN_16 = 0xFFFF
UNKNOWN_32 = 0xFFFFFFFF
OFF_MODE = 0
ARMED_MODE = 1
TAKING_OFF_MODE = 2
HOLD_MODE = 3
ASCENDING_MODE = 4
DESCENDING_MODE = 5
CRUISING_MODE = 6
LANDING_MODE = 7
"""Modes of the topic drone_state, see docs/protocol.md."""
GROUND_MODES = (OFF_MODE, ARMED_MODE)
LANDED_STATE_BY_MODE = {
    OFF_MODE: mavlink.MAV_LANDED_STATE_ON_GROUND,
    ARMED_MODE: mavlink.MAV_LANDED_STATE_ON_GROUND,
    TAKING_OFF_MODE: mavlink.MAV_LANDED_STATE_TAKEOFF,
    LANDING_MODE: mavlink.MAV_LANDED_STATE_LANDING,
}
MAVLINK_SEVERITIES = (
    mavlink.MAV_SEVERITY_INFO,
    mavlink.MAV_SEVERITY_WARNING,
    mavlink.MAV_SEVERITY_ERROR,
)
"""MAVLink severities of our events: information, warning, failure."""

TopicFields = Mapping[str, Any]
MavlinkMessage = Any
"""A message of pymavlink."""


def motion_messages(
    t_ns: int, position: TopicFields, velocity: TopicFields
) -> list[MavlinkMessage]:
    """Return ATTITUDE, LOCAL_POSITION_NED and VFR_HUD.

    Args:
        t_ns: simulated time [ns].
        position: fields of the topic position_data, in W.
        velocity: fields of velocity_data, in W.
    """
    now = milliseconds(t_ns)
    roll, pitch, yaw = position["roll"], -position["pitch"], compass_heading(position["yaw"])
    north, east, up = velocity["v_y"], velocity["v_x"], velocity["v_z"]
    return [
        mavlink.MAVLink_attitude_message(
            now, roll, pitch, yaw, *frd_body_rates(position, velocity)
        ),
        mavlink.MAVLink_local_position_ned_message(
            now, position["y"], position["x"], -position["z"], north, east, -up
        ),
        mavlink.MAVLink_vfr_hud_message(
            0.0, math.hypot(north, east), round(math.degrees(yaw)) % 360, 0, position["z"], up
        ),
    ]


def compass_heading(yaw: float) -> float:
    """Return the heading, clockwise from north, of a yaw counter-clockwise from east [rad]."""
    return math.remainder(math.pi / 2.0 - yaw, math.tau)


def frd_body_rates(position: TopicFields, velocity: TopicFields) -> tuple[float, float, float]:
    """Return the angular velocity about forward, right and down [rad/s].

    Args:
        position: with roll, pitch and yaw of B in W [rad].
        velocity: with w_x, w_y and w_z in W [rad/s].
    """
    c_r, s_r = math.cos(position["roll"]), math.sin(position["roll"])
    c_p, s_p = math.cos(position["pitch"]), math.sin(position["pitch"])
    c_y, s_y = math.cos(position["yaw"]), math.sin(position["yaw"])
    ahead = c_y * velocity["w_x"] + s_y * velocity["w_y"]
    left = c_y * velocity["w_y"] - s_y * velocity["w_x"]
    up = velocity["w_z"]
    along, top = c_p * ahead - s_p * up, s_p * ahead + c_p * up
    return along, -(c_r * left + s_r * top), -(c_r * top - s_r * left)


def position_messages(t_ns: int, gps: TopicFields, position: TopicFields) -> list[MavlinkMessage]:
    """Return GPS_RAW_INT and GLOBAL_POSITION_INT.

    Args:
        t_ns: simulated time [ns].
        gps: fields of the topic gps.
        position: fields of position_data, in W.
    """
    east, north, up = gps["velocity"]
    place = _integer_place(gps["latitude"], gps["longitude"], gps["altitude"])
    course = round(100.0 * (math.degrees(math.atan2(east, north)) % 360.0)) % 36000
    speed = min(round(100.0 * math.hypot(east, north)), UNKNOWN_16 - 1)
    nose = round(100.0 * (math.degrees(compass_heading(position["yaw"])) % 360.0)) % 36000
    rates = (round(100.0 * north), round(100.0 * east), round(-100.0 * up))
    return [
        mavlink.MAVLink_gps_raw_int_message(
            t_ns // 1000,
            mavlink.GPS_FIX_TYPE_3D_FIX,
            *place,
            UNKNOWN_16,
            UNKNOWN_16,
            speed,
            course,
            255,
        ),
        mavlink.MAVLink_global_position_int_message(
            milliseconds(t_ns), *place, round(1e3 * position["z"]), *rates, nose
        ),
    ]


def home_messages(home: Sequence[float]) -> list[MavlinkMessage]:
    """Return HOME_POSITION and GPS_GLOBAL_ORIGIN; none without GPS.

    Args:
        home: latitude, longitude [rad] and altitude [m] of W's origin; empty if unknown.
    """
    if len(home) != 3:
        return []
    place = _integer_place(*home)
    nothing = (0.0, 0.0, 0.0)
    return [
        mavlink.MAVLink_home_position_message(*place, *nothing, [1.0, 0.0, 0.0, 0.0], *nothing),
        mavlink.MAVLink_gps_global_origin_message(*place),
    ]


def status_messages(
    state: TopicFields | None,
    on: bool,
    custom_mode: int,
    battery: TopicFields | None = None,
) -> list[MavlinkMessage]:
    """Return HEARTBEAT, and once known SYS_STATUS, BATTERY_STATUS and EXTENDED_SYS_STATE.

    Args:
        state: fields of the topic drone_state; None before the first.
        on: whether the rotors turn.
        custom_mode: of the vehicle, which a mission changes.
        battery: fields of the topic battery; None of an older server.
    """
    flags = (
        mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
        | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
        | mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    )
    if on:
        flags |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    beat = mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR,
        mavlink.MAV_AUTOPILOT_GENERIC,
        flags,
        custom_mode,
        mavlink.MAV_STATE_ACTIVE if on else mavlink.MAV_STATE_STANDBY,
        3,
    )
    if state is None:
        return [beat]
    charge = round(100.0 * float(state["charge"]))
    volts, amperes = (battery["voltage"], battery["current"]) if battery else (math.nan, math.nan)
    millivolts = _integer(1e3 * volts, UNKNOWN_16, UNKNOWN_16)
    centiamperes = _integer(1e2 * amperes, UNKNOWN_16 // 2, -1)
    sensor = mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    return [
        beat,
        mavlink.MAVLink_sys_status_message(
            sensor, sensor, sensor, 0, millivolts, centiamperes, charge, 0, 0, 0, 0, 0, 0
        ),
        mavlink.MAVLink_battery_status_message(
            0,
            mavlink.MAV_BATTERY_FUNCTION_ALL,
            mavlink.MAV_BATTERY_TYPE_LIPO,
            0x7FFF,
            [millivolts, *[UNKNOWN_16] * 9],
            centiamperes,
            -1,
            -1,
            charge,
        ),
        mavlink.MAVLink_extended_sys_state_message(
            mavlink.MAV_VTOL_STATE_UNDEFINED,
            LANDED_STATE_BY_MODE.get(int(state["mode"]), mavlink.MAV_LANDED_STATE_IN_AIR),
        ),
    ]


def event_text(event: TopicFields) -> tuple[str, int]:
    """Return the sentence of an event, and MAVLink's severity."""
    return str(event["said"]), MAVLINK_SEVERITIES[int(event["severity"])]


def text_messages(number: int, severity: int, sentence: str) -> list[MavlinkMessage]:
    """Return a sentence as one or more STATUSTEXT messages.

    Args:
        number: of the sentence, used by a station to join the pieces.
        severity: MAVLink's.
        sentence: the text.
    """
    text = sentence.encode("ascii", "replace")
    pieces = [
        text[at : at + MAX_STATUSTEXT_CHARS] for at in range(0, len(text), MAX_STATUSTEXT_CHARS)
    ]
    if len(pieces) <= 1:
        return [mavlink.MAVLink_statustext_message(severity, text)]
    if len(pieces[-1]) == MAX_STATUSTEXT_CHARS:  # a full piece means that another one follows
        pieces.append(b"")
    number = number % UNKNOWN_16 + 1
    return [
        mavlink.MAVLink_statustext_message(severity, piece, number, place)
        for place, piece in enumerate(pieces)
    ]


def parameter_ids(names: Iterable[str]) -> dict[str, str]:
    """Return the MAVLink id of each parameter, by its name.

    A name of more than 16 characters loses vowels of its longest words, then letters; the last
    character of duplicates becomes a number.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        short = short_parameter_id(name)
        count = 1
        while short in taken:
            count += 1
            short = f"{short[: MAX_PARAMETER_ID_CHARS - len(str(count))]}{count}"
        taken.add(short)
        found[name] = short
    return found


def short_parameter_id(name: str) -> str:
    """Return a name of at most 16 characters."""
    words = name.split("_")
    while len("_".join(words)) > MAX_PARAMETER_ID_CHARS:
        place = max(range(len(words)), key=lambda each: len(words[each]))
        word = words[place]
        vowel = max(map(word.lower().rfind, VOWELS))
        cut = vowel if vowel > 0 else len(word) - 1
        words[place] = word[:cut] + word[cut + 1 :]
    return "_".join(words)


def version_message() -> MavlinkMessage:
    """Return AUTOPILOT_VERSION, with the services of the gateway."""
    able = (
        mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_FTP
        | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    )
    none = [0] * 8
    return mavlink.MAVLink_autopilot_version_message(able, 0, 0, 0, 0, none, none, none, 0, 0, 0)


def whole_number(parameter: float) -> int:
    """Return a parameter of a command as an integer; NaN, which leaves it out, is 0."""
    return round(parameter) if math.isfinite(parameter) else 0


def _integer(number: float, limit: int, unknown: int) -> int:
    """Return a number as an integer, or what stands for one that is not known or too large."""
    return round(number) if abs(number) < limit else unknown


def _integer_place(latitude: float, longitude: float, altitude: float) -> tuple[int, int, int]:
    """Return latitude, longitude [1e-7 degrees] and altitude [mm] of an angle, an angle and [m]."""
    return (
        round(1e7 * math.degrees(latitude)),
        round(1e7 * math.degrees(longitude)),
        round(1e3 * altitude),
    )


def milliseconds(t_ns: int) -> int:
    """Return a time as MAVLink has it [ms]: it starts again at 0 after 49 days."""
    return t_ns // 1_000_000 & UNKNOWN_32
