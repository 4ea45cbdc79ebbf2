"""Orders to give parameters values: of each the newest wins, and the flight is never flooded."""

from collections.abc import Callable

from workbench.gui.flight_model import FlightModel

Confirmed = Callable[[str, float, float], None]
"""Hears a parameter's name, its value, and from which simulated time on [s] it is flown."""
Refused = Callable[[str, float, str], None]
"""Hears a parameter's name, the value that is not flown, and why."""


class GainOrders:
    """Gives the flight orders; while one for a parameter is not answered, the next one waits.

    Args:
        flight: that gets them.
        confirmed: hears what is flown.
        refused: hears what is not.
    """

    def __init__(self, flight: FlightModel, confirmed: Confirmed, refused: Refused) -> None:
        self._flight = flight
        self._confirmed, self._refused = confirmed, refused
        self._asked: dict[str, int] = {}
        self._last: dict[str, float] = {}
        self._waiting: dict[str, float] = {}
        self._flights = 0

    def wanted(self, name: str) -> float | None:
        """Return the value that was asked for last, None once all is answered."""
        if name in self._waiting:
            return self._waiting[name]
        return self._last[name] if name in self._asked else None

    def begin(self) -> None:
        """Forget what was asked of another flight."""
        self._asked.clear()
        self._waiting.clear()
        self._flights += 1

    def give(self, name: str, value: float) -> None:
        """Let the flight have a value, once it has answered the order before."""
        if name in self._asked:
            self._waiting[name] = value
        else:
            self._send(name, value)

    def insist(self, name: str, value: float) -> None:
        """Let the flight have a value, whatever became of the order before."""
        self._waiting.pop(name, None)
        self._send(name, value)

    def _send(self, name: str, value: float) -> None:
        flight = self._flights
        self._last[name] = value
        self._asked[name] = self._asked.get(name, 0) + 1
        self._flight.order(
            lambda live: live.set(name, value),
            done=lambda time: self._answered(flight, name, value, time, ""),
            refused=lambda said: self._answered(flight, name, value, 0.0, said),
        )

    def _answered(self, flight: int, name: str, value: float, time: float, said: str) -> None:
        if flight != self._flights:
            return  # of a flight that is over
        self._asked[name] -= 1
        if not self._asked[name]:
            del self._asked[name]
        if name not in self._asked and name in self._waiting:
            self._send(name, self._waiting.pop(name))
        if said:
            self._refused(name, value, said)
        else:
            self._confirmed(name, value, time)
