"""Convert flight records to logs of the workbench, and back.

Tools for our own flights then also show imported ones. Each topic has one message per sample, of
64-bit numbers, with NaN for what was not measured at that time. Each gap has a message of NaN only,
so that no curve is drawn across it.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.well_known import MessageEncoding, SchemaEncoding

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros_messages.cdr import ENCAPSULATION
from workbench.gateways.ros_messages.definitions import SEPARATOR
from workbench.link.topics import PREFIX
from workbench.logs.contents import IMPORTED, VERSIONS, versions
from workbench.logs.flight_record import FlightRecord, Signal, make_signal
from workbench.logs.mcap_writer import McapWriter
from workbench.logs.readers.packed import stem
from workbench.logs.readers.rotations import QUATERNION, continuous, in_world, without_jumps
from workbench.logs.record import LogRecord
from workbench.logs.series import Column, LoggedTopic

_PACKAGE = "imported_msgs"
_PLACE = re.compile(r"\d+")
_DIGITS = 3
"""Of the largest index of an element: no log has a thousand motors or debugged values."""


class _Stream(NamedTuple):
    """A topic of signals, with the definition of its messages and their numbers (n, k)."""

    topic: LoggedTopic
    schema: str
    table: np.ndarray


def log_of(flight: FlightRecord) -> LogRecord:
    """Return a flight in the form that `read_log` returns."""
    topics = [each.topic for each in _streams(flight)]
    return LogRecord(
        path=flight.source,
        vehicle=flight.name,
        physics_step=0.0,
        versions={},
        scenario_text="",
        settings={},
        values={},
        topics={topic.short: topic for topic in topics},
        remark="; ".join(flight.remarks),
        imported=_about(flight),
    )


def write_flight(flight: FlightRecord, path: Path) -> None:
    """Write a flight as a log of the workbench; `flight_of` restores the same flight.

    Raises:
        OSError: if the file cannot be written.
    """
    streams = _streams(flight)
    found = versions()
    writer = McapWriter(path, f"workbench {found['workbench']}")
    try:
        writer.add_metadata(VERSIONS, found)
        writer.add_attachment(0, 0, IMPORTED, "application/json", _about(flight).encode())
        channels = []
        for topic, schema, _ in streams:
            number = writer.register_schema(topic.type, SchemaEncoding.ROS2, schema.encode())
            channels.append(writer.register_channel(topic.name, MessageEncoding.CDR, number))
        rows = [
            (t_ns, channel, row)
            for channel, (topic, _, table) in zip(channels, streams, strict=True)
            for t_ns, row in zip(topic.t_ns.tolist(), table, strict=True)
        ]
        for t_ns, channel, row in sorted(rows, key=lambda row: row[:2]):
            writer.message(channel, t_ns, t_ns, ENCAPSULATION + row.tobytes())
        writer.finish()
    except BaseException:
        writer.give_up()
        raise


def flight_of(record: LogRecord) -> FlightRecord:
    """Return the flight from a log written by `write_flight`.

    Raises:
        WorkbenchError: if the description of its signals cannot be read.
    """
    samples = {}
    for topic in record.topics.values():  # those of a damaged part of the file are missing
        for each in topic.columns.values():
            if each.values.dtype.kind == "f":
                good = np.isfinite(each.values)
                samples[each.name] = each.time[good], each.values[good]
    try:
        flight = FlightRecord.from_description(json.loads(record.imported), record.path, samples)
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
    return replace(flight, signals=without_jumps(flight.signals))  # earlier versions left jumps


def _about(flight: FlightRecord) -> str:
    """Return the data that are not in the messages."""
    return json.dumps(flight.described(), indent=1)


def _streams(flight: FlightRecord) -> list[_Stream]:
    """Return the topics of the signals of a flight, with one message per sample.

    Raises:
        WorkbenchError: if a signal is an element of an array that no log has.
    """
    grouped: dict[str, list[Signal]] = {}
    for signal in flight.signals.values():
        places = filter(_PLACE.fullmatch, signal.name.split("."))
        if any(len(place.lstrip("0")) > _DIGITS for place in places):
            raise WorkbenchError(
                f"{flight.source}: {signal.name:.80} is beyond element {10**_DIGITS - 1} of an "
                "array: the file's list of fields is damaged"
            )
        if len(signal.time):
            grouped.setdefault(signal.name.partition(".")[0], []).append(signal)
    return [_stream(name, signals) for name, signals in grouped.items()]


def _stream(name: str, signals: list[Signal]) -> _Stream:
    kind = f"{_PACKAGE}/msg/{name.title().replace('_', '')}"
    tree: dict[str, Any] = {}
    for signal in signals:
        *way, last = signal.name.split(".")[1:]
        branch = tree
        for part in way:
            branch = branch.setdefault(part, {})
        branch[last] = signal
    texts: dict[str, str] = {}
    placed: dict[str, tuple[str, Signal | None]] = {}
    _define(kind, tree, texts, placed, "")
    head, *rest = texts.items()
    schema = head[1] + "".join(
        f"{SEPARATOR}\nMSG: {each.replace('/msg/', '/')}\n{text}" for each, text in rest
    )
    t_ns, table = _table([signal for _, signal in placed.values()])
    columns = zip(placed.items(), table.T, strict=True)
    fields = {path: Column(unit, values) for (path, (unit, _)), values in columns}
    gaps = {signal.name: signal.gaps for signal in signals}
    topic = LoggedTopic(f"{PREFIX}{name}", name, kind, t_ns, fields, gaps=gaps)
    return _Stream(topic, schema, table)


def _define(
    kind: str,
    tree: Mapping[str, Any],
    texts: dict[str, str],
    placed: dict[str, tuple[str, Signal | None]],
    before: str,
) -> None:
    """Add the definitions of the message of a tree and of its parts.

    Args:
        kind: type of the message.
        tree: its fields by name: signals, or trees.
        texts: gets the definitions by type.
        placed: gets unit and signal by the path of the field, in the order of the message; the
            signal is None for an element of an array that has none.
        before: beginning of the paths.
    """
    lines: list[str] = []
    texts[kind] = ""  # the outermost comes first
    for name, value in tree.items():
        path = f"{before}{name}"
        if isinstance(value, Signal):
            lines.append(f"float64 {name} # [{value.unit}]")
            placed[path] = (value.unit, value)
        elif all(_PLACE.fullmatch(part) for part in value):
            count = 1 + max(map(int, value))
            unit = next(iter(value.values())).unit
            lines.append(f"float64[{count}] {name} # [{unit}]")
            placed |= {f"{path}.{i}": (unit, value.get(str(i))) for i in range(count)}
        else:
            inner = f"{kind}{name.title().replace('_', '')}"
            lines.append(f"{inner.replace('/msg/', '/')} {name}")
            _define(inner, value, texts, placed, f"{path}.")
    texts[kind] = "".join(f"{line}\n" for line in lines)


def _table(signals: list[Signal | None]) -> tuple[np.ndarray, np.ndarray]:
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


FORMAT = "workbench log"
_TOPICS = (
    "position_data",
    "velocity_data",
    "acceleration_data",
    "force_torque_data",
    "command_velocity",
    "rotors",
    "imu",
    "gps",
    "gps_velocity",
    "magnetometer",
    "estimate",
    "wind",
)
"""Topics with numbers that become signals."""
_UNWANTED = ("covariance", "lease", "axes", "frame", "orientation", "status")


def flight_record(record: LogRecord) -> FlightRecord:
    """Return a log as a flight record; the true motion is that of the simulation.

    Raises:
        WorkbenchError: if a message cannot be decoded.
    """
    try:
        return flight_of(record) if record.imported else _flown(record)
    except WorkbenchError as error:  # of a damaged topic, which does not know its file
        said = str(error)
        raise WorkbenchError(
            said if said.startswith(str(record.path)) else f"{record.path}: {said}"
        ) from error


def _flown(record: LogRecord) -> FlightRecord:
    """Return the log of one of our own flights."""
    end = record.duration
    signals: dict[str, Signal] = {}
    for name in _TOPICS:
        topic = record.topics.get(name)
        for series in topic.columns.values() if topic else ():
            numbers = series.values.dtype.kind in "fiu"
            if numbers and not any(part in series.name for part in _UNWANTED):
                signals[series.name] = make_signal(
                    series.name, series.unit, series.time, series.values, end=end, delay=0.0
                )
    states, time = record.states, np.array(record.state_ns, dtype=float) * 1e-9
    if len(states):
        q = continuous(states[:, 0:4])
        back = q * [1.0, -1.0, -1.0, -1.0]
        for field, values in zip(QUATERNION, q.T, strict=True):
            name = f"attitude.{field}"
            signals[name] = make_signal(name, "1", time, values, end=end, delay=0.0)
        for axis, values in zip("xyz", in_world(back, states[:, 7:10]).T, strict=True):
            name = f"attitude.w_{axis}"
            signals[name] = make_signal(name, "rad/s", time, values, end=end, delay=0.0)
    points = _points(record, time)
    if points is not None:
        for axis, values in zip("xyz", points.T, strict=True):
            name = f"setpoint.{axis}"
            signals[name] = make_signal(name, "m", time, values, end=end, delay=0.0)
    return FlightRecord(
        name=stem(record.path),
        source=record.path,
        format=FORMAT,
        firmware=f"workbench {record.versions.get('workbench', '')}".strip(),
        parameters={
            "vehicle": record.vehicle,
            **({"controller": record.controller["name"]} if "name" in record.controller else {}),
            **record.values,
        },
        remarks=tuple(filter(None, (record.remark,))),
        signals=signals,
        end=end,
    )


def _points(record: LogRecord, time: np.ndarray) -> np.ndarray | None:
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
