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
LATEST = 1e7
"""Latest time in a log [s], a third of a year; a later one is a damaged number."""
MOST_POINTS = 50_000_000
"""Largest number of points of a grid, times its signals."""
LEAST = 2
"""Smallest number of samples of a signal with a rate."""


def parts(beginning: str, each: Iterable[str] = "xyz") -> tuple[str, ...]:
    """Return the names of the signals of a vector: prefix, and name of the component."""
    return tuple(f"{beginning}{part}" for part in each)


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
        remarks: on what the reader found, left out or assumed, a sentence each.
        signals: by their names.
        end: of the record [s].
    """

    name: str
    source: Path
    format: str
    signals: Mapping[str, Signal]
    firmware: str = ""
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    end: float = 0.0

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
            "remarks": list(self.remarks),
            "end": self.end,
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
            KeyError, TypeError, ValueError: if the description is invalid.
        """
        signals = {
            each["name"]: Signal(
                each["name"],
                each["unit"],
                *samples[each["name"]],
                float(each["rate"]),
                each["delay"],
                tuple((float(begin), float(end)) for begin, end in each["gaps"]),
            )
            for each in said["signals"]
            if each["name"] in samples
        }
        return cls(
            name=said["name"],
            source=source,
            format=said["format"],
            signals=signals,
            firmware=said["firmware"],
            parameters=said["parameters"],
            remarks=tuple(said["remarks"]),
            end=float(said["end"]),
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


def rising_rows(time: np.ndarray) -> np.ndarray:
    """Return which of finite times (n) [s] are valid: increasing, up to `LATEST`.

    If a single time jumps ahead of those that follow, only that one is left out.
    """
    good = time <= LATEST
    if len(time) > 2:
        ahead = (time[1:-1] >= time[2:]) & (time[2:] > time[:-2])
        good[1:-1] &= ~ahead
    latest = np.maximum.accumulate(np.where(good, time, -np.inf))
    good[1:] &= time[1:] > latest[:-1]
    return np.asarray(good)


def make_signal(
    name: str,
    unit: str,
    time: np.ndarray,
    values: np.ndarray,
    *,
    end: float | None = None,
    rate: float | None = None,
    delay: float | None = None,
) -> Signal:
    """Return a signal, with the rate and gaps of its times.

    Samples that are not numbers, or at times that do not increase, are left out. A gap is where two
    samples are `GAP` periods or more apart; the period is the median.

    Args:
        name: TOPIC.FIELD.
        unit: SI.
        time: (n) [s].
        values: (n).
        end: of the record [s]; a signal that ends earlier has a gap up to it.
        rate: of the signal, if it is not that of the times [Hz].
        delay: of the signal [s].
    """
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    good = np.isfinite(values) & np.isfinite(time)
    time, values = time[good], values[good]
    rising = rising_rows(time)
    time, values = time[rising], values[rising]
    if len(time) < LEAST:
        gap = ((float(time[-1]), end),) if len(time) and end is not None and end > time[-1] else ()
        return Signal(name, unit, time, values, rate or 0.0, delay, gap)
    steps = np.diff(time)
    period = float(np.median(steps))
    gaps = [(float(time[i]), float(time[i + 1])) for i in np.nonzero(steps >= GAP * period)[0]]
    if end is not None and end - time[-1] >= GAP * period:
        gaps.append((float(time[-1]), end))
    return Signal(name, unit, time, values, rate or 1.0 / period, delay, tuple(gaps))
