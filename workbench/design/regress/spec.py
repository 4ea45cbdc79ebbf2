"""The content of a spec file, as typed dataclasses that define its schema."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.estimation.settings import TRUTH
from workbench.scenario.scenario import Action, Rates, ScenarioStart, VehicleConfig
from workbench.scenario.sensors_config import SensorsConfig

STATISTIC_SEPARATOR = " of "
"""Separator in the name of a metric between statistic and signal: `mean of imu.f_z`."""


@dataclass
class SpecLimit:
    """A smallest and a largest value; one of them may be missing."""

    min: float = -math.inf
    max: float = math.inf


@dataclass
class Tolerance:
    """The tolerance of a curve around its baseline.

    Attributes:
        absolute: in the unit of the signal.
        relative: as a share of the amplitude of the baseline, the largest distance from its first
            value; the larger of the two counts.
        time_shift: largest shift of the curve to earlier or later times [s].
    """

    absolute: float = 0.0
    relative: float = 0.0
    time_shift: float = 0.0


MISSING_FAIL, MISSING_SKIP = MISSING_CHOICES = ("fail", "skip")
"""Handling of limits on metrics that a log cannot provide, and of cases with a missing log."""


@dataclass
class LogConfig:
    """A log that replaces the flight of a case.

    Attributes:
        file: in any format that `workbench import` reads.
        mapping: file that names the columns of a CSV; "" if it is next to it, or not needed.
        number: of the log in a file with several, from 1; 0 for the longest one.
        order: for each rotor of the description the number of its motor in the log, from 1; empty
            for the order of the log.
        span: begin and end [s]; empty for the whole log.
        missing: `MISSING_FAIL` or `MISSING_SKIP`.
    """

    file: str = ""
    mapping: str = ""
    number: int = 0
    order: list[int] = field(default_factory=list)
    span: list[float] = field(default_factory=list)
    missing: str = MISSING_FAIL


@dataclass
class SpecCase:
    """A flight and the demands on it.

    Attributes:
        name: unique in its spec.
        log: judged instead of a flight; None to fly.
        loop: for a log: the judged setpoint and response, see `LOOPS` of
            `workbench/logs/step_response.py`, or SETPOINT:RESPONSE of any two signals.
        axis: of a step from hover: x, y, z or yaw; "" for a script.
        load: of a step of a load in hover: force_x, torque_roll, gust_z …; "" for none.
        acts: duration of the load [s]; None for the rest of the flight, or for 1 s if it is a gust.
        amplitude: of that step [m/s or rad/s], or of the load [N, N·m, m/s].
        duration: flown after the edge [s].
        start: of the flight of a script; None for hover at the height used for steps.
        script: actions of the pilot, in flight time.
        edge: time from which on the flight of a script is judged [s].
        signal: judged by metrics; for a step the commanded velocity, or the response to the load.
        command: target change of the signal of a script, from its value at the edge.
        set: parameter values for this flight.
        limits: on metrics, by name, and on statistics of signals, such as `mean of imu.f_z`.
        baseline: tolerances of recorded curves, by signal.
    """

    name: str = ""
    log: LogConfig | None = None
    loop: str = ""
    axis: str = ""
    load: str = ""
    acts: float | None = None
    amplitude: float | None = None
    duration: float = 3.0
    start: ScenarioStart | None = None
    script: list[Action] = field(default_factory=list)
    edge: float = 0.0
    signal: str = ""
    command: float | None = None
    set: dict[str, float] = field(default_factory=dict)
    limits: dict[str, SpecLimit] = field(default_factory=dict)
    baseline: dict[str, Tolerance] = field(default_factory=dict)

    @property
    def signals(self) -> list[str]:
        """The signals named in it, without duplicates."""
        of_limits = [name.partition(STATISTIC_SEPARATOR)[2] for name in self.limits]
        named = (self.signal, *self.baseline, *of_limits)
        return list(dict.fromkeys(name for name in named if name))


@dataclass
class SpecFile:
    """The keys of a spec.

    Attributes:
        title: of the spec.
        vehicle: as in a scenario, like controller, estimator, world, sensors and rates.
        cases: flights.
        at: operating point of the margins, as for `workbench linearize`.
        margins: limits by loop and by the name of a margin.
    """

    title: str = ""
    vehicle: VehicleConfig = field(default_factory=VehicleConfig)
    controller: str = DEFAULT_CONTROLLER
    estimator: str = TRUTH
    world: str = "empty"
    sensors: SensorsConfig = field(default_factory=SensorsConfig)
    rates: Rates = field(default_factory=Rates)
    cases: list[SpecCase] = field(default_factory=list)
    at: str = "hover"
    margins: dict[str, dict[str, SpecLimit]] = field(default_factory=dict)


@dataclass(frozen=True)
class Spec:
    """A checked spec with its file."""

    path: Path
    content: SpecFile
