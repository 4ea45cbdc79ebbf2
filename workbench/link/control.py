"""Control of the drone: the lease, commands and requests.

`AsyncControl` repeats the last command for a while, or sends each one once. `Control` calls it from
programs without asyncio.
"""

import asyncio
import contextlib
import functools
import math
import time
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.link.background_loop import BackgroundLoop
from workbench.link.client_core import ClientCore
from workbench.link.codes import NackCode
from workbench.link.connection import Connection
from workbench.link.drone_topics import ALL_COMMAND_AXES
from workbench.link.message_json import TAKE_OFF_HEIGHT_M, ServerMessage
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    FlightDone,
    FlightOperation,
    LinkLossStage,
    Nack,
    ParameterValues,
    Ping,
    ReleaseControl,
    RequestControl,
    SetParameters,
)

RELEASE_TIMEOUT_S = 1.0
COMMAND_FIELDS = ("lease", "axes", "v_x", "v_y", "v_z", "yaw_rate")
COMMAND_PERIOD_S = 0.05
"""Period at which the last command is repeated [s]."""
MAX_COMMAND_PERIOD_NS = 100_000_000
"""Longest such period in simulated time [ns], for a flight faster than the clock."""
DEFAULT_VELOCITY_HOLD_S = 2.0
"""Default time for which a velocity is repeated [s]."""

VelocityAndYawRate = tuple[float, float, float, float]
ZERO_VELOCITY: VelocityAndYawRate = (0.0, 0.0, 0.0, 0.0)

P = ParamSpec("P")
T = TypeVar("T")


class AsyncControl:
    """The controls, as an asynchronous context manager.

    A program that hangs still repeats its commands, and must not fly the drone forever. So a
    repeated velocity expires, and the drone then holds its position.

    Args:
        client: connected to the server.
        repeats: whether to repeat the last velocity; see `AsyncClient.control` and
            `AsyncClient.direct_control`.

    Attributes:
        lost: why control was lost, else "".
        scaled: why the last velocity was scaled down, else "".
    """

    def __init__(self, client: ClientCore, *, repeats: bool) -> None:
        self.lost = ""
        self.scaled = ""
        self._client = client
        self._connection: Connection | None = None
        self._lease = 0
        self._commanded = ZERO_VELOCITY
        self._sent_ns = 0
        self._refused = ""
        self._before = 0
        self._told_until = 0
        self._repeats = repeats
        self._lapses_at = math.inf
        self._repeating: asyncio.Task[None] | None = None

    @property
    def repeats(self) -> bool:
        """Whether commands are repeated at present."""
        return self._repeating is not None

    async def __aenter__(self) -> "AsyncControl":
        topic = self._client.connection.protocol.command_topic
        if topic is None or tuple(field.name for field in topic.fields) != COMMAND_FIELDS:
            raise WorkbenchError("this server takes no commands that this client knows")
        await self._client.request_time()  # needed in commands
        granted = await self._client.request(
            lambda id: RequestControl(id, self._client.name), RequestControl
        )
        self._connection = self._client.connection
        self._lease = granted.lease
        self._before = self._connection.protocol.seq
        self._client.follow(self)
        self._send()  # the first command of a holder must be zero
        if self._repeats:
            self._repeating = asyncio.create_task(self._repeat(), name="control")
            self._repeating.add_done_callback(self._notice)
        return self

    async def __aexit__(self, *_: object) -> None:
        self.stop_repeating()
        self._client.follow(None)
        try:
            if not self.lost:
                # No answer is needed: without the release the lease expires.
                with contextlib.suppress(WorkbenchError):
                    await self._client.request(
                        lambda id: ReleaseControl(id, self._lease),
                        ReleaseControl,
                        RELEASE_TIMEOUT_S,
                    )
        finally:
            self._lease, self.lost = 0, self.lost or "it was released"

    def velocity(
        self,
        x: float,
        y: float,
        z: float,
        yaw_rate: float = 0.0,
        *,
        hold: float = DEFAULT_VELOCITY_HOLD_S,
    ) -> None:
        """Fly at a velocity in W [m/s] and turn [rad/s] for a while, then hold the position.

        It is repeated 20 times a second for `hold` seconds, **even if the program hangs**. Call
        this again within that time to fly on.

        With `direct_control` it is sent once. Call this at least five times a second: after 0.5 s
        of simulated silence the drone holds its position and control is lost.

        Args:
            x: velocity along W's x [m/s].
            y: along y [m/s].
            z: upwards [m/s].
            yaw_rate: counter-clockwise as seen from above [rad/s].
            hold: how long it is repeated [s, wall-clock]; `math.inf` until the end of the block.

        Raises:
            WorkbenchError: if control was lost, a number is not finite, or the last velocity was
                rejected.
        """
        self.steer(self.checked(x, y, z, yaw_rate), velocity_expiry(hold))

    async def request(self, what: str, height: float = TAKE_OFF_HEIGHT_M) -> float:
        """Request an operation, such as take_off (to a height [m]); return the start time [s].

        The operations are arm, take_off, land, stop, hold, and reset, which starts the flight again
        and ends the lease.

        Raises:
            WorkbenchError: if it is refused; the same holds for the next six methods.
        """
        self.check()
        answer = await self._client.request(
            lambda id: FlightOperation(id, what, height, self._lease), FlightDone
        )
        return answer.applied_ns / 1e9

    async def take_off(self, height: float = TAKE_OFF_HEIGHT_M) -> float:
        """Take off to a height above the ground [m]; return the simulated start time [s]."""
        return await self.request("take_off", height)

    async def land(self) -> float:
        """Land at the present position; return the simulated start time [s]."""
        return await self.request("land")

    async def arm(self) -> float:
        """Let the rotors idle; return the simulated start time [s]."""
        return await self.request("arm")

    async def stop(self) -> float:
        """Stop the rotors, even in the air; return the simulated time [s]."""
        return await self.request("stop")

    async def hold(self) -> float:
        """Brake and hold the position, also in take-off or landing; return the start time [s]."""
        return await self.request("hold")

    async def set(self, **values: float) -> dict[str, float]:
        """Set live parameters by name, all or none, and return their present values.

        Raises:
            WorkbenchError: if one is unknown or out of its limits.
        """
        self.check()
        answer = await self._client.request(
            lambda id: SetParameters(id, values, self._lease), ParameterValues
        )
        return dict(answer.values)

    def check(self) -> None:
        """Check that this client still has control.

        Raises:
            WorkbenchError: if it is not.
        """
        if self.lost:
            raise WorkbenchError(f"control was lost: {self.lost}; ask again for it")
        if not self._lease:
            raise WorkbenchError("nobody asked for control: write `with client.control() as c:`")

    def checked(self, x: float, y: float, z: float, yaw_rate: float) -> VelocityAndYawRate:
        """Return a valid velocity; see `velocity`."""
        self.check()
        if self._refused:
            refused, self._refused = self._refused, ""
            self._told_until = self._connection.protocol.seq if self._connection else 0
            raise WorkbenchError(
                f"the velocity was refused: {refused}; the drone holds its position"
            )
        velocity = (float(x), float(y), float(z), float(yaw_rate))
        if not all(math.isfinite(number) and abs(number) < 1e30 for number in velocity):
            raise WorkbenchError(
                f"the velocity {velocity} is not valid: all must be finite numbers"
            )
        return velocity

    def steer(self, velocity: VelocityAndYawRate, lapses_at: float) -> None:
        """Send a velocity; if repeated, it expires at a time of the monotonic clock [s]."""
        self._commanded, self._lapses_at = velocity, lapses_at
        self.scaled = ""
        self._send()

    def receive(self, message: ServerMessage) -> None:
        """Handle messages about control."""
        match message:
            case ControlState(hand, peer, _, stage, _, reason):
                if (hand, peer, stage) != (
                    ControlOwner.CLIENT,
                    self._client.peer,
                    LinkLossStage.LIVE,
                ):
                    self.lose(reason)
            case Nack(_, _, _, int(seq)) if seq <= self._before:
                pass  # from an older lease
            case Nack(NackCode.SCALED, sentence, _, int()):
                self.scaled = sentence
            case Nack(NackCode.NOT_HOLDER, sentence, _, int()):
                self.lose(sentence)
            case Nack(NackCode.NEUTRAL_FIRST, _, _, int()):  # the first one was rejected
                self._send(ZERO_VELOCITY)
            case Nack(NackCode.STALE, _, _, int()):
                pass  # the next one will act on a newer state
            case Nack(_, sentence, _, int(seq)) if seq > self._told_until:
                self._refused, self._commanded = sentence, ZERO_VELOCITY

    def lose(self, reason: str) -> None:
        """Note the loss of control."""
        self.lost = self.lost or reason
        self.stop_repeating()

    def keep_up(self) -> None:
        """Repeat the command if simulated time runs faster than the clock."""
        connection = self._connection
        if (
            self._repeating
            and connection
            and (connection.protocol.newest_ns or 0) - self._sent_ns >= MAX_COMMAND_PERIOD_NS
        ):
            self._repeat_once()

    def _send(self, velocity: VelocityAndYawRate | None = None) -> None:
        connection = self._connection
        if connection is None or self.lost or connection.end is not None:
            return
        if not connection.fresh:  # the next one needs the present time
            connection.send(Ping())
        topic = connection.protocol.command_topic
        assert topic is not None  # checked before control was requested
        self._sent_ns = connection.protocol.newest_ns or 0
        connection.command(
            topic.pack((self._lease, ALL_COMMAND_AXES, *(velocity or self._commanded)))
        )

    async def _repeat(self) -> None:
        """Repeat the last command, as silence means the loss of control."""
        while True:
            await asyncio.sleep(COMMAND_PERIOD_S)
            self._repeat_once()

    def _repeat_once(self) -> None:
        if time.monotonic() >= self._lapses_at:
            self._commanded = ZERO_VELOCITY
        self._send()

    def stop_repeating(self) -> None:
        """Send each command once from now on, as with `direct_control`."""
        if self._repeating is not None:
            self._repeating.cancel()
            self._repeating = None

    def _notice(self, repeating: "asyncio.Task[None]") -> None:
        """Give up control if it cannot be kept; the lease then expires."""
        if not repeating.cancelled() and (error := repeating.exception()) is not None:
            self.lose(f"the client failed: {type(error).__name__}: {error}")


def velocity_expiry(hold: float) -> float:
    """Return when a velocity sent now expires, by the monotonic clock [s].

    Raises:
        WorkbenchError: if the duration is not positive.
    """
    if not hold > 0.0:
        raise WorkbenchError(
            f"a velocity cannot be held for {hold} s: give a time above 0, or math.inf"
        )
    return time.monotonic() + hold


def _blocking(
    method: Callable[Concatenate[AsyncControl, P], Coroutine[Any, Any, T]],
) -> Callable[Concatenate["Control", P], T]:
    """Return a method that runs `method` in the client's thread and waits for its result."""

    @functools.wraps(method)
    def call(self: "Control", *args: P.args, **kwargs: P.kwargs) -> T:
        return self._loop.call(method(self._control, *args, **kwargs))

    return call


class Control:
    """The controls, as a context manager; see `Client.control` and `Client.direct_control`."""

    def __init__(self, control: AsyncControl, loop: BackgroundLoop) -> None:
        self._control = control
        self._loop = loop

    def __enter__(self) -> Self:
        self._loop.call(self._control.__aenter__())
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call(self._control.__aexit__())

    @property
    def lost(self) -> str:
        """Why control was lost, else ""."""
        return self._control.lost

    @property
    def scaled(self) -> str:
        """Why the last velocity was scaled down, else ""."""
        return self._control.scaled

    def velocity(
        self,
        x: float,
        y: float,
        z: float,
        yaw_rate: float = 0.0,
        *,
        hold: float = DEFAULT_VELOCITY_HOLD_S,
    ) -> None:
        """Fly at a velocity for a while, then hold the position; see `AsyncControl.velocity`."""
        velocity = self._control.checked(x, y, z, yaw_rate)
        self._loop.post(partial(self._control.steer, velocity, velocity_expiry(hold)))

    request = _blocking(AsyncControl.request)
    take_off = _blocking(AsyncControl.take_off)
    land = _blocking(AsyncControl.land)
    arm = _blocking(AsyncControl.arm)
    stop = _blocking(AsyncControl.stop)
    hold = _blocking(AsyncControl.hold)
    set = _blocking(AsyncControl.set)
