"""Orders to give parameters values: of each the newest wins, and the flight is never flooded."""

from collections import Counter
from collections.abc import Callable, Mapping

from workbench.gui.flight_model import FlightModel

Values = Mapping[str, float]
Confirmed = Callable[[Values, float], None]
"""Hears values by name, and from which simulated time on [s] they are flown."""
Refused = Callable[[Values, str], None]
"""Hears values by name that are not flown, and why."""


class GainOrders:
    """Gives the flight sets of values, each of which comes into force at one step.

    While an order for one of its parameters is not answered, the next set waits, and later ones
    with it.

    Args:
        flight: that gets them.
        confirmed: hears what is flown.
        refused: hears what is not.
    """

    def __init__(self, flight: FlightModel, confirmed: Confirmed, refused: Refused) -> None:
        self._flight = flight
        self._confirmed, self._refused = confirmed, refused
        self._asked: Counter[str] = Counter()
        self._last: dict[str, float] = {}
        self._waiting: dict[str, float] = {}
        self._flights = 0

    def wanted(self, name: str) -> float | None:
        """Return the value that was asked for last, None once all is answered."""
        if name in self._waiting:
            return self._waiting[name]
        return self._last[name] if self._asked[name] else None

    def begin(self) -> None:
        """Forget what was asked of another flight."""
        self._asked.clear()
        self._waiting.clear()
        self._flights += 1

    def give(self, values: Values) -> None:
        """Let the flight have values, once it has answered earlier orders for them."""
        if any(self.wanted(name) is not None for name in values):
            self._waiting |= values
        elif values:
            self._send(values)

    def insist(self, values: Values) -> None:
        """Let the flight have values, whatever became of the orders before."""
        for name in values:
            self._waiting.pop(name, None)
        self._send(values)

    def _send(self, values: Values) -> None:
        flight = self._flights
        self._last |= values
        self._asked.update(values.keys())
        self._flight.order(
            lambda live: live.set_all(values),
            done=lambda time: self._answered(flight, values, time, ""),
            refused=lambda said: self._answered(flight, values, 0.0, said),
        )

    def _answered(self, flight: int, values: Values, time: float, said: str) -> None:
        if flight != self._flights:
            return  # of a flight that is over
        self._asked.subtract(values.keys())
        if self._waiting and not any(self._asked[name] for name in self._waiting):
            waiting, self._waiting = self._waiting, {}
            self._send(waiting)
        if said:
            self._refused(values, said)
        else:
            self._confirmed(values, time)
