"""A flight record as a log of the workbench, and back: what shows our own flights shows it then.

Each topic has a message a sample, of 64-bit numbers; what was not measured at that time is NaN. In
each gap there is a message with nothing but NaN, so that no curve is drawn across.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros_messages.definitions import SEPARATOR
from workbench.gateways.ros_messages.layout import ENCAPSULATION
from workbench.link.topics import PREFIX
from workbench.logs.contents import IMPORTED, VERSIONS
from workbench.logs.flight_record import FlightRecord, Signal
from workbench.logs.mcap_writer import McapWriter
from workbench.logs.record import LogRecord
from workbench.logs.series import ImportedTopic
from workbench.logs.versions import versions

_PACKAGE = "imported_msgs"
_PLACE = re.compile(r"\d+")


def log_of(flight: FlightRecord) -> LogRecord:
    """Return a flight as `read_log` would return it."""
    topics = _topics(flight)
    return LogRecord(
        path=flight.source,
        vehicle=flight.name,
        physics_step=0.0,
        versions={},
        scenario_text="",
        settings={},
        values={},
        definitions=(),
        topics={topic.short: topic for topic in topics},
        remark="; ".join(flight.remarks),
        imported=_about(flight),
    )


def write_flight(flight: FlightRecord, path: Path) -> None:
    """Write a flight as a log of the workbench; `flight_of` returns the same flight again.

    Raises:
        OSError: if the file cannot be written.
    """
    topics = _topics(flight)
    found = versions()
    writer = McapWriter(path, f"workbench {found['workbench']}")
    try:
        writer.add_metadata(VERSIONS, found)
        writer.attach(IMPORTED, "application/json", _about(flight).encode(), 0)
        channels = [
            (writer.add_channel(topic.name, writer.add_schema(topic.type, topic.schema), {}), topic)
            for topic in topics
        ]
        rows = [
            (t_ns, channel, message)
            for channel, topic in channels
            for t_ns, message in zip(topic.t_ns, topic.messages, strict=True)
        ]
        for t_ns, channel, message in sorted(rows, key=lambda row: row[:2]):
            writer.message(channel, t_ns, t_ns, message)
        writer.finish()
    except BaseException:
        writer.give_up()
        raise


def flight_of(record: LogRecord) -> FlightRecord:
    """Return the flight of a log that `write_flight` wrote.

    Raises:
        WorkbenchError: if what it says of its signals cannot be read.
    """
    series = {
        each.name: each for topic in record.topics.values() for each in topic.columns.values()
    }
    try:
        about = json.loads(record.imported)
        signals = {}
        for each in about["signals"]:
            found = series.get(each["name"])
            if found is None:  # its messages are in a part of the file that is damaged
                continue
            good = np.isfinite(found.values)
            signals[each["name"]] = Signal(
                each["name"],
                each["unit"],
                found.time[good],
                found.values[good],
                float(each["rate"]),
                each["delay"],
                tuple((float(begin), float(end)) for begin, end in each["gaps"]),
            )
        return FlightRecord(
            name=about["name"],
            source=record.path,
            format=about["format"],
            signals=signals,
            firmware=about["firmware"],
            parameters=about["parameters"],
            remarks=tuple(about["remarks"]),
            end=float(about["end"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise WorkbenchError(
            f"{record.path}: what it says of its signals is damaged: {error}"
        ) from error


def _about(flight: FlightRecord) -> str:
    """Return what the messages do not say, as JSON."""
    signals = [
        {
            "name": signal.name,
            "unit": signal.unit,
            "rate": signal.rate,
            "delay": signal.delay,
            "gaps": signal.gaps,
        }
        for signal in flight.signals.values()
    ]
    about = {
        "name": flight.name,
        "source": flight.source.name,
        "format": flight.format,
        "firmware": flight.firmware,
        "parameters": dict(flight.parameters),
        "remarks": flight.remarks,
        "end": flight.end,
        "signals": signals,
    }
    return json.dumps(about, indent=1)


def _topics(flight: FlightRecord) -> list[ImportedTopic]:
    """Return the topics of a flight's signals, with a message a sample."""
    grouped: dict[str, list[Signal]] = {}
    for signal in flight.signals.values():
        if len(signal.time):
            grouped.setdefault(signal.name.partition(".")[0], []).append(signal)
    return [_topic(name, signals) for name, signals in grouped.items()]


def _topic(name: str, signals: list[Signal]) -> ImportedTopic:
    kind = f"{_PACKAGE}/msg/{name.title().replace('_', '')}"
    tree: dict[str, Any] = {}
    for signal in signals:
        *way, last = signal.name.split(".")[1:]
        branch = tree
        for part in way:
            branch = branch.setdefault(part, {})
        branch[last] = signal
    texts: dict[str, str] = {}
    ordered: list[Signal | None] = []
    _define(kind, tree, texts, ordered)
    head, *rest = texts.items()
    schema = head[1] + "".join(
        f"{SEPARATOR}\nMSG: {each.replace('/msg/', '/')}\n{text}" for each, text in rest
    )
    t_ns, table = _table(ordered)
    data = np.ascontiguousarray(table, dtype="<f8").view(np.uint8).reshape(len(t_ns), -1)
    rows = [ENCAPSULATION + row.tobytes() for row in data]
    gaps = {signal.name: signal.gaps for signal in signals}
    return ImportedTopic(f"{PREFIX}{name}", name, kind, schema, t_ns.tolist(), rows, gaps)


def _define(
    kind: str, tree: Mapping[str, Any], texts: dict[str, str], ordered: list[Signal | None]
) -> None:
    """Add the definition of a tree's message and of what is in it, and its signals in order."""
    lines: list[str] = []
    texts[kind] = ""  # the outermost comes first
    for name, value in tree.items():
        if isinstance(value, Signal):
            lines.append(f"float64 {name} # [{value.unit}]")
            ordered.append(value)
        elif all(_PLACE.fullmatch(part) for part in value):
            count = 1 + max(map(int, value))
            unit = next(iter(value.values())).unit
            lines.append(f"float64[{count}] {name} # [{unit}]")
            ordered += [value.get(str(place)) for place in range(count)]
        else:
            inner = f"{kind}{name.title().replace('_', '')}"
            lines.append(f"{inner.replace('/msg/', '/')} {name}")
            _define(inner, value, texts, ordered)
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
