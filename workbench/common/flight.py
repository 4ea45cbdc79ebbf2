"""A flight: its signals by name, whoever flew it and in whichever format it was logged.

    from workbench import read_flight

    flight = read_flight(Path("B2_circle_fast_rep1.csv.gz"))
    flight.remarks                              # what the reader found, cut off or assumed
    flight.names("imu")                         # what there is of a topic
    gyro = flight["imu.angular_velocity.x"]     # a Series: time [s], values, unit, rate, gaps
    names = [f"motors.command_{i}" for i in (1, 2, 3, 4)]
    grid = flight.resample([*names, gyro.name], 0.01, bridge=0.05)
    grid.time, grid.values[:, 0], grid.known    # (m), (m, 5), (m, 5) whether it was measured

SI and radians; world axes W are east, north, up, body axes B forward, left, up. One clock: 0 is the
log's first sample. `logs.logged_signal` has the names of signals.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.series import Series, Span, TimedValues, spans

MAX_LOG_TIME_S = 1e7
"""Latest time in a log [s], a third of a year; a later one is a damaged number."""
MAX_GRID_POINTS = 50_000_000
"""Largest number of points of a grid, times its signals."""


class LogRemark(str):
    """A sentence on a log, for programs with number and place.

    Attributes:
        number: of the samples that it is about; None if it is about the whole log.
        place: of the first one, such as "line 12, at 3.000 s"; "" if it is about the whole log.
    """

    __slots__ = ("number", "place")
    number: int | None
    place: str

    def __new__(cls, text: str, number: int | None = None, place: str = "") -> "LogRemark":
        """Return a sentence with its number and place."""
        remark = super().__new__(cls, text)
        remark.number, remark.place = number, place
        return remark


def _remark_from_json(said: Any) -> str:
    """Return a remark read from JSON; logs of earlier versions have plain sentences.

    Raises:
        KeyError, TypeError, ValueError: if it is invalid.
    """
    if isinstance(said, str):
        return said
    number = said["count"]
    return LogRemark(str(said["text"]), None if number is None else int(number), str(said["place"]))


@dataclass(frozen=True, eq=False)
class Grid:
    """Signals at common times.

    Attributes:
        names: of the signals (k).
        time: evenly spaced (m) [s].
        values: (m, k); NaN where unknown.
        known: (m, k).
    """

    names: tuple[str, ...]
    time: np.ndarray
    values: np.ndarray
    known: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values of a signal (m)."""
        return np.asarray(self.values[:, self.names.index(name)])

    @property
    def whole(self) -> np.ndarray:
        """Whether all signals are known (m)."""
        return np.asarray(self.known.all(axis=1))


@dataclass(frozen=True, eq=False)
class Flight:
    """A flight: its signals, and where they come from.

    Attributes:
        name: of the flight, that of the file without ending.
        source: the file.
        format: of the log, such as "NanoBench CSV".
        firmware: name and version; "" if the log does not state it.
        parameters: of the firmware, and other data on the flight in the log, by name.
        remarks: on what the reader found, left out or assumed, a sentence each; one on samples
            is a `LogRemark` with number and place.
        signals: by their names.
        end: of the record [s].
        logs: lengths of all logs in its file, if there are several [s]; 0 for one without data.
        clock_start: what the log's own clock shows at time 0 [s]: since boot, or since 1970 in UTC.
    """

    name: str
    source: Path
    format: str
    signals: Mapping[str, Series]
    firmware: str = ""
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    end: float = 0.0
    logs: tuple[float, ...] = ()
    clock_start: float = 0.0

    def __getitem__(self, name: str) -> Series:
        """Return a signal.

        Raises:
            WorkbenchError: if there is none with that name; it suggests similar ones.
        """
        if name not in self.signals:
            raise unknown_name(f"signal of {self.source.name},", name, self.signals)
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        """Return whether there is a signal with a name."""
        return name in self.signals

    @cached_property
    def begin(self) -> float:
        """Time of the first sample [s]; not 0 if the record begins in flight."""
        firsts = (float(each.time[0]) for each in self.signals.values() if len(each.time))
        return min(firsts, default=0.0)

    @property
    def vehicle(self) -> str:
        """Name of the vehicle that flew; that of the flight if the log does not state it."""
        return str(self.parameters.get("vehicle", self.name))

    @property
    def remark(self) -> str:
        """All remarks; "" without one."""
        return "; ".join(self.remarks)

    @cached_property
    def sources(self) -> dict[str, str]:
        """What signals are called in the log of another program, by name."""
        return {name: each.source for name, each in self.signals.items() if each.source}

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of every signal, by name."""
        return {name: each.unit for name, each in self.signals.items()}

    def series(self, name: str, since: float = -np.inf) -> TimedValues:
        """Return times [s] and values of a signal from a time on (n): views.

        Raises:
            WorkbenchError: as `[]`.
        """
        found = self[name]
        first = int(np.searchsorted(found.time, since))
        return found.time[first:], found.values[first:]

    def several(self, name: str) -> list[Series]:
        """Return the signals of a TOPIC, of a TOPIC.FIELD, or of all components of a field.

        Raises:
            WorkbenchError: if there is none; it suggests similar names.
        """
        topic, _, path = name.partition(".")
        fields = {each.partition(".")[2]: each for each in self.names(topic)}
        if not fields:
            raise unknown_name("topic", topic, {each.partition(".")[0] for each in self.signals})
        found = [
            self.signals[full]
            for field, full in fields.items()
            if not path or field == path or field.startswith(f"{path}.")
        ]
        if not found:
            raise unknown_name(f"field of {topic},", path, fields)
        return found

    def between(self, begin: float, end: float) -> "Flight":
        """Return the flight with only the samples of a time span [s].

        Raises:
            WorkbenchError: if there are none.
        """
        parts = {name: each.between(begin, end) for name, each in self.signals.items()}
        kept = {name: each for name, each in parts.items() if len(each.time)}
        if not kept:
            raise WorkbenchError(f"{self.source}: has nothing between {begin:g} and {end:g} s")
        return replace(self, signals=kept, end=min(end, self.end))

    def described(self) -> dict[str, Any]:
        """Return everything except the samples in JSON types, for `from_description`."""
        return {
            "name": self.name,
            "source": self.source.name,
            "format": self.format,
            "firmware": self.firmware,
            "parameters": dict(self.parameters),
            "remarks": list(map(str, self.remarks)),
            "remark_details": self.remark_details(),
            "end": self.end,
            "logs": self.logs,
            "clock_start": self.clock_start,
            "signals": [
                {
                    "name": each.name,
                    "unit": each.unit,
                    "rate": each.rate,
                    "delay": each.delay,
                    "gaps": each.gaps,
                    **({"source": each.source} if each.source else {}),
                }
                for each in self.signals.values()
            ],
        }

    def remark_details(self) -> list[dict[str, Any]]:
        """Return the remarks with number and place, in JSON types."""
        return [
            {"text": str(each), "count": each.number, "place": each.place}
            for each in (
                each if isinstance(each, LogRemark) else LogRemark(each) for each in self.remarks
            )
        ]

    @classmethod
    def from_description(
        cls,
        said: Mapping[str, Any],
        source: Path | str,
        samples: Mapping[str, TimedValues],
    ) -> "Flight":
        """Return the flight from its description.

        Args:
            said: by `described`.
            source: the file.
            samples: time and values of the signals, by name; a signal without samples is left out.

        Raises:
            KeyError, TypeError, ValueError, ArithmeticError, AttributeError: if the description is
                invalid.
        """
        signals = {
            each["name"]: Series(
                str(each["name"]),
                str(each["unit"]),
                *samples[each["name"]],
                float(each["rate"]),
                None if each["delay"] is None else float(each["delay"]),
                spans(each["gaps"]),
                str(each.get("source", "")),
            )
            for each in said["signals"]
            if each["name"] in samples
        }
        return cls(
            name=str(said["name"]),
            source=Path(source),
            format=str(said["format"]),
            signals=signals,
            firmware=str(said["firmware"]),
            parameters={
                str(name): value if isinstance(value, int | float) else str(value)
                for name, value in said["parameters"].items()
            },
            remarks=tuple(map(_remark_from_json, said.get("remark_details", said["remarks"]))),
            end=float(said["end"]),
            logs=tuple(map(float, said.get("logs", ()))),
            clock_start=float(said.get("clock_start", 0.0)),
        )

    def names(self, topic: str = "") -> list[str]:
        """Return the names of signals: all, or those of a topic or of the components of a field."""
        return [name for name in self.signals if not topic or name.startswith(f"{topic}.")]

    def motors(self, *kinds: str) -> list[str]:
        """Return the signals of the motors in order, of the first kind that the log has.

        Args:
            kinds: from `MOTOR_COMMAND_PREFIX`, `SPEED_COMMAND_PREFIX` and `ROTOR_SPEED_PREFIX`.
        """
        for kind in kinds:
            numbers = (name.removeprefix(kind) for name in self.signals if name.startswith(kind))
            if found := sorted(int(number) for number in numbers if number.isdigit()):
                return [f"{kind}{number}" for number in found]
        return []

    def has(self, names: Iterable[str]) -> bool:
        """Return whether all of these signals exist."""
        return all(name in self.signals for name in names)

    def resample(
        self, names: Sequence[str], period: float, bridge: float = 0.0, span: Span | None = None
    ) -> Grid:
        """Return signals at common times, with flags where they are known.

        Nothing is filtered: low-pass a signal faster than the grid first, to avoid aliasing.

        Args:
            names: of the signals.
            period: of the grid [s].
            bridge: longest gap to interpolate across [s].
            span: begin and end; None for the common time of all signals [s].

        Raises:
            WorkbenchError: if a name is unknown, or the signals have no common time.
        """
        signals = [self[name] for name in names]
        if any(len(signal.time) == 0 for signal in signals):
            empty = next(signal.name for signal in signals if len(signal.time) == 0)
            raise WorkbenchError(f"{self.source}: {empty} has no measured sample")
        begin, end = span or (
            max(signal.time[0] for signal in signals),
            min(signal.time[-1] for signal in signals),
        )
        if period <= 0.0 or end < begin:
            raise WorkbenchError(f"{self.source}: {', '.join(names)} have no time in common")
        if (end - begin) / period * len(names) > MAX_GRID_POINTS:
            raise WorkbenchError(
                f"{self.source}: {end - begin:.4g} s every {period:.2g} s are too many samples"
            )
        time = begin + period * np.arange(int((end - begin) / period + 1e-6) + 1)
        found = [signal.at(time, bridge) for signal in signals]
        values, known = (np.column_stack(parts) for parts in zip(*found, strict=True))
        return Grid(tuple(names), time, values, known)
