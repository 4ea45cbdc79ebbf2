"""What was flown, as series over time: all that screens draw comes from here."""

from collections.abc import Iterable, Mapping

import numpy as np

from workbench.common.errors import unknown_name
from workbench.gui.topic_table import TopicTable
from workbench.link.backplane import Published
from workbench.link.topics import PREFIX, Topic, Value

KEPT = 180.0
"""Of every signal [s]."""


class Signals:
    """Every number that a flight publishes, by its name, as `workbench plot` has it.

    Names are TOPIC.FIELD, as velocity_data.v_x, or TOPIC.FIELD.INDEX, as rotors.thrust.0. Fields
    of text are not here; `newest` has them.
    """

    def __init__(self, seconds: float = KEPT) -> None:
        self._seconds = seconds
        self._tables: dict[int, TopicTable] = {}
        self._homes: dict[str, TopicTable] = {}
        self.now = 0.0

    def begin(self, topics: Iterable[Topic]) -> None:
        """Forget all: a flight begins, and publishes these topics."""
        self._tables = {topic.id: TopicTable(topic, self._seconds) for topic in topics}
        self._homes = {name: table for table in self._tables.values() for name in table.units}
        self.now = 0.0

    def add(self, published: Iterable[Published]) -> None:
        """Take what was published, in the order of time."""
        gathered: dict[int, tuple[list[float], list[bytes]]] = {}
        for each in published:
            time = each.t_ns * 1e-9
            self.now = max(self.now, time)
            for number, payload in each.payloads:
                times, payloads = gathered.setdefault(number, ([], []))
                times.append(time)
                payloads.append(payload)
        for number, (times, payloads) in gathered.items():
            if number in self._tables:
                self._tables[number].append(times, payloads)

    @property
    def units(self) -> Mapping[str, str]:
        """Unit of every signal, by name."""
        return {name: table.units[name] for name, table in self._homes.items()}

    def series(self, name: str, since: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values of a signal from a time on, (N) each.

        Both are views that hold until the next `add`: draw or copy them at once.

        Raises:
            WorkbenchError: if there is no such signal.
        """
        if name not in self._homes:
            raise unknown_name("signal", name, list(self._homes))
        return self._homes[name].series(name, since)

    def newest(self, topic: str) -> Mapping[str, Value]:
        """Return the newest values of a topic by field, empty before the first.

        Args:
            topic: its name without /dh_drone/.
        """
        for table in self._tables.values():
            if table.topic.name == PREFIX + topic and table.newest:
                return table.topic.unpack(table.newest)
        return {}
