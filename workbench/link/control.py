"""The controls of a program: what it said last is repeated for it, for a while."""

import asyncio
import math
import time
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.link.direct_control import NEUTRAL, Asked, AsyncDirectControl

if TYPE_CHECKING:
    from workbench.link.async_client import AsyncClient

PERIOD = 0.05
"""The last command is repeated so often [s]."""
PERIOD_NS = 100_000_000
"""And at least so often in simulated time [ns], for a flight that is faster than the clock."""
HOLD = 2.0
"""A velocity is repeated for so long, unless more is asked for [s]."""


class AsyncControl(AsyncDirectControl):
    """The controls, as an asynchronous context manager; see `AsyncClient.control`.

    What keeps a program at the controls must not fly the drone by itself: a program that hangs
    still repeats. So a velocity lapses, and the drone then holds its place.
    """

    def __init__(self, client: "AsyncClient") -> None:
        super().__init__(client)
        self._lapses_at = math.inf
        self._repeating: asyncio.Task[None] | None = None

    async def __aenter__(self) -> "AsyncControl":
        await super().__aenter__()
        self._repeating = asyncio.create_task(self._repeat(), name="control")
        self._repeating.add_done_callback(self._notice)
        return self

    async def __aexit__(self, *error: object) -> None:
        self._stop_repeating()
        await super().__aexit__(*error)

    def velocity(
        self, x: float, y: float, z: float, yaw_rate: float = 0.0, *, hold: float = HOLD
    ) -> None:
        """Fly at a velocity in W [m/s] and turn [rad/s] for a while, then hold the place.

        It is repeated 20 times a second for `hold` seconds, whatever the program does meanwhile,
        **even where it hangs**. Say it again within that time to fly on.

        Args:
            x: velocity along W's x [m/s].
            y: along y [m/s].
            z: upwards [m/s].
            yaw_rate: counter-clockwise as seen from above [rad/s].
            hold: how long it counts [s, of the clock]; `math.inf` for as long as the block runs.

        Raises:
            WorkbenchError: if control was lost, a number is not finite, or the last velocity was
                refused.
        """
        self.steer_until(self.checked(x, y, z, yaw_rate), lapse_time(hold))

    def steer_until(self, asked: Asked, lapses_at: float) -> None:
        """Send a velocity, and repeat it until a time of the monotonic clock [s]."""
        self._lapses_at = lapses_at
        self.steer(asked)

    def lose(self, reason: str) -> None:
        """Let control be gone."""
        super().lose(reason)
        self._stop_repeating()

    def keep_up(self) -> None:
        """Repeat the command where simulated time runs faster than the clock."""
        line = self._line
        if line and (line.conversation.newest_ns or 0) - self._asked_ns >= PERIOD_NS:
            self._say_again()

    async def _repeat(self) -> None:
        """Say again what was said last, as a silence means that nobody is there."""
        while True:
            await asyncio.sleep(PERIOD)
            self._say_again()

    def _say_again(self) -> None:
        if time.monotonic() >= self._lapses_at:
            self._asked = NEUTRAL
        self._send()

    def _stop_repeating(self) -> None:
        if self._repeating is not None:
            self._repeating.cancel()

    def _notice(self, repeating: "asyncio.Task[None]") -> None:
        """Let control be lost where it cannot be kept: the lease then runs out by itself."""
        if not repeating.cancelled() and (error := repeating.exception()) is not None:
            self.lose(f"the client failed: {type(error).__name__}: {error}")


def lapse_time(hold: float) -> float:
    """Return when a velocity of now lapses, by the monotonic clock [s].

    Raises:
        WorkbenchError: if it is to count for no time.
    """
    if not hold > 0.0:
        raise WorkbenchError(
            f"a velocity cannot be held for {hold} s: give a time above 0, or math.inf"
        )
    return time.monotonic() + hold
