"""What the flight has, put together from its start, its answers, and what it publishes."""

from collections.abc import Iterable, Mapping

from workbench.gui.parameter_reader import ParameterReader
from workbench.link.backplane import Published
from workbench.link.topics import Topic


class FlownValues:
    """Values of the live parameters as the flight has them.

    What the flight publishes is the truth, in its order, whoever made the change; an answer to an
    order is only quicker.
    """

    def __init__(self) -> None:
        self.start: dict[str, float] = {}
        self.values: dict[str, float] = {}
        self._reader = ParameterReader()
        self._told: dict[str, float] = {}
        self._time = 0.0

    def begin(self, start: Mapping[str, float], topics: Iterable[Topic]) -> None:
        """Begin with the values of a new flight."""
        self.start = dict(start)
        self.values = dict(start)
        self._reader.begin(topics)
        self._told = {}
        self._time = 0.0

    def reset(self) -> None:
        """Go back to the start's values, but for what was told since the flight began anew."""
        told = self._told if self._time < _JUST_BEGUN else {}
        self.values = self.start | {name: self.values[name] for name in told}

    def confirm(self, values: Mapping[str, float], time: float) -> None:
        """Take an answer: values are flown from a simulated time [s] on.

        One does not count where the flight has told of a later change already.
        """
        for name, value in values.items():
            if name in self.values and self._told.get(name, -1.0) < time - _SAME_TIME:
                self.values[name] = value

    def hear(self, published: Iterable[Published]) -> set[str]:
        """Take what was published; return the names of which something was told."""
        heard = set()
        for each in published:
            time = each.t_ns * 1e-9
            if time < self._time - _SAME_TIME:  # the flight began anew
                self._told = {}
            self._time = time
            for change in self._reader.read((each,)):
                if change.name in self.values:
                    self.values[change.name] = change.value
                    self._told[change.name] = time
                    heard.add(change.name)
        return heard


_SAME_TIME = 1e-6
"""Times that differ by less are those of one step [s]."""
_JUST_BEGUN = 1.0
"""A flight that was reset is looked at within this time [s]."""
