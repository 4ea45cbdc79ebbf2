"""Topics of a flight that another program logged, as a log of the workbench has them, and back.

Each topic has one message per sample, of 64-bit numbers, with NaN for what was not measured at that
time. Each gap has a message of NaN only, so that no curve is drawn across it.
"""

import json
import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import Series, make_series
from workbench.link.drone_topics import drone_signals
from workbench.link.ros_messages.definitions import SCHEMA_SEPARATOR
from workbench.link.ros_messages.namespace import ros_name
from workbench.link.topics import PART_NAMES, PREFIX, value_names
from workbench.logs.logged_topic import LoggedTopic, MessageColumn
from workbench.logs.readers.rotations import (
    QUATERNION_NAMES,
    continuous,
    vectors_in_world,
    without_jumps,
)
from workbench.logs.record import LogRecord
from workbench.plant.sensors import free_name

_IMPORTED_PACKAGE = "imported_msgs"
_ROS_NAME_PATTERN = re.compile(r"[a-z][a-z0-9_]*")
_INDEX_PATTERN = re.compile(r"0|[1-9][0-9]*")
_MAX_INDEX_DIGITS = 3
"""Of the largest index of an element: no log has a thousand motors or debugged values."""


class SignalTopic(NamedTuple):
    """A topic of signals, with the definition of its messages and their numbers (n, k).

    Attributes:
        topic: with the names of the signals.
        ros_name: of the topic, which ROS 2 allows.
        signals: names of signals by those in the messages, where the two differ.
    """

    topic: LoggedTopic
    schema: str
    table: np.ndarray
    ros_name: str
    signals: Mapping[str, str]


def imported_flight(record: LogRecord) -> Flight:
    """Return the flight from a log written by `write_flight`.

    Raises:
        WorkbenchError: if the description of its signals cannot be read.
    """
    samples = {}
    for topic in imported_topics(record):  # those of a damaged part of the file are missing
        for each in topic.columns.values():
            if each.values.dtype.kind == "f":
                good = np.isfinite(each.values)
                samples[each.name] = each.time[good], each.values[good]
    with _damage_sentences(record):
        flight = Flight.from_description(json.loads(record.imported), record.path, samples)
    return replace(flight, signals=without_jumps(flight.signals))  # earlier versions left jumps


def imported_topics(record: LogRecord) -> list[LoggedTopic]:
    """Return the topics of a log written by `write_flight`, with the names of its signals.

    Raises:
        WorkbenchError: if the description of its signals cannot be read.
    """
    with _damage_sentences(record):
        said = json.loads(record.imported).get("ros_names", {})
        names = {str(ros): str(name) for ros, name in said.items()}
        return [_with_signal_names(topic, names) for topic in record.topics.values()]


def _with_signal_names(topic: LoggedTopic, names: Mapping[str, str]) -> LoggedTopic:
    """Return a topic with the names of signals in place of those that ROS 2 allows."""
    name, fields = topic.short, {}
    for path, column in topic.fields.items():
        written = f"{topic.short}.{path}"
        before, _, after = names.get(written, written).partition(".")
        fields[after] = column
        name = before if written in names else name
    return replace(topic, name=f"{PREFIX}{name}", fields=fields)


@contextmanager
def _damage_sentences(record: LogRecord) -> Iterator[None]:
    """Raise a `WorkbenchError` if the description of the signals of a log cannot be read."""
    try:
        yield
    except (
        KeyError,
        TypeError,
        ValueError,
        ArithmeticError,
        AttributeError,
        RecursionError,
    ) as error:
        raise WorkbenchError(
            f"{record.path}: its description of the signals is damaged: {error}"
        ) from error


def record_metadata(flight: Flight, topics: Iterable[SignalTopic]) -> str:
    """Return the data that are not in the messages of the topics."""
    names = {ros: name for topic in topics for ros, name in topic.signals.items()}
    return json.dumps(flight.described() | ({"ros_names": names} if names else {}), indent=1)


def signal_topics(flight: Flight) -> list[SignalTopic]:
    """Return the topics of the signals of a flight, with one message per sample.

    Raises:
        WorkbenchError: if a signal is an element of an array that no log has.
    """
    grouped: dict[str, list[Series]] = {}
    for signal in flight.signals.values():
        places = filter(_INDEX_PATTERN.fullmatch, signal.name.split("."))
        if any(len(place.lstrip("0")) > _MAX_INDEX_DIGITS for place in places):
            raise WorkbenchError(
                f"{flight.source}: {signal.name:.80} is beyond element "
                f"{10**_MAX_INDEX_DIGITS - 1} of an "
                "array: the file's list of fields is damaged"
            )
        if len(signal.time):
            grouped.setdefault(signal.name.partition(".")[0], []).append(signal)
    ros_names = _ros_names(grouped)
    texts: dict[str, str] = {}
    return [_signal_topic(name, ros_names[name], each, texts) for name, each in grouped.items()]


def _ros_names(names: Collection[str]) -> dict[str, str]:
    """Return different names that ROS 2 allows, by name: the same if it allows them."""
    found = {name: name for name in names if _ROS_NAME_PATTERN.fullmatch(name)}
    for name in names:
        if name not in found:
            signs = unicodedata.normalize("NFKD", name).lower()
            letters = "".join(each for each in signs if not unicodedata.combining(each))
            found[name] = free_name(found.values(), ros_name(letters, "n"))
    return found


def _signal_topic(
    name: str, ros_name: str, signals: list[Series], texts: dict[str, str]
) -> SignalTopic:
    kind = f"{_IMPORTED_PACKAGE}/msg/{ros_name.title().replace('_', '')}"
    tree: dict[str, Any] = {}
    for signal in signals:
        *way, last = signal.name.split(".")[1:]
        branch = tree
        for part in way:
            branch = branch.setdefault(part, {})
        branch[last] = signal
    before = len(texts)
    placed: dict[str, tuple[str, Series | None]] = {}
    kind = _define(kind, tree, texts, placed, "")
    head, *rest = islice(texts.items(), before, None)
    schema = head[1] + "".join(
        f"{SCHEMA_SEPARATOR}\nMSG: {each.replace('/msg/', '/')}\n{text}" for each, text in rest
    )
    t_ns, table = _topic_table([signal for _, signal in placed.values()])
    fields, names = {}, {}
    for (path, (unit, signal)), values in zip(placed.items(), table.T, strict=True):
        written = f"{ros_name}.{path}"
        known = signal.name if signal else written
        fields[known.partition(".")[2]] = MessageColumn(unit, values)
        if known != written:
            names[written] = known
    topic = LoggedTopic(f"{PREFIX}{name}", kind, t_ns, fields)
    return SignalTopic(topic, schema, table, ros_name, names)


def _define(
    kind: str,
    tree: Mapping[str, Any],
    texts: dict[str, str],
    placed: dict[str, tuple[str, Series | None]],
    before: str,
) -> str:
    """Add the definitions of the message of a tree and of its parts; return its type.

    Args:
        kind: type of the message, which is longer if that is another one's: as of m1_a and m1a.
        tree: its fields by name: signals, or trees.
        texts: gets the definitions by type, of all topics.
        placed: gets unit and signal by path in the message, in its order; the signal is None for an
            element of an array that has none.
        before: beginning of the paths.
    """
    lines: list[str] = []
    while kind in texts:
        kind += "Other"
    texts[kind] = ""  # the outermost comes first
    ros_names = _ros_names(tree)
    for key, value in tree.items():
        name = ros_names[key]
        path = f"{before}{name}"
        if isinstance(value, Series):
            lines.append(f"float64 {name} # [{value.unit}]")
            placed[path] = (value.unit, value)
        elif all(
            _INDEX_PATTERN.fullmatch(part) and isinstance(each, Series)
            for part, each in value.items()
        ):
            count = 1 + max(map(int, value))
            unit = next(iter(value.values())).unit
            lines.append(f"float64[{count}] {name} # [{unit}]")
            placed |= {f"{path}.{i}": (unit, value.get(str(i))) for i in range(count)}
        else:
            inner = f"{kind}{name.title().replace('_', '')}"
            inner = _define(inner, value, texts, placed, f"{path}.")
            lines.append(f"{inner.replace('/msg/', '/')} {name}")
    texts[kind] = "".join(f"{line}\n" for line in lines)
    return kind


def _topic_table(signals: list[Series | None]) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n) [ns] and values (n, k) of signals (k): all samples, and one in each gap."""
    present = [signal for signal in signals if signal is not None]
    stamps = {id(each): np.rint(each.time * 1e9).astype(np.int64) for each in present}
    within = {round(5e8 * (begin + end)) for each in present for begin, end in each.gaps}
    extra = np.array(sorted(within), dtype=np.int64)
    t_ns = np.unique(np.concatenate([*stamps.values(), extra]))
    table = np.full((len(t_ns), len(signals)), np.nan)
    for column, signal in enumerate(signals):
        if signal is not None:
            table[np.searchsorted(t_ns, stamps[id(signal)]), column] = signal.values
    return t_ns, table


_SKIPPED_FIELDS = ("covariance", "lease", "axes", "frame", "orientation", "status")
_PART_FIELDS = ("name", *PART_NAMES)
"""Fields of messages that name the parts of a drone whose values the others have."""


def _part_names(columns: Mapping[str, Series]) -> dict[str, str]:
    """Return the names of columns that are of named parts, by their numbered ones."""
    key = next((each for each in _PART_FIELDS if f"{each}.0" in columns), None)
    arrays: dict[str, int] = {}
    for stem, _, index in (path.rpartition(".") for path in columns):
        if index.isdecimal():
            arrays[stem] = arrays.get(stem, 0) + 1
    if key is None:
        return {}
    texts = [columns[f"{key}.{index}"].values for index in range(arrays.pop(key))]
    if any((values != values[0]).any() for values in texts):
        return {}
    parts = [str(values[0]) for values in texts]
    return {
        f"{stem}.{index}": f"{stem}.{name}"
        for stem, count in arrays.items()
        for index, name in enumerate(value_names(parts, count))
    }


def flight_of_log(record: LogRecord) -> Flight:
    """Return the flight of a log; the true motion is that of the simulation.

    Raises:
        WorkbenchError: if a message cannot be decoded.
    """
    try:
        return imported_flight(record) if record.imported else _own_flight(record)
    except WorkbenchError as error:  # of a damaged topic, which does not know its file
        said = str(error)
        raise WorkbenchError(
            said if said.startswith(str(record.path)) else f"{record.path}: {said}"
        ) from error


def _own_flight(record: LogRecord) -> Flight:
    """Return the log of one of our own flights."""
    end = record.duration
    signals: dict[str, Series] = {}
    plotted = [row for row in drone_signals() if row.plotted]
    for channel in (each for row in plotted for each in row.channels if not each.repeats):
        topic = record.topics.get(channel.topic.removeprefix(PREFIX))
        names = _part_names(topic.columns) if topic else {}
        for path, series in topic.columns.items() if topic else ():
            numbers = series.values.dtype.kind in "fiu"
            skipped = any(part in series.name for part in _SKIPPED_FIELDS)
            if numbers and not skipped and np.isfinite(series.values).any():
                name = f"{series.name.removesuffix(path)}{names.get(path, path)}"
                signals[name] = make_series(
                    name, series.unit, series.time, series.values, end=end, delay=0.0
                )
    states, time = record.states, np.array(record.state_ns, dtype=float) * 1e-9
    if len(states):
        q = continuous(states[:, 0:4])
        back = q * [1.0, -1.0, -1.0, -1.0]
        for field, values in zip(QUATERNION_NAMES, q.T, strict=True):
            name = f"attitude.{field}"
            signals[name] = make_series(name, "1", time, values, end=end, delay=0.0)
        for axis, values in zip("xyz", vectors_in_world(back, states[:, 7:10]).T, strict=True):
            name = f"attitude.w_{axis}"
            signals[name] = make_series(name, "rad/s", time, values, end=end, delay=0.0)
    points = _flown_points(record, time)
    if points is not None:
        for axis, values in zip("xyz", points.T, strict=True):
            name = f"setpoint.{axis}"
            signals[name] = make_series(name, "m", time, values, end=end, delay=0.0)
    return replace(record.flight, signals=signals)


def _flown_points(record: LogRecord, time: np.ndarray) -> np.ndarray | None:
    """Return the points that a pilot flew to (n, 3); None if there were also other commands.

    Before the first one it is the start position, which the mode holds.
    """
    try:
        script = record.scenario().script
    except WorkbenchError:
        return None
    actions = sorted((*script, *(each.action for each in record.done)), key=lambda each: each.at)
    flown = [each for each in actions if each.flies]
    if not flown or not len(time) or any(each.go_to is None for each in flown):
        return None
    goals = [each.go_to for each in flown if each.go_to is not None]
    points = np.vstack([record.states[0, 4:7], *map(np.array, goals)])
    return points[np.searchsorted([each.at for each in flown], time, side="right")]
