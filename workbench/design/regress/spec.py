"""What a spec file says, as typed dataclasses that are its schema."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from workbench.control.controller import DEFAULT
from workbench.estimation.settings import TRUTH
from workbench.scenario.scenario import Action, Rates, Start, VehicleConfig
from workbench.scenario.sensors_config import SensorsConfig

OF = " of "
"""In a metric's name, between a statistic and the signal that it is of: `mean of imu.f_z`."""


@dataclass
class Limit:
    """A smallest and a largest value; one of them may be missing."""

    min: float = -math.inf
    max: float = math.inf


@dataclass
class Tolerance:
    """How far a curve may be from its baseline.

    Attributes:
        absolute: in the signal's unit.
        relative: share of the baseline's amplitude, its largest distance from where it begins; the
            larger of the two counts.
        time_shift: so much earlier or later the curve may be [s].
    """

    absolute: float = 0.0
    relative: float = 0.0
    time_shift: float = 0.0


FAIL, SKIP = MISSING = ("fail", "skip")
"""What a limit does whose metric a log cannot give, and a case whose log is not there."""


@dataclass
class LogConfig:
    """A log that stands for a case's flight.

    Attributes:
        file: of any format that `workbench import` reads.
        mapping: file that names the columns of a CSV; "" where it lies beside it, or none is
            needed.
        order: for each rotor of the description the number of its motor in the log, from 1; empty
            for the log's own order.
        span: from and to [s]; empty for all of it.
        missing: `FAIL` or `SKIP`.
    """

    file: str = ""
    mapping: str = ""
    order: list[int] = field(default_factory=list)
    span: list[float] = field(default_factory=list)
    missing: str = FAIL


@dataclass
class Case:
    """A flight and what is demanded of it.

    Attributes:
        name: unique in its spec.
        log: that is judged in place of a flight; None where one is flown.
        loop: of a log: the set-point and the response that are judged, see `LOOPS` of
            `workbench/logs/step_response.py`, or SETPOINT:RESPONSE of any two signals.
        axis: of a step from hover: x, y, z or yaw; "" where a script is flown.
        load: of a step of a load in hover: force_x, torque_roll, gust_z …; "" where there is none.
        acts: for how long the load acts [s]; None to the end, a gust for 1 s.
        amplitude: of that step [m/s or rad/s], of a load [N, N·m, m/s].
        duration: flown after the edge [s].
        start: of a script's flight; without one it hovers as high as steps do.
        script: what the pilot does, in the time of the flight.
        edge: time from which a script's flight is judged [s].
        signal: that is judged by metrics; a step's is the velocity that it commands, or what the
            load moves.
        command: how far a script's signal should come from where it is at the edge.
        set: parameter values for this flight.
        limits: of metrics, by name, and of statistics of signals, as `mean of imu.f_z`.
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
    start: Start | None = None
    script: list[Action] = field(default_factory=list)
    edge: float = 0.0
    signal: str = ""
    command: float | None = None
    set: dict[str, float] = field(default_factory=dict)
    limits: dict[str, Limit] = field(default_factory=dict)
    baseline: dict[str, Tolerance] = field(default_factory=dict)

    @property
    def signals(self) -> list[str]:
        """The signals that it names, each once."""
        of_limits = [name.partition(OF)[2] for name in self.limits]
        return list(dict.fromkeys(filter(None, [self.signal, *self.baseline, *of_limits])))


@dataclass
class SpecFile:
    """A spec's keys.

    Attributes:
        title: what it is about.
        vehicle: as in a scenario; so controller, estimator, world, sensors and rates.
        cases: flights.
        at: operating point of the margins, as `workbench linearize` takes it.
        margins: limits by loop and by the name of a margin.
    """

    title: str = ""
    vehicle: VehicleConfig = field(default_factory=VehicleConfig)
    controller: str = DEFAULT
    estimator: str = TRUTH
    world: str = "empty"
    sensors: SensorsConfig = field(default_factory=SensorsConfig)
    rates: Rates = field(default_factory=Rates)
    cases: list[Case] = field(default_factory=list)
    at: str = "hover"
    margins: dict[str, dict[str, Limit]] = field(default_factory=dict)


@dataclass(frozen=True)
class Spec:
    """A spec that was read and checked, with the file that it came from."""

    path: Path
    content: SpecFile
