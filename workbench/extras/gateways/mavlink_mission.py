"""Missions of ground stations: their items as steps of a flight, and their transfer.

Source: mavlink.io/en/services/mission.html.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pymap3d.enu import geodetic2enu
from pymavlink.dialects.v20 import common as mavlink

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.mavlink_messages import MavlinkMessage
from workbench.link import AsyncClient

MAX_MISSION_ITEMS = 500
RELATIVE_FRAMES = (
    mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
)
GLOBAL_FRAMES = (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT, *RELATIVE_FRAMES)
PLACED_COMMANDS = (
    mavlink.MAV_CMD_NAV_WAYPOINT,
    mavlink.MAV_CMD_NAV_LOITER_TIME,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_LAND,
)
COMMANDS = (
    *PLACED_COMMANDS,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_NAV_DELAY,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
)
"""Commands of mission items that the gateway flies."""
CHANGING_MESSAGES = (
    "MISSION_COUNT",
    "MISSION_ITEM_INT",
    "MISSION_ITEM",
    "MISSION_CLEAR_ALL",
    "MISSION_SET_CURRENT",
)
"""Messages that change the mission of the drone."""


def home_of(client: AsyncClient) -> tuple[float, ...]:
    """Return latitude, longitude [rad] and altitude [m] of W's origin; empty without GPS."""
    for topic in client.hello.topics:
        home: Any = topic.about.get("home")
        if home:
            return tuple(map(float, home))
    return ()


class MissionError(WorkbenchError):
    """An item cannot be flown.

    Attributes:
        result: MAVLink's MAV_MISSION_RESULT.
    """

    def __init__(self, result: int, sentence: str) -> None:
        super().__init__(sentence)
        self.result = result


class MissionPlace(NamedTuple):
    """A place in W [m]; None for a coordinate that the item leaves as it is."""

    x: float | None
    y: float | None
    z: float


@dataclass(frozen=True)
class MissionStep:
    """A step of a mission.

    Attributes:
        command: MAV_CMD.
        place: where it leads, None without one.
        wait: time to hold there [s].
        radius: distance at which the place counts as reached [m]; 0 for the gateway's own.
        speed: from then on [m/s], 0 for no change.
    """

    command: int
    place: MissionPlace | None = None
    wait: float = 0.0
    radius: float = 0.0
    speed: float = 0.0


@dataclass
class Mission:
    """The mission of a drone, and its transfer from a station.

    Attributes:
        home: latitude, longitude [rad] and altitude [m] of W's origin; empty if unknown.
        items: MISSION_ITEM_INT of the station.
        steps: the same to be flown.
        current: place of the step that is flown, or will be next.
        complete: whether it was flown to its end.
    """

    home: Sequence[float] = ()
    items: list[Any] = field(default_factory=list)
    steps: list[MissionStep] = field(default_factory=list)
    current: int = 0
    complete: bool = False
    _arriving: list[tuple[Any, MissionStep]] = field(default_factory=list)
    _expected: int = 0
    _sender: tuple[int, int] = (0, 0)

    @property
    def next_start(self) -> int:
        """Place of the step with which it begins, or goes on."""
        return 0 if self.complete else self.current

    def answer(self, message: Any) -> list[MavlinkMessage]:
        """Return the answers to a message of the mission protocol.

        Raises:
            MissionError: if an item cannot be flown; the transfer has ended.
        """
        target = (message.get_srcSystem(), message.get_srcComponent())
        match message.get_type():
            case "MISSION_REQUEST_LIST":
                own = message.mission_type == mavlink.MAV_MISSION_TYPE_MISSION
                count = len(self.items) if own else 0
                return [mavlink.MAVLink_mission_count_message(*target, count, message.mission_type)]
            case "MISSION_REQUEST_INT" | "MISSION_REQUEST" if message.seq < len(self.items):
                item = self.items[message.seq]
                item.target_system, item.target_component = target
                return [item]
            case "MISSION_COUNT":
                return self._begin(message)
            case "MISSION_ITEM_INT" | "MISSION_ITEM":
                return self._take(message)
            case "MISSION_CLEAR_ALL":
                self.clear()
                return [self.acknowledgement(mavlink.MAV_MISSION_ACCEPTED, message)]
        return []

    def status(self, flies: bool) -> MavlinkMessage:
        """Return MISSION_CURRENT, of a mission that is flown or not."""
        state = mavlink.MISSION_STATE_NO_MISSION
        if self.complete:
            state = mavlink.MISSION_STATE_COMPLETE
        elif self.steps:
            state = mavlink.MISSION_STATE_ACTIVE if flies else mavlink.MISSION_STATE_NOT_STARTED
        return mavlink.MAVLink_mission_current_message(self.current, len(self.steps), state)

    def acknowledgement(self, result: int, message: Any) -> MavlinkMessage:
        """Return a MISSION_ACK for the sender of a message."""
        return mavlink.MAVLink_mission_ack_message(
            message.get_srcSystem(), message.get_srcComponent(), result, message.mission_type
        )

    def request_next(self) -> list[MavlinkMessage]:
        """Request the next item of a transfer, also again; nothing without a transfer."""
        if not self._expected:
            return []
        return [mavlink.MAVLink_mission_request_int_message(*self._sender, len(self._arriving), 0)]

    def _begin(self, message: Any) -> list[MavlinkMessage]:
        """Begin the transfer that a MISSION_COUNT announces."""
        if message.mission_type != mavlink.MAV_MISSION_TYPE_MISSION:  # fences and rally points
            empty = not message.count
            result = mavlink.MAV_MISSION_ACCEPTED if empty else mavlink.MAV_MISSION_UNSUPPORTED
            return [self.acknowledgement(result, message)]
        if message.count > MAX_MISSION_ITEMS:
            return [self.acknowledgement(mavlink.MAV_MISSION_NO_SPACE, message)]
        self._sender = (message.get_srcSystem(), message.get_srcComponent())
        self._arriving, self._expected = [], message.count
        return self.request_next() if message.count else self._finish(message)

    def _take(self, message: Any) -> list[MavlinkMessage]:
        """Take an item, as MISSION_ITEM_INT or MISSION_ITEM."""
        if not self._expected or message.seq != len(self._arriving):
            return []  # repeated
        item = integer_item(message)
        try:
            self._arriving.append((item, step_of(item, self.home)))
        except MissionError:
            self._expected = 0
            raise
        if len(self._arriving) < self._expected:
            return self.request_next()
        return self._finish(message)

    def clear(self) -> None:
        """Forget the mission."""
        self.items, self.steps, self.current, self._expected = [], [], 0, 0
        self.complete = False

    def _finish(self, message: Any) -> list[MavlinkMessage]:
        arrived = self._arriving
        self.clear()
        self.items, self.steps = [item for item, _ in arrived], [step for _, step in arrived]
        return [self.acknowledgement(mavlink.MAV_MISSION_ACCEPTED, message)]


def integer_item(message: Any) -> Any:
    """Return an item as MISSION_ITEM_INT, from that or from a MISSION_ITEM of an older station."""
    if message.get_type() == "MISSION_ITEM_INT":
        return message
    scale = 1e7 if message.frame in GLOBAL_FRAMES else 1e4
    values = {name: getattr(message, name) for name in message.fieldnames}
    place = {"x": round(scale * message.x), "y": round(scale * message.y)}
    return mavlink.MAVLink_mission_item_int_message(**values | place)


def step_of(item: Any, home: Sequence[float]) -> MissionStep:
    """Return the step of a MISSION_ITEM_INT.

    Args:
        item: of the station.
        home: latitude, longitude [rad] and altitude [m] of W's origin; empty if unknown.

    Raises:
        MissionError: if it cannot be flown.
    """
    command = int(item.command)
    if command not in COMMANDS:
        raise MissionError(
            mavlink.MAV_MISSION_UNSUPPORTED,
            f"item {item.seq}: command {command} is not flown: use way-points, take-off, landing, "
            "loiter time, delay, return and change of speed",
        )
    numbers = [float(each) for each in (item.param1, item.param2, item.z)]
    if command in PLACED_COMMANDS and not math.isfinite(numbers[2]):
        raise MissionError(
            mavlink.MAV_MISSION_INVALID_PARAM7, f"item {item.seq}: its height is not a number"
        )
    first, second = (number if math.isfinite(number) else 0.0 for number in numbers[:2])
    place = _place_of(item, home) if command in PLACED_COMMANDS else None
    waits = command in (
        mavlink.MAV_CMD_NAV_WAYPOINT,
        mavlink.MAV_CMD_NAV_LOITER_TIME,
        mavlink.MAV_CMD_NAV_DELAY,
    )
    return MissionStep(
        command,
        place,
        wait=max(0.0, first) if waits else 0.0,
        radius=max(0.0, second) if command == mavlink.MAV_CMD_NAV_WAYPOINT else 0.0,
        speed=max(0.0, second) if command == mavlink.MAV_CMD_DO_CHANGE_SPEED else 0.0,
    )


def _place_of(item: Any, home: Sequence[float]) -> MissionPlace:
    """Return the place of an item in W.

    Raises:
        MissionError: if its frame is not supported, or the place of W on the earth is unknown.
    """
    if item.frame == mavlink.MAV_FRAME_LOCAL_NED:
        return MissionPlace(1e-4 * item.y, 1e-4 * item.x, -item.z)
    if item.frame == mavlink.MAV_FRAME_LOCAL_ENU:
        return MissionPlace(1e-4 * item.x, 1e-4 * item.y, item.z)
    if item.frame not in GLOBAL_FRAMES:
        raise MissionError(
            mavlink.MAV_MISSION_UNSUPPORTED_FRAME,
            f"item {item.seq}: frame {item.frame} is not flown: use global or local ones",
        )
    relative = item.frame in RELATIVE_FRAMES
    altitude = home[2] if len(home) == 3 else 0.0
    height = item.z if relative else item.z - altitude
    if not item.x and not item.y:  # where it is
        return MissionPlace(None, None, height)
    if len(home) != 3:
        raise MissionError(
            mavlink.MAV_MISSION_UNSUPPORTED_FRAME,
            f"item {item.seq}: the drone has no GPS: give local places",
        )
    latitude, longitude = math.radians(1e-7 * item.x), math.radians(1e-7 * item.y)
    x, y, _ = geodetic2enu(latitude, longitude, altitude, home[0], home[1], altitude, deg=False)
    return MissionPlace(float(x), float(y), height)
