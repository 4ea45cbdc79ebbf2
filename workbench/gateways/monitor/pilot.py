"""A pilot at a keyboard: takes control, flies by keys, and gives it back."""

import contextlib
import time
from collections.abc import Callable

from workbench.common.errors import WorkbenchError
from workbench.gateways.monitor.picture import number
from workbench.gateways.monitor.sticks import Sticks
from workbench.link import Client
from workbench.link.control import DirectControl


class Pilot:
    """Does what keys say; what is refused becomes a sentence.

    It flies as long as `tick` is called: where the terminal takes no more output, or the program
    stands still, the drone hears nothing, and holds its place after 0.5 s.

    Args:
        client: of the flight's server, open.
        clock: time now [s].

    Attributes:
        said: what there is to tell, "" for nothing.
    """

    def __init__(self, client: Client, clock: Callable[[], float] = time.monotonic) -> None:
        limits = client.hello.limits
        self.said = ""
        self._client = client
        self._clock = clock
        self._sticks = Sticks(limits.level_speed, limits.climb_rate, limits.yaw_rate)
        self._control: DirectControl | None = None

    @property
    def flying(self) -> bool:
        """Whether control is ours."""
        return self._control is not None

    @property
    def speed(self) -> float:
        """Speed at which keys fly [m/s]."""
        return self._sticks.speed

    def key(self, key: str) -> bool:
        """Act on a key; return whether it means something."""
        if key == "c":
            self._try(self.release if self._control else self.take)
        elif key == "+":
            self._sticks.faster()
        elif key == "-":
            self._sticks.slower()
        elif key in OPERATIONS:
            self._sticks.let_go()
            self.tick()  # an answer may take its time: what was flown must not go on until then
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
        """Ask for control.

        Raises:
            WorkbenchError: if it is refused.
        """
        self._sticks.let_go()
        self._control = self._client.direct_control().__enter__()
        self.said = "you fly"

    def release(self) -> None:
        """Give control back, if it is ours."""
        control, self._control = self._control, None
        if control is not None:
            control.__exit__()
            self.said = "control was released: the drone holds its place"

    def tick(self) -> None:
        """Fly as the sticks stand now; it is to be called 20 times a second."""
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


OPERATIONS: dict[str, Callable[[DirectControl], float]] = {
    "t": DirectControl.take_off,
    "l": DirectControl.land,
    "x": DirectControl.stop,
}
SAID = {"t": "taking off", "l": "landing", "x": "the rotors were stopped"}
