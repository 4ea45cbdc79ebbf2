"""Flight modes as ground stations list and set them, and those that show an operation.

Source: mavlink.io/en/services/standard_modes.html.
"""

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20 import development

from workbench.extras.gateways.mavlink_messages import (
    ARMED_MODE,
    ASCENDING_MODE,
    CRUISING_MODE,
    DESCENDING_MODE,
    HOLD_MODE,
    LANDING_MODE,
    OFF_MODE,
    TAKING_OFF_MODE,
    MavlinkMessage,
)

MISSION_MODE = 8
"""Custom mode of MAVLink while the gateway flies a mission; it is none of the drone's."""
NOT_SELECTABLE = development.MAV_MODE_PROPERTY_NOT_USER_SELECTABLE


@dataclass(frozen=True)
class StationMode:
    """A flight mode as a station lists it.

    Attributes:
        custom: its number, that of the topic drone_state.
        name: for people.
        standard: MAVLink's standard mode.
        operation: that a station requests by setting it; "" if it cannot.
    """

    custom: int
    name: str
    standard: int = mavlink.MAV_STANDARD_MODE_NON_STANDARD
    operation: str = ""


STATION_MODES = (
    StationMode(OFF_MODE, "Off"),
    StationMode(ARMED_MODE, "Armed"),
    StationMode(TAKING_OFF_MODE, "Takeoff", mavlink.MAV_STANDARD_MODE_TAKEOFF, "take_off"),
    StationMode(HOLD_MODE, "Hold", mavlink.MAV_STANDARD_MODE_POSITION_HOLD, "hold"),
    StationMode(ASCENDING_MODE, "Ascending"),
    StationMode(DESCENDING_MODE, "Descending"),
    StationMode(CRUISING_MODE, "Cruising"),
    StationMode(LANDING_MODE, "Land", mavlink.MAV_STANDARD_MODE_LAND, "land"),
    StationMode(MISSION_MODE, "Mission", mavlink.MAV_STANDARD_MODE_MISSION, "mission"),
)
PX4_AUTO_MODE = 4
PX4_AUTO_OPERATIONS = {2: "take_off", 3: "hold", 4: "mission", 6: "land"}
"""Operations by PX4's sub-modes of AUTO (PX4's px4_custom_mode.h)."""
STATION_FLYING_MODES = (HOLD_MODE, ASCENDING_MODE, DESCENDING_MODE, CRUISING_MODE)
EFFECT_MODES = {
    "arm": (ARMED_MODE, TAKING_OFF_MODE, *STATION_FLYING_MODES),
    "take_off": (TAKING_OFF_MODE, *STATION_FLYING_MODES),
    "hold": STATION_FLYING_MODES,
    "land": (LANDING_MODE, OFF_MODE),
    "stop": (OFF_MODE,),
}
"""Modes that show the effect of each flight operation."""


def mode_messages(index: int) -> list[MavlinkMessage]:
    """Return AVAILABLE_MODES of a mode, counted from 1, of all for 0, or of none."""
    numbered = list(enumerate(STATION_MODES, start=1))
    return [
        development.MAVLink_available_modes_message(
            len(STATION_MODES),
            number,
            mode.standard,
            mode.custom,
            0 if mode.operation else NOT_SELECTABLE,
            mode.name.encode(),
        )
        for number, mode in numbered
        if index in (0, number)
    ]


def current_mode_message(custom: int) -> MavlinkMessage:
    """Return CURRENT_MODE of a custom mode."""
    standard = next((mode.standard for mode in STATION_MODES if mode.custom == custom), 0)
    return development.MAVLink_current_mode_message(standard, custom, custom)


def mode_operation(number: int, sub_mode: float = math.nan) -> str:
    """Return the operation that setting a custom mode requests; "" if a station cannot set it.

    Args:
        number: of the mode.
        sub_mode: of PX4's mode AUTO, which MAVSDK sets of any autopilot that it does not know;
            NaN or 0 for one of `STATION_MODES`.
    """
    if number == PX4_AUTO_MODE and sub_mode in PX4_AUTO_OPERATIONS:
        return PX4_AUTO_OPERATIONS[int(sub_mode)]
    return next((mode.operation for mode in STATION_MODES if mode.custom == number), "")


def standard_operation(number: int) -> str:
    """Return the operation that setting a standard mode requests; "" if a station cannot."""
    return next((mode.operation for mode in STATION_MODES if mode.standard == number), "")
