"""A pilot at a keyboard: takes control, flies by keys, and releases control."""

import contextlib
import math
import time
from collections.abc import Callable

from workbench.common.errors import WorkbenchError
from workbench.gateways.monitor.picture import number
from workbench.link import Client
from workbench.link.control import Control

KEY_TIME = 0.3
"""Time for which a key counts [s], as terminals do not report its release; see `DECAY_TIME`."""
DECAY_TIME = 0.3
"""Time in which its effect then fades out [s]."""
SPEEDS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Speeds that + and - choose from [m/s]."""
TURN = 0.4
"""Yaw rate at a speed of 1 m/s and more [rad/s]."""
KEYS = {
    "w": ("ahead", 1.0),
    "s": ("ahead", -1.0),
    "a": ("aside", 1.0),
    "d": ("aside", -1.0),
    "up": ("climb", 1.0),
    "down": ("climb", -1.0),
    "left": ("turn", 1.0),
    "right": ("turn", -1.0),
}
"""The axis of each key and its sign: along the heading, to the left, up, counter-clockwise."""
Asked = tuple[float, float, float, float]


class Sticks:
    """Converts pressed keys to a velocity.

    Args:
        level_speed: largest level speed [m/s].
        climb_rate: largest speed up or down [m/s].
        yaw_rate: largest yaw rate [rad/s].

    Attributes:
        speed: of flight by keys [m/s].
    """

    def __init__(self, level_speed: float, climb_rate: float, yaw_rate: float) -> None:
        self.speed = 1.0
        self._limits = (level_speed, climb_rate, yaw_rate)
        self._pushes: dict[str, tuple[float, float]] = {}  # direction and time [s]

    def press(self, key: str, now: float) -> bool:
        """Press a key; return whether it moves the drone."""
        if key not in KEYS:
            return False
        stick, direction = KEYS[key]
        self._pushes[stick] = direction, now
        return True

    def let_go(self) -> None:
        """Release all keys at once."""
        self._pushes.clear()

    def faster(self) -> None:
        """Choose the next larger speed."""
        self.speed = min((each for each in SPEEDS if each > self.speed), default=self.speed)

    def slower(self) -> None:
        """Choose the next smaller speed."""
        self.speed = max((each for each in SPEEDS if each < self.speed), default=self.speed)

    def asked(self, now: float, yaw: float) -> Asked:
        """Return the velocity in W [m/s] and the yaw rate [rad/s] that the keys request.

        Args:
            now: time [s].
            yaw: heading of the drone [rad].
        """
        level, climb, turn = self._limits
        ahead, aside = self._push("ahead", now), self._push("aside", now)
        length = max(1.0, math.hypot(ahead, aside))  # two keys are not faster than one
        speed = min(self.speed, level) / length
        x = speed * (ahead * math.cos(yaw) - aside * math.sin(yaw))
        y = speed * (ahead * math.sin(yaw) + aside * math.cos(yaw))
        z = min(self.speed, climb) * self._push("climb", now)
        return x, y, z, min(TURN * min(self.speed, 1.0), turn) * self._push("turn", now)

    def _push(self, stick: str, now: float) -> float:
        direction, at = self._pushes.get(stick, (0.0, now))
        over = (now - at - KEY_TIME) / DECAY_TIME
        return direction * min(max(1.0 - over, 0.0), 1.0)


class Pilot:
    """Flies by keys; rejections become a message.

    The drone flies while `tick` is called. If the terminal blocks or the program hangs, the drone
    gets no commands, and holds its position after 0.5 s.

    Args:
        client: of the server, open.
        clock: time now [s].

    Attributes:
        said: message to the user, "" if there is none.
    """

    def __init__(self, client: Client, clock: Callable[[], float] = time.monotonic) -> None:
        limits = client.hello.limits
        self.said = ""
        self._client = client
        self._clock = clock
        self._sticks = Sticks(limits.level_speed, limits.climb_rate, limits.yaw_rate)
        self._control: Control | None = None

    @property
    def flying(self) -> bool:
        """Whether this client has control."""
        return self._control is not None

    @property
    def speed(self) -> float:
        """Speed of flight by keys [m/s]."""
        return self._sticks.speed

    def key(self, key: str) -> bool:
        """Handle a key; return whether it has a meaning."""
        if key == "c":
            self._try(self.release if self._control else self.take)
        elif key == "+":
            self._sticks.faster()
        elif key == "-":
            self._sticks.slower()
        elif key in OPERATIONS:
            self._sticks.let_go()
            self.tick()  # the answer may take a while: stop the present motion first
            self._try(lambda: self._operate(key))
        elif key == "space":
            self._sticks.let_go()
            if self._control is not None and self._lands():
                self._try(self._abort)
        elif not self._sticks.press(key, self._clock()):
            return False
        elif self._control is None:
            self.said = "press C to take control first"
        self.tick()
        return True

    def take(self) -> None:
        """Request control.

        Raises:
            WorkbenchError: if it is rejected.
        """
        self._sticks.let_go()
        self._control = self._client.direct_control().__enter__()
        self.said = "you fly"

    def release(self) -> None:
        """Release control, if this client has it."""
        control, self._control = self._control, None
        if control is not None:
            control.__exit__()
            self.said = "control was released: the drone holds its position"

    def tick(self) -> None:
        """Send the present velocity; call this 20 times a second."""
        if self._control is not None:
            self._try(self._steer)

    def _steer(self) -> None:
        assert self._control is not None
        newest = self._client.latest("position_data")
        yaw = number(newest, "yaw") if newest else 0.0
        self._control.velocity(*self._sticks.asked(self._clock(), yaw))

    def _lands(self) -> bool:
        newest = self._client.latest("drone_state")
        return newest is not None and newest["condition"] == "landing"

    def _abort(self) -> None:
        assert self._control is not None
        self._control.hold()
        self.said = "the landing was ended"

    def _operate(self, key: str) -> None:
        if self._control is None:
            raise WorkbenchError("press C to take control first")
        OPERATIONS[key](self._control)
        self.said = SAID[key]

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except WorkbenchError as error:
            self.said = str(error)
        if self._control is not None and self._control.lost:
            self.said = f"control was lost: {self._control.lost}; press C to ask again"
            with contextlib.suppress(WorkbenchError):  # the connection may be gone too
                self._control.__exit__()
            self._control = None


OPERATIONS: dict[str, Callable[[Control], float]] = {
    "t": Control.take_off,
    "l": Control.land,
    "x": Control.stop,
}
SAID = {"t": "taking off", "l": "landing", "x": "the rotors were stopped"}
