"""The controls for a plain program: what `control` does in the client's thread, from another."""

from functools import partial
from typing import TYPE_CHECKING, Self

from workbench.link.control import HOLD, AsyncControl, lapse_time
from workbench.link.direct_control import AsyncDirectControl
from workbench.link.operations import TAKE_OFF_HEIGHT

if TYPE_CHECKING:
    from workbench.link.client import Client


class DirectControl:
    """The controls, as a context manager; see `Client.direct_control`."""

    def __init__(self, client: "Client", control: AsyncDirectControl) -> None:
        self._client = client
        self._control = control

    def __enter__(self) -> Self:
        self._client.call(self._control.__aenter__())
        return self

    def __exit__(self, *_: object) -> None:
        self._client.call(self._control.__aexit__())

    @property
    def lost(self) -> str:
        """Why control is gone, "" while it is not."""
        return self._control.lost

    @property
    def scaled(self) -> str:
        """Why the last velocity was flown smaller than asked, "" if it was not."""
        return self._control.scaled

    def velocity(self, x: float, y: float, z: float, yaw_rate: float = 0.0) -> None:
        """Fly at a velocity in W [m/s] and turn [rad/s].

        It is sent once. Say it at least five times a second: after 0.5 s of silence, simulated,
        the drone holds its place and control is lost.

        Raises:
            WorkbenchError: if control was lost, a number is not finite, or the last velocity was
                refused.
        """
        asked = self._control.checked(x, y, z, yaw_rate)
        self._client.post(partial(self._control.steer, asked))

    def take_off(self, height: float = TAKE_OFF_HEIGHT) -> float:
        """Take off to a height above the ground [m]; return when that was begun, simulated [s].

        Raises:
            WorkbenchError: if it is refused; so in the next four.
        """
        return self._client.call(self._control.take_off(height))

    def land(self) -> float:
        """Land where the drone is; return when that was begun, simulated [s]."""
        return self._client.call(self._control.land())

    def arm(self) -> float:
        """Let the rotors idle; return when that was begun, simulated [s]."""
        return self._client.call(self._control.arm())

    def stop(self) -> float:
        """Stop the rotors, wherever the drone is; return when that was, simulated [s]."""
        return self._client.call(self._control.stop())

    def hold(self) -> float:
        """Brake and hold the place, also in a take-off or a landing; return when that was begun."""
        return self._client.call(self._control.hold())

    def set(self, **values: float) -> dict[str, float]:
        """Set live parameters by name, all or none, and return them as they now are.

        Raises:
            WorkbenchError: if one is unknown or outside its limits.
        """
        return self._client.call(self._control.set(**values))


class Control(DirectControl):
    """The controls, as a context manager; see `Client.control`."""

    def __init__(self, client: "Client", control: AsyncControl) -> None:
        super().__init__(client, control)
        self._repeated = control

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
        asked = self._repeated.checked(x, y, z, yaw_rate)
        self._client.post(partial(self._repeated.steer_until, asked, lapse_time(hold)))
