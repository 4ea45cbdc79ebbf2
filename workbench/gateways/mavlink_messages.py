"""A drone's topics as MAVLink messages: north-east-down, forward-right-down, MAVLink's integers.

Source: MAVLink's common message set, version 2.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

SYSTEM, COMPONENT = 1, mavlink.MAV_COMP_ID_AUTOPILOT1
LONGEST_ID = 16
"""Largest number of characters of a parameter name in MAVLink."""
LONGEST_LINE = 50
"""Largest number of characters of a STATUSTEXT; longer sentences are split."""
VOWELS = "aeiou"
UNKNOWN_16 = 0xFFFF
UNKNOWN_32 = 0xFFFFFFFF
OFF = 0
ARMED = 1
TAKING_OFF = 2
LANDING = 7
"""Modes of the topic drone_state, see docs/protocol.md; those between are in flight."""
ON_THE_GROUND = (OFF, ARMED)
LANDED = {
    OFF: mavlink.MAV_LANDED_STATE_ON_GROUND,
    ARMED: mavlink.MAV_LANDED_STATE_ON_GROUND,
    TAKING_OFF: mavlink.MAV_LANDED_STATE_TAKEOFF,
    LANDING: mavlink.MAV_LANDED_STATE_LANDING,
}
SEVERITIES = (
    mavlink.MAV_SEVERITY_INFO,
    mavlink.MAV_SEVERITY_WARNING,
    mavlink.MAV_SEVERITY_ERROR,
)
"""MAVLink severities of our events: information, warning, failure."""

Fields = Mapping[str, Any]
Message = Any
"""A message of pymavlink."""


def motion_messages(t_ns: int, position: Fields, velocity: Fields) -> list[Message]:
    """Return ATTITUDE, LOCAL_POSITION_NED and VFR_HUD.

    Args:
        t_ns: simulated time [ns].
        position: fields of the topic position_data, in W.
        velocity: fields of velocity_data, in W.
    """
    now = _milliseconds(t_ns)
    roll, pitch, yaw = position["roll"], -position["pitch"], heading(position["yaw"])
    north, east, up = velocity["v_y"], velocity["v_x"], velocity["v_z"]
    return [
        mavlink.MAVLink_attitude_message(now, roll, pitch, yaw, *body_rates(position, velocity)),
        mavlink.MAVLink_local_position_ned_message(
            now, position["y"], position["x"], -position["z"], north, east, -up
        ),
        mavlink.MAVLink_vfr_hud_message(
            0.0, math.hypot(north, east), round(math.degrees(yaw)) % 360, 0, position["z"], up
        ),
    ]


def heading(yaw: float) -> float:
    """Return the heading, clockwise from north, of a yaw counter-clockwise from east [rad]."""
    return math.remainder(math.pi / 2.0 - yaw, math.tau)


def body_rates(position: Fields, velocity: Fields) -> tuple[float, float, float]:
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


def place_messages(t_ns: int, gps: Fields, position: Fields) -> list[Message]:
    """Return GPS_RAW_INT and GLOBAL_POSITION_INT.

    Args:
        t_ns: simulated time [ns].
        gps: fields of the topic gps.
        position: fields of position_data, in W.
    """
    east, north, up = gps["velocity"]
    place = (
        round(1e7 * math.degrees(gps["latitude"])),
        round(1e7 * math.degrees(gps["longitude"])),
        round(1e3 * gps["altitude"]),
    )
    course = round(100.0 * (math.degrees(math.atan2(east, north)) % 360.0)) % 36000
    speed = min(round(100.0 * math.hypot(east, north)), UNKNOWN_16 - 1)
    nose = round(100.0 * (math.degrees(heading(position["yaw"])) % 360.0)) % 36000
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
            _milliseconds(t_ns), *place, round(1e3 * position["z"]), *rates, nose
        ),
    ]


def status_messages(state: Fields | None, on: bool) -> list[Message]:
    """Return HEARTBEAT, and once known SYS_STATUS, BATTERY_STATUS and EXTENDED_SYS_STATE.

    Args:
        state: fields of the topic drone_state; None before the first.
        on: whether the rotors turn.
    """
    mode = int(state["mode"]) if state is not None else OFF
    flags = mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    if on:
        flags |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    beat = mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR,
        mavlink.MAV_AUTOPILOT_GENERIC,
        flags,
        mode,
        mavlink.MAV_STATE_ACTIVE if on else mavlink.MAV_STATE_STANDBY,
        3,
    )
    if state is None:
        return [beat]
    charge = round(100.0 * float(state["charge"]))
    battery = mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    return [
        beat,
        mavlink.MAVLink_sys_status_message(
            battery, battery, battery, 0, UNKNOWN_16, -1, charge, 0, 0, 0, 0, 0, 0
        ),
        mavlink.MAVLink_battery_status_message(
            0,
            mavlink.MAV_BATTERY_FUNCTION_ALL,
            mavlink.MAV_BATTERY_TYPE_LIPO,
            0x7FFF,
            [UNKNOWN_16] * 10,
            -1,
            -1,
            -1,
            charge,
        ),
        mavlink.MAVLink_extended_sys_state_message(
            mavlink.MAV_VTOL_STATE_UNDEFINED,
            LANDED.get(mode, mavlink.MAV_LANDED_STATE_IN_AIR),
        ),
    ]


def event_text(event: Fields) -> tuple[str, int]:
    """Return the sentence of an event, and MAVLink's severity."""
    return str(event["said"]), SEVERITIES[int(event["severity"])]


def text_messages(number: int, severity: int, sentence: str) -> list[Message]:
    """Return a sentence as one or more STATUSTEXT messages.

    Args:
        number: of the sentence, used by a station to join the pieces.
        severity: MAVLink's.
        sentence: the text.
    """
    text = sentence.encode("ascii", "replace")
    pieces = [text[at : at + LONGEST_LINE] for at in range(0, len(text), LONGEST_LINE)]
    if len(pieces) <= 1:
        return [mavlink.MAVLink_statustext_message(severity, text)]
    if len(pieces[-1]) == LONGEST_LINE:  # a full piece means that another one follows
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
        short = shortened(name)
        count = 1
        while short in taken:
            count += 1
            short = f"{short[: LONGEST_ID - len(str(count))]}{count}"
        taken.add(short)
        found[name] = short
    return found


def shortened(name: str) -> str:
    """Return a name of at most 16 characters."""
    words = name.split("_")
    while len("_".join(words)) > LONGEST_ID:
        place = max(range(len(words)), key=lambda each: len(words[each]))
        word = words[place]
        vowel = max(map(word.lower().rfind, VOWELS))
        cut = vowel if vowel > 0 else len(word) - 1
        words[place] = word[:cut] + word[cut + 1 :]
    return "_".join(words)


def _milliseconds(t_ns: int) -> int:
    return t_ns // 1_000_000 & UNKNOWN_32
