"""The controls for a plain program: what `control` does in the client's thread, from another."""

from typing import TYPE_CHECKING

from workbench.link.control import AsyncControl
from workbench.link.operations import TAKE_OFF_HEIGHT

if TYPE_CHECKING:
    from workbench.link.client import Client


class Control:
    """The controls, as a context manager; see `Client.control`."""

    def __init__(self, client: "Client", control: AsyncControl) -> None:
        self._client = client
        self._control = control

    def __enter__(self) -> "Control":
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
        """Fly at a velocity in W [m/s] and turn [rad/s], until told otherwise.

        It is repeated 20 times a second as long as the block runs.

        Raises:
            WorkbenchError: if control was lost, a number is not finite, or the last velocity was
                refused.
        """
        self._client.post(self._control, self._control.checked(x, y, z, yaw_rate))

    def take_off(self, height: float = TAKE_OFF_HEIGHT) -> float:
        """Take off to a height above the ground [m]; return when that was begun, simulated [s].

        Raises:
            WorkbenchError: if it is refused; so in the next three.
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

    def set(self, **values: float) -> dict[str, float]:
        """Set live parameters by name, all or none, and return them as they now are.

        Raises:
            WorkbenchError: if one is unknown or outside its limits.
        """
        return self._client.call(self._control.set(**values))
