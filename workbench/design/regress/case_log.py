"""The log of the flight of a case, compared with what the case records."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from workbench.common.series import Series
from workbench.design.regress.flight import CaseFlight, Followed, MissingInputError
from workbench.design.regress.signals import (
    ROTOR_USE_INPUT,
    SENSOR_SEPARATOR,
    RecordedSignal,
    find_signal,
)
from workbench.design.step_responses import step_responses
from workbench.session.recording import Recording

MIN_KNOWN_SHARE, GAPLESS_SHARE = 0.8, 0.99
"""Smallest known share of the judged time for a metric, and the share from which on gaps are not
mentioned."""
ARRAY_WORDS = {
    "p_WB": "the position",
    "q_WB": "the attitude",
    "v_WB": "the velocity",
    "w_WB": "the angular velocity",
    "vdot_WB": "the acceleration",
    "thrusts": "the rotors' speeds",
    "rotor_speeds": "the rotors' speeds",
    "commanded_speeds": "the motors' commands",
    ROTOR_USE_INPUT: "the rotors' use",
}
"""Names of arrays of a recording in messages."""
MIN_STEP_SHARE = 0.1
"""Steps of the setpoint smaller than this share of the largest one are ignored."""
STEADY_BEFORE_EDGE_S = 1.0
"""Time before the edge in which the setpoint must be constant [s]."""
EDGE_SLACK_S = 5e-3
"""Tolerance for a step logged before the span that begins with it [s]."""


@dataclass(frozen=True)
class JudgedLog(CaseFlight):
    """A flight from a log.

    Its recording has NaN for unknown values; `CaseFlight.signal` is the response of the loop, or
    another signal of the log.

    Attributes:
        end: of the judged part [s].
        traces: signals of the log named in the case, and those of its loop.
        loop: names of setpoint and response; empty if no loop is judged.
        longest: longest lag in the search [s].
        missing: why inputs of metrics are missing, by array of the recording or signal.
        measured: numbers from the step response of the loop over the whole flight, by metric.
        level: setpoint before the judged step.
        known: why only a part of the time is judged, else "".
        skip: whether to skip limits on metrics that the log cannot provide.
        absent: why there is no log, else "".
    """

    end: float = 0.0
    traces: Mapping[str, Series] = field(default_factory=dict)
    loop: tuple[str, ...] = ()
    longest: float = 0.0
    missing: Mapping[str, str] = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)
    level: float = 0.0
    known: str = ""
    skip: bool = False
    absent: str = ""

    @cached_property
    def parts(self) -> Mapping[float, CaseFlight]:
        """The judged steps of the setpoint, by begin [s]."""
        setpoint, response = (self.traces[name] for name in self.loop)
        early = self.edge - STEADY_BEFORE_EDGE_S
        asked, flown = (each.between(early, self.end).since(early) for each in (setpoint, response))
        found = step_responses((asked.time, asked.values), (flown.time, flown.values))
        found = [each for each in found if each.begin >= STEADY_BEFORE_EDGE_S - EDGE_SLACK_S]
        largest = max((abs(each.amplitude) for each in found), default=0.0)
        parts: dict[float, CaseFlight] = {}
        for each in found:
            begin = early + each.begin
            if abs(each.amplitude) >= MIN_STEP_SHARE * largest:
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

    def curve(self, name: str) -> Series:
        if SENSOR_SEPARATOR in name:
            return self.traces[name].between(self.edge, self.end).since(self.edge)
        row = find_signal(name)
        judged = self.knowing(row.reads).judged
        return Series(name, row.unit, judged.time - self.edge, row.of(judged))

    @cached_property
    def followed(self) -> Followed:
        setpoint, response = (self.traces[name] for name in self.loop)
        begin = max(self.edge - self.longest, setpoint.time[0], response.time[0])
        time = response.between(begin, self.end).time
        for a, b in (*setpoint.gaps, *response.gaps):
            time = time[(time <= a) | (time >= b)]
        asked, flown = (np.interp(time, each.time, each.values) for each in (setpoint, response))
        return Followed(time, asked, flown, self.longest)

    def find_signal(self, name: str) -> RecordedSignal:
        if SENSOR_SEPARATOR not in name:
            return find_signal(name)
        trace = self.traces[name]
        return RecordedSignal(name, trace.unit, lambda _: self.curve(name).values, (name,))

    def knowing(self, names: Sequence[str]) -> "JudgedLog":
        rows = np.ones(len(self.recording.time), dtype=bool)
        time = self.recording.time
        inside = (time >= self.edge - 1e-9) & (time <= self.end + 1e-9)
        shares = {}
        for name in names:
            if name in self.missing:
                raise MissingInputError(self.missing[name])
            if name in self.traces:
                shares[name] = self.traces[name].known_share(self.edge, self.end)
            elif name not in self.measured:
                array = getattr(self.recording, "rotor_speeds" if name == ROTOR_USE_INPUT else name)
                finite = np.isfinite(array.reshape(len(rows), -1)).all(axis=1)
                shares[ARRAY_WORDS[name]] = float(finite[inside].mean()) if inside.any() else 0.0
                rows &= finite
        what, share = min(shares.items(), key=lambda each: each[1], default=("", 1.0))
        said = (
            f"the log has {what} for {100.0 * share:.0f} % of {self.edge:.4g} .. {self.end:.4g} s"
        )
        if share < MIN_KNOWN_SHARE:
            raise MissingInputError(
                f"{said}, and {100.0 * MIN_KNOWN_SHARE:.0f} % are needed: name a span without gaps"
            )
        known = said if share < GAPLESS_SHARE else ""
        return dataclasses.replace(self, recording=self.recording.only(rows), known=known)
