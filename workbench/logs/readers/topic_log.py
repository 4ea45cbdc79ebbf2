"""Logs of topics: tables over time, and the rows that say which of their fields become signals."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord, Signal, make_signal
from workbench.logs.readers.clock import read_clock, stamps_of
from workbench.logs.readers.packed import stem
from workbench.logs.readers.rotations import ANGLES, QUATERNION, angles, without_jumps

SIGNAL_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*|\.\d+)+")
"""Pattern of the name of a signal: TOPIC.FIELD, with dots before parts of a field and indices."""
_ARRAY = re.compile(r"(.*)\[(\d+)\]")
Convert = Callable[[np.ndarray], np.ndarray]


class Table(NamedTuple):
    """The messages of a topic, in the order of the file.

    Attributes:
        ticks: time stamps (n); NaN where there is none.
        fields: values (n) by name.
        places: of the messages in the file (n), comparable between topics; None if there is only
            one topic.
    """

    ticks: np.ndarray
    fields: Mapping[str, np.ndarray]
    places: np.ndarray | None = None


class Row(NamedTuple):
    """Which signals some fields of a topic become.

    Attributes:
        topic: of the log.
        fields: of the topic (k); the row is skipped if one is missing.
        names: of the signals (m).
        unit: of the signals, SI.
        convert: makes values of the signals (n, m) from those of the fields (n, k).
    """

    topic: str
    fields: Sequence[str]
    names: Sequence[str]
    unit: str
    convert: Convert = np.asarray


def scaled(factor: float) -> Convert:
    """Return a conversion that multiplies by a factor."""
    return lambda values: factor * values


def share(low: float, full: float) -> Convert:
    """Return a conversion from the outputs of a motor to shares of its full command."""
    return lambda values: np.clip((values - low) / (full - low), 0.0, 1.0)


def attitude_rows(
    topic: str, fields: Sequence[str], wanted: str, convert: Convert, turn: str = ""
) -> list[Row]:
    """Return the rows of an attitude: roll, pitch and yaw, and the quaternion.

    Args:
        topic: of the log.
        fields: of the topic.
        wanted: topic of the signals.
        convert: makes quaternions B to W (n, 4), w first, from the fields.
        turn: topic of the signals of the quaternion, "" for `wanted`.
    """
    return [
        Row(topic, fields, [f"{wanted}.{a}" for a in ANGLES], "rad", lambda v: angles(convert(v))),
        Row(topic, fields, [f"{turn or wanted}.{part}" for part in QUATERNION], "1", convert),
    ]


def topic_record(
    path: Path,
    format_: str,
    tables: Mapping[str, Table],
    rows: Iterable[Row],
    *,
    tick: float,
    counter: bool = False,
    begin: float | None = None,
    noun: str = "sample",
    firmware: str,
    parameters: Mapping[str, float | str],
    remarks: Iterable[str],
) -> FlightRecord:
    """Return the flight record of a log of topics.

    Of several rows for one signal, the first one found in the log counts. All other fields keep the
    names of the log, in lower case.

    Args:
        path: the log.
        format_: its format.
        tables: by topic.
        rows: of the format.
        tick: of the time stamps [s].
        counter: whether the stamps are a counter of 32 bits.
        begin: stamp of time 0 if the log states it; what was measured before is left out.
        noun: of a message in remarks.
        firmware: name and version.
        parameters: of the firmware, by name.
        remarks: on the log; empty ones are left out.

    Raises:
        WorkbenchError: if fewer than two messages have a time.
    """
    clock = read_clock(
        {
            topic: stamps_of(table.ticks, table.fields.values(), table.places)
            for topic, table in tables.items()
        },
        tick,
        counter=counter,
        begin=begin,
        noun=noun,
    )
    if not clock.end > 0.0:
        raise WorkbenchError(f"{path}: has fewer than two times: it is empty or damaged")
    kept = {topic: np.flatnonzero(time >= 0.0) for topic, time in clock.times.items()}
    times = {topic: clock.times[topic][each] for topic, each in kept.items()}
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, time: np.ndarray, values: np.ndarray) -> None:
        if name not in signals and np.isfinite(values).any():
            signals[name] = make_signal(
                name, unit, time, values, end=clock.end, breaks=clock.breaks
            )

    for row in rows:
        table = tables.get(row.topic)
        if table is not None and all(field in table.fields for field in row.fields):
            values = np.column_stack([table.fields[field] for field in row.fields])
            found = row.convert(values[kept[row.topic]])
            for name, column in zip(row.names, found.T, strict=True):
                add(name, row.unit, times[row.topic], column)
    for topic, table in tables.items():
        for field, values in table.fields.items():
            add(own_name(topic, field), "", times[topic], values[kept[topic]])
    return FlightRecord(
        name=stem(path),
        source=path,
        format=format_,
        firmware=firmware,
        parameters=parameters,
        remarks=(*filter(None, remarks), *clock.remarks),
        signals=without_jumps(signals),
        end=clock.end,
    )


def own_name(topic: str, field: str) -> str:
    """Return the name of a signal that the workbench has no name for: the log's, in lower case.

    Args:
        topic: of the log, such as "vehicle_status".
        field: of the topic; "output[3]" is element 3 of an array.
    """
    array = _ARRAY.fullmatch(field)
    index = f".{int(array[2])}" if array else ""
    return f"{_plain(topic)}.{_plain(array[1] if array else field)}{index}"


def _plain(text: str) -> str:
    """Return a text as a part of a name."""
    plain = re.sub(r"[^a-z0-9_]+", "_", text.lower()).strip("_")
    return plain if re.match(r"[a-z]", plain) else f"n_{plain}"
