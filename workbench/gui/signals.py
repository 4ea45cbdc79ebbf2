"""Signals of a flight over time, its events, and changes of live parameters; no Qt."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from workbench.common.errors import unknown_name
from workbench.common.series import TimedValues
from workbench.gui.ring import RowRingBuffer
from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS_SIGNAL, PARAMETERS_SIGNAL, fixed_topic
from workbench.link.topics import PREFIX, STRUCT_CODES, Field, FieldValue, Topic
from workbench.plant.vehicle import Vehicle

MAX_STORED_COLUMNS = 64
"""Largest number of values of a topic that is stored over time; of larger ones, as a point cloud,
only the newest sample is stored."""
EVENT_TOPIC_RATE_HZ = 10.0
"""Assumed rate of a topic that is published on events [1/s]."""

SIGNAL_HISTORY_S = 180.0
"""Stored time of every signal [s]."""
EVENT_SEVERITIES = ("information", "warning", "failure")


class TopicTable:
    """Samples of one topic: numbers over time, without texts.

    Args:
        topic: the topic.
        seconds: stored time.
        vehicle: that publishes it, if it is known.

    Attributes:
        topic: the topic.
        units: unit of each column, by its name: TOPIC.FIELD, or TOPIC.FIELD.INDEX of several
            numbers, with the name of a part in place of the index if the topic has them.
        newest: payload of the newest sample, b"" before the first.
    """

    def __init__(self, topic: Topic, seconds: float, vehicle: Vehicle | None = None) -> None:
        self.topic = topic
        self.newest = b""
        numeric = [each for each in topic.fields if each.type in STRUCT_CODES]
        columns = sum(each.count for each in numeric)
        self.units: dict[str, str] = {}
        self._type = np.dtype(
            {
                "names": [each.name for each in numeric],
                "formats": [(f"<{STRUCT_CODES[each.type]}", (each.count,)) for each in numeric],
                "offsets": [_offset(topic, each.name) for each in numeric],
                "itemsize": topic.packer.size,
            }
        )
        self._ring = RowRingBuffer(0, 1)
        if 0 < columns <= MAX_STORED_COLUMNS:
            short = topic.name.removeprefix(PREFIX)
            for each in numeric:
                names = [f"{short}.{each.name}.{name}" for name in topic.value_names(each)]
                units = _value_units(each, vehicle)
                named = zip(names, units, strict=True)
                self.units.update({name.removesuffix("."): unit for name, unit in named})
            self._ring = RowRingBuffer(
                round(seconds * (topic.rate or EVENT_TOPIC_RATE_HZ)), 1 + columns
            )
        self._columns = {name: 1 + index for index, name in enumerate(self.units)}

    def append(self, times: Sequence[float], payloads: Sequence[bytes]) -> None:
        """Append samples at times [s], in order."""
        self.newest = payloads[-1]
        if not self._columns:
            return
        table = np.frombuffer(b"".join(payloads), self._type)
        parts = [table[name].reshape(len(table), -1) for name in self._type.names or ()]
        self._ring.append(np.hstack([np.array(times)[:, None], *parts]))

    def series(self, name: str, since: float) -> TimedValues:
        """Return times and values of a column (N) [s], from a time on: views, for immediate use."""
        rows = self._ring.rows(since)
        return rows[:, 0], rows[:, self._columns[name]]


def _value_units(each: Field, vehicle: Vehicle | None) -> Sequence[str]:
    """Return the unit of each value of a field: of a joint, whether it turns or slides."""
    turning, _, sliding = each.unit.partition(" or ")
    units = vehicle.published_joint_units if vehicle is not None else {}
    if not sliding or len(units) != each.count:
        return [each.unit] * each.count
    return [sliding if unit == "m" else turning for unit in units.values()]


def _offset(topic: Topic, name: str) -> int:
    """Return the offset of a field in a payload [bytes]."""
    before = 0
    for each in topic.fields:
        if each.name == name:
            break
        before += each.size
    return before


class Signals:
    """Every number that a flight publishes, by its name, as in `workbench plot`.

    Names are TOPIC.FIELD, as velocity_data.v_x, or TOPIC.FIELD.INDEX, as rotors.thrust.0. Text
    fields are available only from `newest`.
    """

    def __init__(self, seconds: float = SIGNAL_HISTORY_S) -> None:
        self._seconds = seconds
        self._tables: dict[int, TopicTable] = {}
        self._homes: dict[str, TopicTable] = {}
        self.now = 0.0

    def begin(self, topics: Iterable[Topic], vehicle: Vehicle | None = None) -> None:
        """Clear all: a flight of a vehicle begins, and publishes these topics."""
        self._tables = {topic.id: TopicTable(topic, self._seconds, vehicle) for topic in topics}
        self._homes = {name: table for table in self._tables.values() for name in table.units}
        self.now = 0.0

    def add(self, published: Iterable[Published]) -> None:
        """Add published data, in order of time."""
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

    def series(self, name: str, since: float = -np.inf) -> TimedValues:
        """Return times [s] and values of a signal from a time on, (N) each.

        Both are views that are valid until the next `add`: draw or copy them at once.

        Raises:
            WorkbenchError: if there is no such signal.
        """
        if name not in self._homes:
            raise unknown_name("signal", name, list(self._homes))
        return self._homes[name].series(name, since)

    def newest(self, topic: str) -> Mapping[str, FieldValue]:
        """Return the newest values of a topic by field, empty before the first.

        Args:
            topic: its name without /dh_drone/.
        """
        for table in self._tables.values():
            if table.topic.name == PREFIX + topic and table.newest:
                return table.topic.unpack(table.newest)
        return {}


def parameter_changes(published: Iterable[Published]) -> Iterator[tuple[float, str, float]]:
    """Yield simulated time [s], name and new value in SI of each changed parameter, in order."""
    for each in published:
        for number, payload in each.payloads:
            if number == PARAMETERS_SIGNAL.id:
                told = fixed_topic(number).unpack(payload)
                assert isinstance(told["value"], float)
                yield each.t_ns * 1e-9, str(told["name"]), told["value"]


FlightEvent = tuple[float, str, str]
"""Simulated time [s]; information, warning, failure or parameter; and the event in words."""


def events_in(published: Iterable[Published]) -> list[FlightEvent]:
    """Return events and changed parameters in published data, newest last."""
    found: list[FlightEvent] = []
    for each in published:
        time = each.t_ns * 1e-9
        for number, payload in each.payloads:
            if number == EVENTS_SIGNAL.id:
                told = fixed_topic(number).unpack(payload)
                assert isinstance(told["severity"], int)
                severity = EVENT_SEVERITIES[min(max(told["severity"], 0), 2)]
                found.append((time, severity, str(told["said"])))
        for _, name, value in parameter_changes((each,)):
            found.append((time, "parameter", f"{name} = {value:g}"))
    return found
