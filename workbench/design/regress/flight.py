"""The flight of a case, simulated from its scenario or read from a log.

A log lacks arrays, has them at different rates, and has gaps. So each metric states its inputs, and
`knowing` returns the flight where these are known, or raises the reason why they are not.
"""

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.design.flier import DIAGRAM, Flier
from workbench.design.linear_step import DecayTimes
from workbench.design.load_step import load_scenario
from workbench.design.lost import find_loss
from workbench.design.regress.signals import (
    AXIS_SIGNALS,
    POINT,
    USE,
    Signal,
    find_signal,
    sensor_signal,
)
from workbench.design.regress.spec import Case, Spec
from workbench.design.regress.verdict import Curve
from workbench.design.response_metrics import (
    LoadMetrics,
    ResponseMetrics,
    load_metrics,
    response_metrics,
    why_withheld,
)
from workbench.design.step_response import (
    EDGE,
    START_HEIGHT,
    axis_command,
    axis_velocity,
    step_scenario,
)
from workbench.design.step_responses import step_responses
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.loads import find_load
from workbench.scenario.scenario import Scenario, Start, at_own_period, check_scenario
from workbench.session.recording import Recording
from workbench.systems.sensors.samples import Samples

LONGEST_LAG = 0.75
"""Longest lag of a velocity behind its command [s]; the hover before a step is longer."""
LEAST_KNOWN, WHOLE = 0.8, 0.99
"""Smallest known share of the judged time for a metric, and the share from which on gaps are not
mentioned."""
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
"""Names of arrays of a recording in messages."""
SMALLEST = 0.1
"""Steps of the setpoint smaller than this share of the largest one are ignored."""
BEFORE = 1.0
"""Time before the edge in which the setpoint must be constant [s]."""
SLACK = 5e-3
"""Tolerance for a step logged before the span that begins with it [s]."""


@dataclass(frozen=True)
class Changes:
    """The changes of a run from its spec.

    Attributes:
        settings: parameter values that replace those of the spec and its cases.
        args: xacro arguments.
        variation: fields of the plant's variation, by name.
        seed: of noise and turbulence; None for that of the spec.
        physics_step: of the integration [s]; None for that of the spec.
        controller: name of a shipped one or path of a file; "" for that of the spec.
    """

    settings: Mapping[str, float] = field(default_factory=dict)
    args: Mapping[str, str] = field(default_factory=dict)
    variation: Mapping[str, float] = field(default_factory=dict)
    seed: int | None = None
    physics_step: float | None = None
    controller: str = ""

    @property
    def any(self) -> bool:
        """Whether there are any changes."""
        return self != Changes()

    @property
    def of_flights(self) -> list[str]:
        """The changes that apply to a flight but not to a log."""
        given = {
            "--set": bool(self.settings),
            "--vary": bool(self.variation),
            "--seed": self.seed is not None,
            "--physics-step": self.physics_step is not None,
        }
        return [option for option, is_given in given.items() if is_given]


class UnknownError(WorkbenchError):
    """A log lacks an input of a metric."""


class Followed(NamedTuple):
    """A setpoint and its response.

    Attributes:
        time: (N), from before the edge on [s].
        setpoint: (N).
        response: (N).
        longest: longest lag in the search [s].
    """

    time: np.ndarray
    setpoint: np.ndarray
    response: np.ndarray
    longest: float


@dataclass(frozen=True)
class Flight:
    """A flown case.

    Attributes:
        recording: all of it.
        edge: begin of the judged part [s].
        axis: of a step, else "".
        load: of a step of a load, else "".
        signal: the judged one.
        command: target change of the signal; None if not specified.
        trouble: why the flight was lost or broke off, else "".
        changed: whether the script changes parameters from the edge on.
        decay: time by which the transient of the step has decayed [s], 0 if unknown.
        samples: of the sensors, if a signal of the case needs them.
    """

    recording: Recording
    edge: float
    axis: str
    signal: str
    command: float | None
    trouble: str = ""
    changed: bool = False
    decay: float = 0.0
    load: str = ""
    samples: tuple[Samples, ...] = ()

    @property
    def parts(self) -> "Mapping[float, Flight]":
        """The judged steps by begin [s]: this one."""
        return {self.edge: self}

    @cached_property
    def judged(self) -> Recording:
        """The part from the edge on."""
        return self.recording.between(self.edge, np.inf)

    @cached_property
    def before(self) -> Recording:
        """The part up to the edge."""
        return self.recording.between(-np.inf, self.edge)

    @cached_property
    def time(self) -> np.ndarray:
        """Time from the edge on [s]."""
        return self.judged.time - self.edge

    def curve(self, name: str) -> Curve:
        """Return a signal of the judged part."""
        return Curve(self.time, self.find_signal(name).of(self.judged))

    @cached_property
    def followed(self) -> Followed:
        """Setpoint and response along the axis of the step, from the longest lag before it on."""
        whole = self.recording.between(self.edge - LONGEST_LAG, np.inf)
        until = axis_command(whole, self.axis)  # a sample has the command up to its time
        setpoint = np.append(until[1:], until[-1:])
        return Followed(whole.time, setpoint, axis_velocity(whole, self.axis), LONGEST_LAG)

    def knowing(self, names: Sequence[str]) -> "Flight":
        """Return the part of the flight where arrays or signals are known: all of it.

        Raises:
            UnknownError: if too little of them is known.
        """
        del names
        return self

    @cached_property
    def response(self) -> np.ndarray:
        """The judged signal; for a load or a script, relative to its value at the edge."""
        values = self.find_signal(self.signal).of(self.judged)
        return values if self.axis else values - values[0]

    def find_signal(self, name: str) -> Signal:
        """Return a signal of the recording or of a sensor.

        Raises:
            WorkbenchError: if there is none of that name.
        """
        return sensor_signal(name, self.samples) if POINT in name else find_signal(name)

    @cached_property
    def step(self) -> ResponseMetrics:
        """The metrics of the response to the command, even if it has not settled."""
        assert self.command is not None
        return response_metrics(self.time, self.response[None, :], self.command)

    @cached_property
    def loaded(self) -> LoadMetrics:
        """The metrics of the response to the load."""
        return load_metrics(self.time, self.response, changed=self.changed)

    @property
    def known(self) -> str:
        """Why only a part of the time is judged, else ""."""
        return ""

    @cached_property
    def doubt(self) -> str:
        """Why some metrics mean little, as a sentence, else "".

        They are marked, not withheld: a limit on such a number still detects a change.
        """
        if self.load:
            return self.loaded.withheld
        assert self.command is not None
        return why_withheld(
            self.step,
            float(self.time[-1]),
            self.command,
            decay=self.decay,
            changed=self.changed,
        )


def changed(spec: Spec, changes: Changes) -> Scenario:
    """Return the common part of all flights of a spec, with the changes of a run."""
    content = spec.content
    scenario = Scenario(
        vehicle=copy.deepcopy(content.vehicle),
        controller=content.controller,
        estimator=content.estimator,
        world=content.world,
        sensors=copy.deepcopy(content.sensors),
        rates=copy.deepcopy(content.rates),
    )
    scenario.vehicle.args |= dict(changes.args)
    if changes.variation:
        fields: dict[str, Any] = dict(changes.variation)
        variation = dataclasses.replace(scenario.vehicle.variation, **fields)
        variation.check()
        scenario.vehicle.variation = variation
    if changes.seed is not None:
        scenario.sensors.seed = changes.seed
    if changes.physics_step is not None:
        scenario.rates.physics_step = changes.physics_step
        check_scenario(scenario)  # once instead of for each case
    return at_own_period(scenario)


def case_scenario(case: Case, common: Scenario) -> Scenario:
    """Return the scenario of a case's flight."""
    if case.axis:
        assert case.amplitude is not None
        return step_scenario(case.axis, case.amplitude, case.duration, common)
    if case.load:
        assert case.amplitude is not None
        vehicle = configured_vehicle(common.vehicle)
        load = find_load(case.load)
        return load_scenario(load, case.amplitude, case.duration, common, vehicle, case.acts)
    scenario = copy.deepcopy(common)
    scenario.start = case.start or Start(position=[0.0, 0.0, START_HEIGHT])
    scenario.rates.record_period = scenario.rates.control_period
    scenario.duration = case.edge + case.duration
    scenario.script = copy.deepcopy(case.script)
    return scenario


def fly_case(case: Case, common: Scenario, settings: Mapping[str, float]) -> Flight:
    """Fly a case.

    Args:
        case: the case to fly.
        common: vehicle, world, sensors and rates.
        settings: parameter values that replace those of the case.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    scenario = case_scenario(case, common)
    of_sensors = [name for name in case.signals if POINT in name]
    scenario.sensors.keep |= bool(of_sensors)
    values = {**case.set, **settings}
    flier = Flier(scenario, values, DIAGRAM if of_sensors else "")
    for name in of_sensors:  # before a possibly long flight
        sensor_signal(name, flier.session.samples())
    broke_off = ""
    try:
        recording = flier.fly(programs=False).recording
    except FlightBrokenError as error:
        broke_off, recording = str(error), flier.session.recording()
    loss = find_loss(recording)
    return Flight(
        recording=recording,
        edge=EDGE if case.axis or case.load else case.edge,
        axis=case.axis,
        load=case.load,
        signal=case.signal or AXIS_SIGNALS.get(case.axis or case.load, ""),
        command=case.amplitude if case.axis else case.command,
        trouble=broke_off or (loss.sentence if loss else ""),
        changed=any(action.set and action.at >= case.edge for action in case.script),
        decay=DecayTimes(common).of(case.axis, values) if case.axis else 0.0,
        samples=flier.session.samples() if of_sensors else (),
    )


@dataclass(frozen=True)
class Trace:
    """A signal of a log at its own times.

    Attributes:
        unit: SI.
        time: rising (N) [s].
        values: (N).
        gaps: begin and end of times without measurements [s].
    """

    unit: str
    time: np.ndarray
    values: np.ndarray
    gaps: tuple[tuple[float, float], ...] = ()

    def between(self, begin: float, end: float) -> Curve:
        """Return the samples in a time span [s], relative to its begin."""
        part = (self.time >= begin - 1e-9) & (self.time <= end + 1e-9)
        return Curve(self.time[part] - begin, self.values[part])

    def known(self, begin: float, end: float) -> float:
        """Return the share of a time span [s] outside of gaps."""
        if not len(self.time) or not end > begin:
            return 0.0
        outside = ((begin, float(self.time[0])), (float(self.time[-1]), end))
        lost = [min(b, end) - max(a, begin) for a, b in {*self.gaps, *outside}]
        return max(0.0, 1.0 - sum(each for each in lost if each > 0.0) / (end - begin))


@dataclass(frozen=True)
class JudgedLog(Flight):
    """A flight from a log.

    Its recording has NaN for unknown values; `Flight.signal` is the response of the loop, or
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
        """The judged steps of the setpoint, by begin [s]."""
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
