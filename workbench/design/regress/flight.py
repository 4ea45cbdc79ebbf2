"""Fly a case: its scenario, and the flight that came of it."""

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.design.load_metrics import LoadMetrics, load_metrics
from workbench.design.load_step import load_scenario
from workbench.design.lost import find_loss
from workbench.design.regress.band import Curve
from workbench.design.regress.signals import (
    AXIS_SIGNALS,
    POINT,
    Signal,
    find_signal,
    sensor_signal,
)
from workbench.design.regress.spec import Case, Spec
from workbench.design.response_metrics import ResponseMetrics, response_metrics, why_withheld
from workbench.design.step_response import (
    EDGE,
    START_HEIGHT,
    axis_command,
    axis_velocity,
    step_scenario,
)
from workbench.plant.loading import make_vehicle
from workbench.scenario.configured import read_configured
from workbench.scenario.loads import find_load
from workbench.scenario.scenario import Scenario, Start, at_own_period, check_scenario
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.sensors.samples import Samples

LONGEST_LAG = 0.75
"""Of a velocity behind its command [s]; the hover before a step is longer."""


@dataclass(frozen=True)
class Changes:
    """What a run has otherwise than its spec.

    Attributes:
        settings: parameter values, over those of the spec and its cases.
        args: xacro arguments.
        variation: fields of the plant's variation, by name.
        seed: of noise and turbulence; None leaves the spec's.
        physics_step: of the integration [s]; None leaves the spec's.
        controller: a shipped one's name or a file's path; "" leaves the spec's.
    """

    settings: Mapping[str, float] = field(default_factory=dict)
    args: Mapping[str, str] = field(default_factory=dict)
    variation: Mapping[str, float] = field(default_factory=dict)
    seed: int | None = None
    physics_step: float | None = None
    controller: str = ""

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return self != Changes()

    @property
    def of_flights(self) -> list[str]:
        """The options among them that change a flight, and cannot change a log."""
        given = {
            "--set": bool(self.settings),
            "--vary": bool(self.variation),
            "--seed": self.seed is not None,
            "--physics-step": self.physics_step is not None,
        }
        return [option for option, is_given in given.items() if is_given]


class UnknownError(WorkbenchError):
    """A log does not tell what a metric needs."""


class Followed(NamedTuple):
    """A set-point and its response.

    Attributes:
        time: (N), from before the edge on [s].
        setpoint: (N).
        response: (N).
        longest: lag that is looked for [s].
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
        edge: when the judged part begins [s].
        axis: of a step, else "".
        load: of a step of a load, else "".
        signal: that is judged.
        command: how far it should go; None where nothing is said of that.
        trouble: how the flight was lost or why it could not go on, else "".
        changed: whether the script changes parameters from the edge on.
        samples: what sensors delivered, if a signal of the case is theirs.
    """

    recording: Recording
    edge: float
    axis: str
    signal: str
    command: float | None
    trouble: str = ""
    changed: bool = False
    load: str = ""
    samples: tuple[Samples, ...] = ()

    @property
    def parts(self) -> "Mapping[float, Flight]":
        """The steps that are judged, by when they begin [s]: this one."""
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
        """Set-point and response of the step's axis, from so much before it as a lag may be."""
        whole = self.recording.between(self.edge - LONGEST_LAG, np.inf)
        until = axis_command(whole, self.axis)  # a sample has what was asked for until then
        setpoint = np.append(until[1:], until[-1:])
        return Followed(whole.time, setpoint, axis_velocity(whole, self.axis), LONGEST_LAG)

    def knowing(self, names: Sequence[str]) -> "Flight":
        """Return the flight where arrays of its recording, or signals, are known: all of it.

        Raises:
            UnknownError: where too little of them is known.
        """
        del names
        return self

    @cached_property
    def response(self) -> np.ndarray:
        """The judged signal; under a load and in a script, from where it was at the edge."""
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
        """The metrics of the response to the command, also of one that has not settled."""
        assert self.command is not None
        return response_metrics(self.time, self.response[None, :], self.command)

    @cached_property
    def loaded(self) -> LoadMetrics:
        """The metrics of the response to the load."""
        return load_metrics(self.time, self.response, changed=self.changed)

    @property
    def known(self) -> str:
        """Why what is judged is not all of the time, else ""."""
        return ""

    @cached_property
    def doubt(self) -> str:
        """Why some of them mean little, as a sentence; "" if they do not.

        They are marked and not withheld: a limit on such a number still tells that it has changed.
        """
        if self.load:
            return self.loaded.withheld
        assert self.command is not None
        duration = float(self.time[-1])
        return why_withheld(self.step, duration, self.command, changed=self.changed)


def changed(spec: Spec, changes: Changes) -> Scenario:
    """Return what all flights of a spec have in common, with the changes of a run."""
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
        check_scenario(scenario)  # once, and not for each case
    return at_own_period(scenario)


def case_scenario(case: Case, common: Scenario) -> Scenario:
    """Return the scenario of a case's flight."""
    if case.axis:
        assert case.amplitude is not None
        return step_scenario(case.axis, case.amplitude, case.duration, common)
    if case.load:
        assert case.amplitude is not None
        vehicle = make_vehicle(read_configured(common.vehicle))
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
        case: what to fly.
        common: vehicle, world, sensors and rates.
        settings: parameter values, over those of the case.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    scenario = case_scenario(case, common)
    of_sensors = [name for name in case.signals if POINT in name]
    scenario.sensors.keep |= bool(of_sensors)
    session = Session(scenario, {**case.set, **settings})
    for name in of_sensors:  # before the flight, which may be long
        sensor_signal(name, session.samples())
    broke_off = ""
    try:
        session.run()
    except FlightBrokenError as error:
        broke_off = str(error)
    recording = session.recording()
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
        samples=session.samples() if of_sensors else (),
    )
