"""Brings what the sticks ask for to the flight: not too often, and never a stop too late."""

from collections.abc import Callable

Velocity = tuple[float, float, float]
Send = Callable[[Velocity, float], None]

MOST_A_SECOND = 30.0
"""Commands that are sent, zeros left out: each of them ends a wish, so they are no more."""
REPEAT = 1.0
"""After which a wish that has not changed is said again [s]."""
STEP = 0.005
"""Changes smaller than this are none: a hovering drone's heading trembles [m/s]."""
TURN_STEP = 0.001
"""The same of the yaw rate [rad/s]."""
_STILL = (0.0, 0.0, 0.0)


class Courier:
    """Sends commands on change.

    Args:
        send: gives the flight a velocity in W [m/s] and a yaw rate [rad/s].
        clock: rises, whatever happens to the date [s].
    """

    def __init__(self, send: Send, clock: Callable[[], float]) -> None:
        self._send, self._clock = send, clock
        self._sent: tuple[Velocity, float] = (_STILL, 0.0)
        self._when = -REPEAT

    @property
    def is_asking(self) -> bool:
        """Whether the last thing sent asked for a motion."""
        return self._sent != (_STILL, 0.0)

    def put(self, velocity: Velocity, yaw_rate: float) -> None:
        """Send what is wished now, if it is due; to be called again until it is another.

        Args:
            velocity: in W [m/s].
            yaw_rate: seen from above to the left [rad/s].
        """
        if not any((*velocity, yaw_rate)):
            self.stop()
            return
        now = self._clock()
        waited = now - self._when
        if waited < 1.0 / MOST_A_SECOND:
            return
        if waited >= REPEAT or self._differs(velocity, yaw_rate):
            self._sent, self._when = (velocity, yaw_rate), now
            self._send(velocity, yaw_rate)

    def stop(self) -> None:
        """Send zero at once, if a motion was asked for."""
        if self.is_asking:
            self._sent = (_STILL, 0.0)
            self._send(*self._sent)

    def forget(self) -> None:
        """Take nothing as sent: another flight begins."""
        self._sent = (_STILL, 0.0)

    def _differs(self, velocity: Velocity, yaw_rate: float) -> bool:
        before, turned = self._sent
        step = max(abs(new - old) for new, old in zip(velocity, before, strict=True))
        return not self.is_asking or step > STEP or abs(yaw_rate - turned) > TURN_STEP
