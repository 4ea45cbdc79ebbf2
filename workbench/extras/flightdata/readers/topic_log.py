"""Logs of topics: tables over time, and the rows that say which of their fields become signals."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark
from workbench.common.series import Series, make_series
from workbench.extras.flightdata.readers.axes import angles
from workbench.extras.flightdata.readers.clock import read_clock, stamps_of
from workbench.logs.logged_signal import signal_name_part
from workbench.logs.readers.packed import log_stem
from workbench.logs.readers.rotations import (
    EULER_ANGLE_NAMES,
    QUATERNION_NAMES,
    without_jumps,
)

_ARRAY_FIELD_PATTERN = re.compile(r"(.*)\[(\d+)\]")
ONLY_TOPIC = "blackbox"
"""Name of the only table of a log without topics: it is no part of names."""
MAX_PARAMETER_NUMBER = 1e9
"""Number of the parameters from which on it is damage."""
MAX_FIRST_NAMES = 8
"""Number of names that a remark lists."""
ColumnConversion = Callable[[np.ndarray], np.ndarray]


class MessageTable(NamedTuple):
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


class SignalRow(NamedTuple):
    """Which signals some fields of a topic become.

    Attributes:
        topic: of the log.
        fields: of the topic (k); the row is skipped if one is missing.
        names: of the signals (m).
        unit: of the signals, SI.
        convert: makes values of the signals (n, m) from those of the fields (n, k).
        flags: for each field the one that is not 0 where it is valid; none for all, and a flag that
            the topic lacks does not count.
    """

    topic: str
    fields: Sequence[str]
    names: Sequence[str]
    unit: str
    convert: ColumnConversion = np.asarray
    flags: Sequence[str] = ()

    def values_of(self, table: MessageTable) -> np.ndarray:
        """Return the values of the signals (n, m); NaN where a flag says that one is invalid."""
        values = np.column_stack([table.fields[field] for field in self.fields])
        for place, flag in enumerate(self.flags):
            if flag in table.fields:
                values[table.fields[flag] == 0.0, place] = np.nan
        return self.convert(values)

    def source_of(self, place: int) -> str:
        """Return what the signal at a place is made of, by the log's names.

        The conversion tells: east is made of the second field of a position north, east, down.
        """
        count = len(self.fields)
        changed = np.full((1 + count, count), 0.5) + 0.25 * np.eye(1 + count, count, -1)
        values = self.convert(changed)[:, place]
        moved = np.flatnonzero(np.abs(values[1:] - values[0]) > 1e-9)
        if len(moved) == 1:
            named = self.fields[moved[0]]
        elif len(moved) == 0 and count == len(self.names):  # limited there
            named = self.fields[place]
        else:  # as angles of a quaternion, an array
            named = ", ".join(dict.fromkeys(each.partition("[")[0] for each in self.fields))
        return named if self.topic == ONLY_TOPIC else f"{self.topic}.{named}"


def first_names(names: Sequence[str]) -> str:
    """Return the first names as a text, with an ellipsis if there are more."""
    more = " ..." if len(names) > MAX_FIRST_NAMES else ""
    return f"{', '.join(names[:MAX_FIRST_NAMES])}{more}"


def changed_parameters_remark(names: Sequence[str]) -> str:
    """Return the remark on parameters that changed in a log, "" without any."""
    if not names:
        return ""
    text = (
        f"{len(names)} parameters changed in the log; the last values count: {first_names(names)}"
    )
    return LogRemark(text, len(names), names[0])


def several_batteries_remark(names: Sequence[str]) -> str:
    """Return the remark on the messages of several batteries, whose first one has the signals."""
    text = (
        f"{len(names)} batteries have a voltage: battery.voltage and battery.current are those of "
        f"{names[0]}; {', '.join(names[1:])} keep their names"
    )
    return LogRemark(text, len(names), names[0])


def parameter_number(parameters: Mapping[str, object], name: str) -> float:
    """Return a number of a log's parameters; 0 if there is none, or no plausible one."""
    value = parameters.get(name)
    plausible = isinstance(value, int | float) and abs(value) < MAX_PARAMETER_NUMBER
    return float(value) if plausible else 0.0


def scaled(factor: float) -> ColumnConversion:
    """Return a conversion that multiplies by a factor."""
    return lambda values: factor * values


def motor_share(low: float, full: float) -> ColumnConversion:
    """Return a conversion from the outputs of a motor to shares of its full command."""
    return lambda values: np.clip((values - low) / (full - low), 0.0, 1.0)


def attitude_rows(
    topic: str, fields: Sequence[str], wanted: str, convert: ColumnConversion, turn: str = ""
) -> list[SignalRow]:
    """Return the rows of an attitude: roll, pitch and yaw, and the quaternion.

    Args:
        topic: of the log.
        fields: of the topic.
        wanted: topic of the signals.
        convert: makes quaternions B to W (n, 4), w first, from the fields.
        turn: topic of the signals of the quaternion, "" for `wanted`.
    """
    return [
        SignalRow(
            topic,
            fields,
            [f"{wanted}.{a}" for a in EULER_ANGLE_NAMES],
            "rad",
            lambda v: angles(convert(v)),
        ),
        SignalRow(
            topic, fields, [f"{turn or wanted}.{part}" for part in QUATERNION_NAMES], "1", convert
        ),
    ]


def topic_record(
    path: Path,
    format_: str,
    tables: Mapping[str, MessageTable],
    rows: Iterable[SignalRow],
    *,
    tick: float,
    counter: bool = False,
    begin: float | None = None,
    noun: str = "sample",
    firmware: str,
    parameters: Mapping[str, float | str],
    remarks: Iterable[str],
) -> Flight:
    """Return the flight of a log of topics.

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
    signals: dict[str, Series] = {}

    def add(name: str, unit: str, time: np.ndarray, values: np.ndarray, source: str = "") -> None:
        if name not in signals and np.isfinite(values).any():
            made = make_series(name, unit, time, values, end=clock.end, breaks=clock.breaks)
            signals[name] = replace(made, source=source)

    for row in rows:
        table = tables.get(row.topic)
        if table is not None and all(field in table.fields for field in row.fields):
            found = row.values_of(table)[kept[row.topic]]
            for place, (name, column) in enumerate(zip(row.names, found.T, strict=True)):
                add(name, row.unit, times[row.topic], column, row.source_of(place))
    for topic, table in tables.items():
        for field, values in table.fields.items():
            add(name_of_unknown_signal(topic, field), "", times[topic], values[kept[topic]])
    return Flight(
        name=log_stem(path),
        source=path,
        format=format_,
        firmware=firmware,
        parameters=parameters,
        remarks=(*filter(None, remarks), *clock.remarks),
        signals=without_jumps(signals),
        end=clock.end,
        clock_start=clock.begin * tick,
    )


def name_of_unknown_signal(topic: str, field: str) -> str:
    """Return the name of a signal that the workbench has no name for: the log's, in lower case.

    Args:
        topic: of the log, such as "vehicle_status".
        field: of the topic; "output[3]" is element 3 of an array.
    """
    array = _ARRAY_FIELD_PATTERN.fullmatch(field)
    index = f".{int(array[2])}" if array else ""
    return f"{signal_name_part(topic)}.{signal_name_part(array[1] if array else field)}{index}"
