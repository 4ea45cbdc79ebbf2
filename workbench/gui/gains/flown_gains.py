"""The values of the live parameters in the flight, and the orders that change them."""

from collections.abc import Iterable, Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.flight_model import FlightModel
from workbench.gui.signals import parameter_changes
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action

_SAME_STEP_TOLERANCE_S = 1e-6
"""Times that differ by less are those of one step [s]."""
_RESET_WINDOW_S = 1.0
"""Time within which a reset is noticed [s]."""
GainValues = Mapping[str, float]


class FlownGains(QObject):
    """The flight's values of the live parameters.

    Published values count, in order; the answer to an order is only earlier.

    Args:
        flight: gets the orders.
        parent: the Qt parent.

    Attributes:
        start: values of the flight's start, by name.
        values: the values now.
    """

    changed = pyqtSignal(object)
    """Values changed; the signal has those before, by name."""
    refused = pyqtSignal(object, str)
    """Refused values by name, and the reason."""

    def __init__(self, flight: FlightModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.start: dict[str, float] = {}
        self.values: dict[str, float] = {}
        self._published: dict[str, float] = {}  # time at which a value was last published [s]
        self._time = 0.0
        self._orders = self._first_order = 0
        self._unanswered: dict[str, tuple[int, float]] = {}  # number and value of the newest order
        self._waiting: dict[str, float] = {}
        flight.streamed.connect(self._hear)

    def begin(self, view: LiveView) -> None:
        """Start with the values of a new flight; orders to the last one no longer count."""
        self.start, self.values = dict(view.values), dict(view.values)
        self._published, self._time = {}, 0.0
        self._first_order = self._orders + 1
        self._unanswered, self._waiting = {}, {}

    def reset(self) -> None:
        """Restore the initial values, except those published since the reset."""
        before = dict(self.values)
        published = self._published if self._time < _RESET_WINDOW_S else {}
        self.values = self.start | {name: self.values[name] for name in published}
        self._tell(before)

    def is_ordered(self, name: str) -> bool:
        """Return whether an order for a parameter is unanswered."""
        return name in self._waiting or name in self._unanswered

    def ordered(self, name: str) -> float:
        """Return the value of the newest unanswered order, or else the flown one."""
        if name in self._waiting:
            return self._waiting[name]
        return self._unanswered[name][1] if name in self._unanswered else self.values[name]

    @property
    def all_ordered(self) -> dict[str, float]:
        """`ordered` of every parameter."""
        return {name: self.ordered(name) for name in self.values}

    def order(self, values: GainValues) -> None:
        """Order values, all for one step.

        While an order for one of them is unanswered they wait, and later sets with them; of each
        parameter the newest value is sent then, so that no drag floods the flight.
        """
        if any(map(self.is_ordered, values)):
            self._waiting |= values
        elif values:
            self._orders += 1
            number = self._orders
            self._unanswered |= {name: (number, value) for name, value in values.items()}
            self._flight.do(
                Action(set=dict(values)),
                done=lambda time: self._answered(number, values, time, ""),
                refused=lambda said: self._answered(number, values, 0.0, said),
            )

    def order_now(self, values: GainValues) -> None:
        """Order values at once, whatever happened to earlier orders."""
        for name in values:
            self._waiting.pop(name, None)
            self._unanswered.pop(name, None)
        self.order(values)

    def _answered(self, number: int, values: GainValues, time: float, said: str) -> None:
        if number < self._first_order:
            return  # of an earlier flight
        for name in values:
            if name in self._unanswered and self._unanswered[name][0] == number:
                del self._unanswered[name]
        waiting, self._waiting = self._waiting, {}
        self.order(waiting)
        if said:
            self.refused.emit(values, said)
        else:
            self._confirm(values, time)

    def _confirm(self, values: GainValues, time: float) -> None:
        """Accept values that fly from a simulated time [s] on, unless later ones were published."""
        before = dict(self.values)
        for name, value in values.items():
            if (
                name in self.values
                and self._published.get(name, -1.0) < time - _SAME_STEP_TOLERANCE_S
            ):
                self.values[name] = value
        self._tell(before)

    def _hear(self, published: Iterable[Published]) -> None:
        before = dict(self.values)
        for each in published:
            time = each.t_ns * 1e-9
            if time < self._time - _SAME_STEP_TOLERANCE_S:  # the flight restarted
                self._published = {}
            self._time = time
            for _, name, value in parameter_changes((each,)):
                if name in self.values:
                    self.values[name] = value
                    self._published[name] = time
        self._tell(before)

    def _tell(self, before: GainValues) -> None:
        if before != self.values:
            self.changed.emit(before)
