"""A client's time at the controls, each command said once: silence is to reach the drone."""

import contextlib
import math
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.link.codes import NackCode
from workbench.link.drone_topics import AXES
from workbench.link.line import Line
from workbench.link.operations import (
    TAKE_OFF_HEIGHT,
    FlightOperation,
    Ping,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.link.server_messages import (
    ControlState,
    FlightDone,
    Granted,
    Hand,
    Nack,
    ParameterValues,
    Released,
    ServerMessage,
    Stage,
)

if TYPE_CHECKING:
    from workbench.link.async_client import AsyncClient

RELEASE_LIMIT = 1.0
FIELDS = ("lease", "axes", "v_x", "v_y", "v_z", "yaw_rate")

Asked = tuple[float, float, float, float]
NEUTRAL: Asked = (0.0, 0.0, 0.0, 0.0)


class AsyncDirectControl:
    """The controls, as an asynchronous context manager; see `AsyncClient.direct_control`.

    Attributes:
        lost: why control is gone, "" while it is not.
        scaled: why the last velocity was flown smaller than asked, "" if it was not.
    """

    def __init__(self, client: "AsyncClient") -> None:
        self.lost = ""
        self.scaled = ""
        self._client = client
        self._line: Line | None = None
        self._lease = 0
        self._asked = NEUTRAL
        self._asked_ns = 0
        self._refused = ""
        self._before = 0
        self._told_until = 0

    async def __aenter__(self) -> "AsyncDirectControl":
        topic = self._client.line.conversation.command_topic
        if topic is None or tuple(field.name for field in topic.fields) != FIELDS:
            raise WorkbenchError("this server takes no commands that this client knows")
        await self._client.ping()  # tells the time of the newest state, which a command carries
        granted = await self._client.request(
            lambda id: RequestControl(id, self._client.name), Granted
        )
        self._line = self._client.line
        self._lease = granted.lease
        self._before = self._line.conversation.seq
        self._client.attach(self)
        self._send()  # the first command of a holder must be neutral
        return self

    async def __aexit__(self, *_: object) -> None:
        self._client.attach(None)
        try:
            if not self.lost:
                # Whoever goes needs no answer: without one the lease runs out by itself.
                with contextlib.suppress(WorkbenchError):
                    await self._client.request(
                        lambda id: ReleaseControl(id, self._lease), Released, RELEASE_LIMIT
                    )
        finally:
            self._lease, self.lost = 0, self.lost or "it was released"

    def velocity(self, x: float, y: float, z: float, yaw_rate: float = 0.0) -> None:
        """Fly at a velocity in W [m/s] and turn [rad/s].

        It is sent once. Say it at least five times a second: after 0.5 s of silence, simulated,
        the drone holds its place and control is lost.

        Raises:
            WorkbenchError: if control was lost, a number is not finite, or the last velocity was
                refused.
        """
        self.steer(self.checked(x, y, z, yaw_rate))

    async def take_off(self, height: float = TAKE_OFF_HEIGHT) -> float:
        """Take off to a height above the ground [m]; return when that was begun, simulated [s].

        Raises:
            WorkbenchError: if it is refused; so in the next four.
        """
        return await self._fly("take_off", height)

    async def land(self) -> float:
        """Land where the drone is; return when that was begun, simulated [s]."""
        return await self._fly("land")

    async def arm(self) -> float:
        """Let the rotors idle; return when that was begun, simulated [s]."""
        return await self._fly("arm")

    async def stop(self) -> float:
        """Stop the rotors, wherever the drone is; return when that was, simulated [s]."""
        return await self._fly("stop")

    async def hold(self) -> float:
        """Brake and hold the place, also in a take-off or a landing; return when that was begun."""
        return await self._fly("hold")

    async def set(self, **values: float) -> dict[str, float]:
        """Set live parameters by name, all or none, and return them as they now are.

        Raises:
            WorkbenchError: if one is unknown or outside its limits.
        """
        self.check()
        said = await self._client.request(
            lambda id: SetParameters(id, values, self._lease), ParameterValues
        )
        return dict(said.values)

    def check(self) -> None:
        """See whether control is still ours.

        Raises:
            WorkbenchError: if it is not.
        """
        if self.lost:
            raise WorkbenchError(f"control was lost: {self.lost}; ask again for it")
        if not self._lease:
            raise WorkbenchError("nobody asked for control: write `with client.control() as c:`")

    def checked(self, x: float, y: float, z: float, yaw_rate: float) -> Asked:
        """Return a velocity that may be sent; see `velocity`."""
        self.check()
        if self._refused:
            refused, self._refused = self._refused, ""
            self._told_until = self._line.conversation.seq if self._line else 0
            raise WorkbenchError(f"the velocity was refused: {refused}; the drone holds its place")
        asked = (float(x), float(y), float(z), float(yaw_rate))
        if not all(math.isfinite(number) and abs(number) < 1e30 for number in asked):
            raise WorkbenchError(f"the velocity {asked} is no velocity: all must be finite numbers")
        return asked

    def steer(self, asked: Asked) -> None:
        """Send a velocity."""
        self._asked = asked
        self.scaled = ""
        self._send()

    def hear(self, said: ServerMessage) -> None:
        """Take note of what concerns control."""
        match said:
            case ControlState(hand, peer, _, stage, _, reason):
                if (hand, peer, stage) != (Hand.CLIENT, self._client.peer, Stage.LIVE):
                    self.lose(reason)
            case Nack(_, _, _, int(seq)) if seq <= self._before:
                pass  # of an older lease
            case Nack(NackCode.SCALED, sentence, _, int()):
                self.scaled = sentence
            case Nack(NackCode.NOT_HOLDER, sentence, _, int()):
                self.lose(sentence)
            case Nack(NackCode.NEUTRAL_FIRST, _, _, int()):  # the first one came to nothing
                self._send(NEUTRAL)
            case Nack(NackCode.STALE, _, _, int()):
                pass  # the next one acts on a newer state
            case Nack(_, sentence, _, int(seq)) if seq > self._told_until:
                self._refused, self._asked = sentence, NEUTRAL

    def lose(self, reason: str) -> None:
        """Let control be gone."""
        self.lost = self.lost or reason

    def keep_up(self) -> None:
        """Notice that a newer state came."""

    def _send(self, asked: Asked | None = None) -> None:
        line = self._line
        if line is None or self.lost or line.end is not None:
            return
        if not line.fresh:  # the next one is to carry the present time
            line.ask(Ping())
        topic = line.conversation.command_topic
        assert topic is not None  # looked at before control was asked for
        self._asked_ns = line.conversation.newest_ns or 0
        line.command(topic.pack((self._lease, AXES, *(asked or self._asked))))

    async def _fly(self, what: str, height: float = TAKE_OFF_HEIGHT) -> float:
        self.check()
        said = await self._client.request(
            lambda id: FlightOperation(id, what, height, self._lease), FlightDone
        )
        return said.applied_ns / 1e9
