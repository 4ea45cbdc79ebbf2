"""Logs of topics: tables over time, and the rows that say which of their fields become signals."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.logs.flight_record import FlightRecord, Signal, make_signal
from workbench.logs.readers.packed import stem
from workbench.logs.readers.rotations import ANGLES, QUATERNION, angles

SIGNAL_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*|\.\d+)+")
"""Pattern of the name of a signal: TOPIC.FIELD, with dots before parts of a field and indices."""
_ARRAY = re.compile(r"(.*)\[(\d+)\]")
Convert = Callable[[np.ndarray], np.ndarray]


class Table(NamedTuple):
    """The messages of a topic: their times (n) [s], and the values (n) of each field."""

    time: np.ndarray
    fields: Mapping[str, np.ndarray]


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
    end: float,
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
        end: of the log [s].
        firmware: name and version.
        parameters: of the firmware, by name.
        remarks: on the log; empty ones are left out.
    """
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, time: np.ndarray, values: np.ndarray) -> None:
        if name not in signals and np.isfinite(values).any():
            values = np.where(time >= 0.0, values, np.nan)
            signals[name] = make_signal(name, unit, time, values, end=end)

    for row in rows:
        table = tables.get(row.topic)
        if table is not None and all(field in table.fields for field in row.fields):
            found = row.convert(np.column_stack([table.fields[field] for field in row.fields]))
            for name, values in zip(row.names, found.T, strict=True):
                add(name, row.unit, table.time, values)
    for topic, table in tables.items():
        for field, values in table.fields.items():
            add(own_name(topic, field), "", table.time, values)
    return FlightRecord(
        name=stem(path),
        source=path,
        format=format_,
        firmware=firmware,
        parameters=parameters,
        remarks=tuple(filter(None, remarks)),
        signals=signals,
        end=end,
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
