"""A flight out of a log, judged as one that was flown for its spec.

A log lacks arrays, has them at rates of their own, and has gaps. So each metric says what it reads,
and `knowing` returns the flight where that is known, or says why the log cannot tell.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from workbench.design.regress.band import Curve
from workbench.design.regress.flight import Flight, Followed, UnknownError
from workbench.design.regress.signals import POINT, USE, Signal, find_signal
from workbench.design.step_responses import step_responses
from workbench.session.recording import Recording

LEAST_KNOWN, WHOLE = 0.8, 0.99
"""Shares of the judged time, of which a metric's signals must be known, and from which on nothing
is said of the rest."""
WORDS = {
    "p_WB": "the position",
    "q_WB": "the attitude",
    "v_WB": "the velocity",
    "w_WB": "the angular velocity",
    "vdot_WB": "the acceleration",
    "thrusts": "the rotors' speeds",
    "rotor_speeds": "the rotors' speeds",
    "commanded_speeds": "the motors' commands",
    USE: "the rotors' use",
}
"""What arrays of a recording are called."""
SMALLEST = 0.1
"""Steps of the set-point that are smaller than this share of the largest one are none."""
BEFORE = 1.0
"""So much before the edge tells whether the set-point stood still there [s]."""
SLACK = 5e-3
"""By which a step may be logged before the span that begins with it [s]."""


@dataclass(frozen=True)
class Trace:
    """A signal of a log, at its own times.

    Attributes:
        unit: SI.
        time: rising (N) [s].
        values: (N).
        gaps: where nothing was measured, from and to [s].
    """

    unit: str
    time: np.ndarray
    values: np.ndarray
    gaps: tuple[tuple[float, float], ...] = ()

    def between(self, begin: float, end: float) -> Curve:
        """Return the samples of a part of the time [s], from its begin on."""
        part = (self.time >= begin - 1e-9) & (self.time <= end + 1e-9)
        return Curve(self.time[part] - begin, self.values[part])

    def known(self, begin: float, end: float) -> float:
        """Return the share of a part of the time that no gap is in [s]."""
        if not len(self.time) or not end > begin:
            return 0.0
        outside = ((begin, float(self.time[0])), (float(self.time[-1]), end))
        lost = [min(b, end) - max(a, begin) for a, b in {*self.gaps, *outside}]
        return max(0.0, 1.0 - sum(each for each in lost if each > 0.0) / (end - begin))


@dataclass(frozen=True)
class JudgedLog(Flight):
    """A flight out of a log.

    Its recording has NaN where the log does not tell; `Flight.signal` is the response of the loop,
    or another signal of the log.

    Attributes:
        end: of the judged part [s].
        traces: the signals of the log that the case names, and those of its loop.
        loop: names of set-point and response; empty where none is judged.
        longest: lag that is looked for [s].
        missing: why the log has not what metrics read, by array of the recording or signal.
        measured: numbers of the loop's step response out of all of the flight, by metric.
        level: set-point before the step that is judged.
        known: why what is judged is not all of the time, else "".
        skip: whether a limit is skipped whose metric the log cannot give.
        absent: why there is no log at all, else "".
    """

    end: float = 0.0
    traces: Mapping[str, Trace] = field(default_factory=dict)
    loop: tuple[str, ...] = ()
    longest: float = 0.0
    missing: Mapping[str, str] = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)
    level: float = 0.0
    known: str = ""
    skip: bool = False
    absent: str = ""

    @cached_property
    def parts(self) -> Mapping[float, Flight]:
        """The steps of the set-point that are judged, by when they begin [s]."""
        setpoint, response = (self.traces[name] for name in self.loop)
        early = self.edge - BEFORE
        asked, flown = setpoint.between(early, self.end), response.between(early, self.end)
        found = step_responses((asked.time, asked.values), (flown.time, flown.values))
        found = [each for each in found if each.begin >= BEFORE - SLACK]
        largest = max((abs(each.amplitude) for each in found), default=0.0)
        parts: dict[float, Flight] = {}
        for each in found:
            begin = early + each.begin
            if abs(each.amplitude) >= SMALLEST * largest:
                parts[begin] = dataclasses.replace(
                    self,
                    edge=begin,
                    end=begin + float(each.time[-1]),
                    command=each.amplitude,
                    level=float(asked.values[np.searchsorted(asked.time, each.begin) - 1]),
                )
        return parts

    @cached_property
    def judged(self) -> Recording:
        return self.recording.between(self.edge, self.end)

    @cached_property
    def time(self) -> np.ndarray:
        return self.curve(self.signal).time if self.signal else super().time

    @cached_property
    def response(self) -> np.ndarray:
        return self.curve(self.signal).values - self.level

    def curve(self, name: str) -> Curve:
        if POINT in name:
            return self.traces[name].between(self.edge, self.end)
        known = self.knowing(find_signal(name).reads)
        return Curve(known.judged.time - self.edge, find_signal(name).of(known.judged))

    @cached_property
    def followed(self) -> Followed:
        setpoint, response = (self.traces[name] for name in self.loop)
        begin = max(self.edge - self.longest, setpoint.time[0], response.time[0])
        inside = response.between(begin, self.end)
        time = inside.time + begin
        for a, b in (*setpoint.gaps, *response.gaps):
            time = time[(time <= a) | (time >= b)]
        asked, flown = (np.interp(time, each.time, each.values) for each in (setpoint, response))
        return Followed(time, asked, flown, self.longest)

    def find_signal(self, name: str) -> Signal:
        if POINT not in name:
            return find_signal(name)
        trace = self.traces[name]
        return Signal(name, trace.unit, lambda _: self.curve(name).values, (name,))

    def knowing(self, names: Sequence[str]) -> "JudgedLog":
        rows = np.ones(len(self.recording.time), dtype=bool)
        time = self.recording.time
        inside = (time >= self.edge - 1e-9) & (time <= self.end + 1e-9)
        shares = {}
        for name in names:
            if name in self.missing:
                raise UnknownError(self.missing[name])
            if name in self.traces:
                shares[name] = self.traces[name].known(self.edge, self.end)
            elif name not in self.measured:
                array = getattr(self.recording, "rotor_speeds" if name == USE else name)
                finite = np.isfinite(array.reshape(len(rows), -1)).all(axis=1)
                shares[WORDS[name]] = float(finite[inside].mean()) if inside.any() else 0.0
                rows &= finite
        what, share = min(shares.items(), key=lambda each: each[1], default=("", 1.0))
        said = (
            f"the log has {what} for {100.0 * share:.0f} % of {self.edge:.4g} .. {self.end:.4g} s"
        )
        if share < LEAST_KNOWN:
            raise UnknownError(
                f"{said}, and {100.0 * LEAST_KNOWN:.0f} % are needed: name a span without gaps"
            )
        known = said if share < WHOLE else ""
        return dataclasses.replace(self, recording=_rows(self.recording, rows), known=known)


def _rows(recording: Recording, rows: np.ndarray) -> Recording:
    if rows.all():
        return recording
    arrays = {
        each.name: getattr(recording, each.name)
        for each in dataclasses.fields(Recording)
        if each.name != "vehicle"
    }
    kept = {name: each[rows] if len(each) else each for name, each in arrays.items()}
    return Recording(vehicle=recording.vehicle, **kept)
