"""A flight as measured: signals with the workbench's names, for every log format.

    from workbench.logs.flight_reader import read_flight

    flight = read_flight(Path("B2_circle_fast_rep1.csv.gz"))
    flight.remarks                              # what the reader found, cut off or assumed
    flight.names("imu")                         # what there is of a topic
    gyro = flight["imu.angular_velocity.x"]     # a Signal: time [s], values, unit, rate, gaps
    names = [f"motors.command_{i}" for i in (1, 2, 3, 4)]
    grid = flight.resample([*names, gyro.name], 0.01, bridge=0.05)
    grid.time, grid.values[:, 0], grid.known    # (m), (m, 5), (m, 5) whether it was measured

SI and radians; world axes W are east, north, up, body axes B forward, left, up. One clock: 0 is the
log's first sample. Names that a log may have; `workbench log LOG` lists those of one:

    position_data.x y z roll pitch yaw     true motion, as of motion capture: W
    velocity_data.v_x .. w_x ..            likewise, both in W
    attitude.q_w q_x q_y q_z w_x w_y w_z   likewise: B to W, and angular velocity in B
    estimate.x .. v_x .. roll .. q_w ..    what the flight computer took them for
    estimate.w_x .. a_x ..                 its angular velocity in B, its acceleration in W
    imu.linear_acceleration.x ..           specific force in B [m/s^2]
    imu.angular_velocity.x ..              gyro in B [rad/s]
    motors.command_1 ..                    share of the full command, 0 .. 1, in the log's order
    rotors.speed.0 ..                      [rad/s], in the same order
    battery.voltage, battery.current       under load [V], [A]
    setpoint.x y z yaw v_x v_y v_z         of the position and velocity loops: W
    attitude_setpoint.roll pitch yaw thrust   thrust as a share of the full one
    rate_setpoint.w_x w_y w_z              in B [rad/s]
    torque_setpoint.x y z                  share of the full torque, in B

Other signals keep the names of the log. Samples filled in by a logger and not measured are left
out; the gaps of the signal show where.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name

Span = tuple[float, float]
"""Begin and end [s]."""
SHARES, SPEED_COMMANDS, SPEEDS = "motors.command_", "rotors.speed_command.", "rotors.speed."
"""Prefixes of the names of motor signals: commands as shares of the full one, commands as speeds,
and rotor speeds."""
LOG_ENDINGS = (".mcap", ".ulg", ".bin", ".bbl", ".bfl", ".csv", ".gz")
"""Endings of log files in lower case; those of a Crazyflie have none."""
GAP = 2.5
"""Number of periods between two samples from which on there is a gap."""
MOST_POINTS = 50_000_000
"""Largest number of points of a grid, times its signals."""
LEAST = 2
"""Smallest number of samples of a signal with a rate."""


class Remark(str):
    """A sentence on a log, for programs with number and place.

    Attributes:
        number: of the samples that it is about; None if it is about the whole log.
        place: of the first one, such as "line 12, at 3.000 s"; "" if it is about the whole log.
    """

    __slots__ = ("number", "place")
    number: int | None
    place: str

    def __new__(cls, text: str, number: int | None = None, place: str = "") -> "Remark":
        """Return a sentence with its number and place."""
        remark = super().__new__(cls, text)
        remark.number, remark.place = number, place
        return remark


def spans(said: Iterable[Any]) -> tuple[Span, ...]:
    """Return spans read from JSON.

    Raises:
        TypeError, ValueError: if they are no pairs of numbers.
    """
    return tuple((float(begin), float(end)) for begin, end in said)


def _remark(said: Any) -> str:
    """Return a remark read from JSON; logs of earlier versions have plain sentences.

    Raises:
        KeyError, TypeError, ValueError: if it is invalid.
    """
    if isinstance(said, str):
        return said
    number = said["count"]
    return Remark(str(said["text"]), None if number is None else int(number), str(said["place"]))


def parts(beginning: str, each: Iterable[str] = "xyz") -> tuple[str, ...]:
    """Return the names of the signals of a vector: prefix, and name of the component."""
    return tuple(f"{beginning}{part}" for part in each)


STANDARD_UNITS = (
    (r"(position_data|estimate|setpoint)\.[xyz]", "m"),
    (r"(position_data|estimate|setpoint|attitude_setpoint)\.(roll|pitch|yaw)", "rad"),
    (r"(velocity_data|estimate|setpoint|command_velocity)\.v_[xyz]", "m/s"),
    (r"(velocity_data|attitude|estimate|rate_setpoint)\.w_[xyz]", "rad/s"),
    (r"(attitude|estimate|attitude_setpoint)\.q_[wxyz]", "1"),
    (r"estimate\.a_[xyz]|imu\.linear_acceleration\.[xyz]", "m/s^2"),
    (r"imu\.(angular_velocity|unfiltered)\.[xyz]|command_velocity\.yaw_rate", "rad/s"),
    (r"motors\.command_\d+|torque_setpoint\.[xyz]|attitude_setpoint\.thrust", "1"),
    (r"rotors\.speed(_command)?\.\d+", "rad/s"),
    (r"battery\.voltage", "V"),
    (r"battery\.current", "A"),
)
"""Patterns of the names of signals that all readers share, and their units."""


def standard_unit(name: str) -> str:
    """Return the unit of a signal that all readers share, "" for any other signal."""
    return next((unit for names, unit in STANDARD_UNITS if re.fullmatch(names, name)), "")


GYRO = parts("imu.angular_velocity.")
FORCE = parts("imu.linear_acceleration.")
ASKED = parts("setpoint.")
"""Names of gyro, accelerometer, and position setpoint."""


@dataclass(frozen=True, eq=False)
class Signal:
    """One number over time, or a text in the messages of a topic.

    Attributes:
        name: TOPIC.FIELD.
        unit: SI; 1 for none, "" if unknown.
        time: of the samples, increasing (n) [s].
        values: (n); NaN or "" if a message has no such field.
        rate: measured samples per second [Hz]; 0 if unknown.
        delay: of values in the log [s]; None if unknown.
        gaps: times without measurements, each from a sample to the next one, or from the last one
            to the end of the record; ordered.
    """

    name: str
    unit: str
    time: np.ndarray
    values: np.ndarray
    rate: float = 0.0
    delay: float | None = None
    gaps: tuple[Span, ...] = ()

    def at(self, time: np.ndarray, bridge: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return values (m) at increasing times (m) [s], and whether each is known (m).

        Between neighbouring samples they are interpolated linearly. In gaps longer than `bridge`
        [s], and before the first and after the last sample, they are NaN and not known.
        """
        if len(self.time) == 0:
            return np.full(len(time), np.nan), np.zeros(len(time), bool)
        slack = 1e-9
        known = (time >= self.time[0] - slack) & (time <= self.time[-1] + slack)
        for begin, end in self.gaps:
            if end - begin > bridge + slack:
                known &= (time <= begin + slack) | (time >= end - slack)
        values = np.interp(time, self.time, self.values)
        return np.where(known, values, np.nan), known & np.isfinite(values)


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
class FlightRecord:
    """A flight as it was measured.

    Attributes:
        name: of the flight, that of the file without ending.
        source: the file.
        format: of the log, such as "NanoBench CSV".
        firmware: name and version; "" if the log does not state it.
        parameters: of the firmware, and other data on the flight in the log, by name.
        remarks: on what the reader found, left out or assumed, a sentence each; those on samples
            are `Remark`s with number and place.
        signals: by their names.
        end: of the record [s].
        logs: lengths of all logs in its file, if there are several [s]; 0 for one without data.
    """

    name: str
    source: Path
    format: str
    signals: Mapping[str, Signal]
    firmware: str = ""
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    end: float = 0.0
    logs: tuple[float, ...] = ()

    def __getitem__(self, name: str) -> Signal:
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
            "signals": [
                {
                    "name": each.name,
                    "unit": each.unit,
                    "rate": each.rate,
                    "delay": each.delay,
                    "gaps": each.gaps,
                }
                for each in self.signals.values()
            ],
        }

    def remark_details(self) -> list[dict[str, Any]]:
        """Return the remarks with number and place, in JSON types."""
        return [
            {"text": str(each), "count": each.number, "place": each.place}
            for each in (
                each if isinstance(each, Remark) else Remark(each) for each in self.remarks
            )
        ]

    @classmethod
    def from_description(
        cls,
        said: Mapping[str, Any],
        source: Path,
        samples: Mapping[str, tuple[np.ndarray, np.ndarray]],
    ) -> "FlightRecord":
        """Return the record from its description.

        Args:
            said: by `described`.
            source: the file.
            samples: time and values of the signals, by name; a signal without samples is left out.

        Raises:
            KeyError, TypeError, ValueError, ArithmeticError, AttributeError: if the description is
                invalid.
        """
        signals = {
            each["name"]: Signal(
                str(each["name"]),
                str(each["unit"]),
                *samples[each["name"]],
                float(each["rate"]),
                None if each["delay"] is None else float(each["delay"]),
                spans(each["gaps"]),
            )
            for each in said["signals"]
            if each["name"] in samples
        }
        return cls(
            name=str(said["name"]),
            source=source,
            format=str(said["format"]),
            signals=signals,
            firmware=str(said["firmware"]),
            parameters={
                str(name): value if isinstance(value, int | float) else str(value)
                for name, value in said["parameters"].items()
            },
            remarks=tuple(map(_remark, said.get("remark_details", said["remarks"]))),
            end=float(said["end"]),
            logs=tuple(map(float, said.get("logs", ()))),
        )

    def names(self, topic: str = "") -> list[str]:
        """Return the names of signals: all, or those of a topic or of the components of a field."""
        return [name for name in self.signals if not topic or name.startswith(f"{topic}.")]

    def motors(self, *kinds: str) -> list[str]:
        """Return the signals of the motors in order, of the first kind that the log has.

        Args:
            kinds: from `SHARES`, `SPEED_COMMANDS` and `SPEEDS`.
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
        if (end - begin) / period * len(names) > MOST_POINTS:
            raise WorkbenchError(
                f"{self.source}: {end - begin:.4g} s every {period:.2g} s are too many samples"
            )
        time = begin + period * np.arange(int((end - begin) / period + 1e-6) + 1)
        found = [signal.at(time, bridge) for signal in signals]
        values, known = (np.column_stack(parts) for parts in zip(*found, strict=True))
        return Grid(tuple(names), time, values, known)


def make_signal(
    name: str,
    unit: str,
    time: np.ndarray,
    values: np.ndarray,
    *,
    end: float | None = None,
    rate: float | None = None,
    delay: float | None = None,
    breaks: Iterable[Span] = (),
) -> Signal:
    """Return a signal, with the rate and gaps of its times.

    Samples that are not numbers, or without a time, are left out. A gap is where two samples are
    `GAP` periods or more apart, the period being the median, or where the clock started again.

    Args:
        name: TOPIC.FIELD.
        unit: SI.
        time: (n) [s], see `readers.clock.read_clock`; where it does not increase, samples are left
            out.
        values: (n).
        end: of the record [s]; a signal that ends earlier has a gap up to it.
        rate: of the signal, if it is not that of the times [Hz].
        delay: of the signal [s].
        breaks: times around restarts of the clock [s].
    """
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    good = np.isfinite(values) & np.isfinite(time)
    time, values = time[good], values[good]
    rising = np.ones(len(time), dtype=bool)
    rising[1:] = time[1:] > np.maximum.accumulate(time)[:-1]
    time, values = time[rising], values[rising]
    if len(time) < LEAST:
        gap = ((float(time[-1]), end),) if len(time) and end is not None and end > time[-1] else ()
        return Signal(name, unit, time, values, rate or 0.0, delay, gap)
    steps = np.diff(time)
    period = float(np.median(steps))
    wide = steps >= GAP * period
    for before, after in breaks:
        last = int(np.searchsorted(time, 0.5 * (before + after))) - 1
        if 0 <= last < len(wide):
            wide[last] = True
    gaps = [(float(time[i]), float(time[i + 1])) for i in np.nonzero(wide)[0]]
    if end is not None and end - time[-1] >= GAP * period:
        gaps.append((float(time[-1]), end))
    return Signal(name, unit, time, values, rate or 1.0 / period, delay, tuple(gaps))
