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
from workbench.common.series import Series
from workbench.design.flier import DIAGRAM, Flier
from workbench.design.flown_step import axis_velocity
from workbench.design.linear_step import DecayTimes
from workbench.design.load_metrics import LoadMetrics, load_metrics
from workbench.design.load_step import load_step_scenario
from workbench.design.lost import find_loss
from workbench.design.regress.signals import (
    AXIS_SIGNALS,
    SENSOR_SEPARATOR,
    RecordedSignal,
    find_signal,
    is_part_signal,
    part_signal,
    sensor_signal,
)
from workbench.design.regress.spec import Spec, SpecCase
from workbench.design.step_metrics import StepMetrics, step_info, why_withheld
from workbench.design.step_response import (
    STEP_EDGE_S,
    STEP_START_HEIGHT_M,
    axis_command,
    step_scenario,
)
from workbench.scenario.loads import find_load
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.scenario.scenario_check import check_scenario
from workbench.session.recording import Recording
from workbench.setup import Setup
from workbench.systems.sensors.samples import RecordedSamples

MAX_COMMAND_LAG_S = 0.75
"""Longest lag of a velocity behind its command [s]; the hover before a step is longer."""


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


class MissingInputError(WorkbenchError):
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
class CaseFlight:
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
    samples: tuple[RecordedSamples, ...] = ()

    @property
    def parts(self) -> "Mapping[float, CaseFlight]":
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

    def curve(self, name: str) -> Series:
        """Return a signal of the judged part, from the edge on."""
        row = self.find_signal(name)
        return Series(name, row.unit, self.time, row.of(self.judged))

    @cached_property
    def followed(self) -> Followed:
        """Setpoint and response along the axis of the step, from the longest lag before it on."""
        whole = self.recording.between(self.edge - MAX_COMMAND_LAG_S, np.inf)
        until = axis_command(whole, self.axis)  # a sample has the command up to its time
        setpoint = np.append(until[1:], until[-1:])
        return Followed(whole.time, setpoint, axis_velocity(whole, self.axis), MAX_COMMAND_LAG_S)

    def knowing(self, names: Sequence[str]) -> "CaseFlight":
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

    def find_signal(self, name: str) -> RecordedSignal:
        """Return a signal of the recording, of a part of the vehicle or of a sensor.

        Raises:
            WorkbenchError: if there is none of that name.
        """
        if is_part_signal(name):
            return part_signal(name, self.recording.vehicle)
        return sensor_signal(name, self.samples) if SENSOR_SEPARATOR in name else find_signal(name)

    @cached_property
    def step(self) -> StepMetrics:
        """The metrics of the response to the command, even if it has not settled."""
        assert self.command is not None
        return step_info(self.time, self.response, self.command)

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
            self.time,
            self.response,
            self.command,
            decay=self.decay,
            changed=self.changed,
        )


def changed_scenario(spec: Spec, changes: Changes) -> Scenario:
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
    return scenario


def case_scenario(case: SpecCase, setup: Setup) -> Scenario:
    """Return the scenario of a case's flight, with the common part of all flights of its spec."""
    common = setup.scenario
    if case.axis:
        assert case.amplitude is not None
        return step_scenario(case.axis, case.amplitude, case.duration, common)
    if case.load:
        assert case.amplitude is not None
        return load_step_scenario(
            find_load(case.load), case.amplitude, case.duration, common, setup.vehicle, case.acts
        )
    scenario = copy.deepcopy(common)
    scenario.start = case.start or ScenarioStart(position=[0.0, 0.0, STEP_START_HEIGHT_M])
    scenario.rates.record_period = scenario.rates.control_period
    scenario.duration = case.edge + case.duration
    scenario.script = copy.deepcopy(case.script)
    return scenario


def fly_case(case: SpecCase, setup: Setup) -> CaseFlight:
    """Fly a case.

    Args:
        case: the case to fly.
        setup: vehicle, world, sensors and rates; its settings replace those of the case.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    setup = setup.with_settings({**case.set, **setup.settings})
    scenario = case_scenario(case, setup)
    named = [name for name in case.signals if SENSOR_SEPARATOR in name]
    of_sensors = [name for name in named if not is_part_signal(name)]
    for name in set(named).difference(of_sensors):  # before a possibly long flight
        part_signal(name, setup.vehicle)
    scenario.sensors.keep |= bool(of_sensors)
    flier = Flier(setup.with_scenario(scenario), fly_on=DIAGRAM if of_sensors else "")
    for name in of_sensors:  # before a possibly long flight
        sensor_signal(name, flier.session.samples())
    broke_off = ""
    try:
        recording = flier.fly(programs=False).recording
    except FlightBrokenError as error:
        broke_off, recording = str(error), flier.session.recording()
    loss = find_loss(recording)
    return CaseFlight(
        recording=recording,
        edge=STEP_EDGE_S if case.axis or case.load else case.edge,
        axis=case.axis,
        load=case.load,
        signal=case.signal or AXIS_SIGNALS.get(case.axis or case.load, ""),
        command=case.amplitude if case.axis else case.command,
        trouble=broke_off or (loss.sentence if loss else ""),
        changed=any(action.set and action.at >= case.edge for action in case.script),
        decay=DecayTimes(setup).of(case.axis) if case.axis else 0.0,
        samples=flier.session.samples() if of_sensors else (),
    )
