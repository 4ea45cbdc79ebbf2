"""Replies of an analyst that no record of `design` can be: frozen, of plain numbers and arrays.

None contains an object of Drake's, so a screen need not load Drake.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.analysis.questions import Gains
from workbench.design.judge.margins import LoopMargins
from workbench.design.response_metrics import LoadMetrics, StepMetrics


@dataclass(frozen=True)
class JudgedLoop(LoopMargins):
    """The margins of one loop.

    Attributes:
        name: name of the loop.
        growing: whether an unstable mode involves it.
        turned: contributions to the phase at the crossover, by cause [rad], see
            `design.judge.phase_budget`; empty for an unstable loop.
    """

    name: str = ""
    growing: bool = False
    turned: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Judged:
    """Stability with given gains.

    Attributes:
        loops: loops in the order of the cascade.
        poles: poles of the closed loop in continuous terms, complex (k) [1/s].
        stable: whether everything is stable.
        said: what is unstable, as a sentence; "" if everything is stable.
    """

    loops: tuple[JudgedLoop, ...]
    poles: np.ndarray
    stable: bool
    said: str


@dataclass(frozen=True)
class LoopShaped:
    """Gains of a loop for a bandwidth and a margin, see `design.judge.loop_shaping`.

    Attributes:
        gains: gains of the loop, and gains linked with them.
        bandwidth: bandwidth with these gains [rad/s], NaN if unstable; see `LoopMargins`.
        phase_margin: phase margin with these gains [rad].
        disk_margin: disk margin with these gains.
        reached: whether the requested values are reached.
        bandwidths: least and largest bandwidth with at least the requested margin [rad/s], NaN if
            unknown.
        reach: least and largest margin at this bandwidth, NaN if unknown.
        said: what limits them, as a sentence.
    """

    gains: Gains
    bandwidth: float
    phase_margin: float
    disk_margin: float
    reached: bool
    bandwidths: tuple[float, float]
    reach: tuple[float, float]
    said: str


@dataclass(frozen=True)
class PoleMoved:
    """Gains of a loop that move a pole, see `design.judge.pole_placing`.

    Attributes:
        gains: gains of the loop, and gains linked with them.
        pole: the pole with these gains [1/s].
        reached: whether it is at the requested place.
        said: what prevents it, as a sentence, "" if it is reached.
    """

    gains: Gains
    pole: complex
    reached: bool
    said: str


@dataclass(frozen=True)
class StepNumbers:
    """Metrics of one flown step of a command or a load; NaN if it has none.

    Times in s, overshoot and error in %, rotor use as a share, the peak in the response's unit.
    `withheld` says why some are NaN, as for a step that has not settled; else "".
    """

    rise_time: float
    settling_time: float
    overshoot: float
    steady_state_error: float
    peak_rotor_use: float
    withheld: str = ""
    peak: float = math.nan


def step_numbers(metrics: StepMetrics | LoadMetrics, peak_rotor_use: float) -> StepNumbers:
    """Return the numbers of a step of a command or a load; a load has no rise and no overshoot."""
    return StepNumbers(
        rise_time=metrics.rise_time if isinstance(metrics, StepMetrics) else math.nan,
        settling_time=metrics.settling_time,
        overshoot=metrics.overshoot if isinstance(metrics, StepMetrics) else math.nan,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
        peak=metrics.peak,
    )


@dataclass(frozen=True)
class Predicted:
    """Response to a step of a command or a load.

    Attributes:
        time: time from the edge on (N) [s].
        response: response (N) [m/s] or [rad/s]; for a load the deviation, in its unit.
        numbers: metrics of the response.
        lost: whether the drone was lost.
        decay: time by which the transient of a command's step has decayed [s], see `decay_time`.
    """

    time: np.ndarray
    response: np.ndarray
    numbers: StepNumbers
    lost: bool
    decay: float = 0.0


@dataclass(frozen=True)
class Mapped:
    """A metric over two gains.

    Attributes:
        x: values along the columns.
        y: values along the rows.
        values: (N_y, N_x), NaN if a flight was lost or has no such metric.
        unit: unit of the values.
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    unit: str


@dataclass(frozen=True)
class Searched:
    """Progress of a search.

    Attributes:
        phase: present phase, in words.
        share: used share of its budget, 0 .. 1.
        gains: best values so far of the searched gains.
        said: wish with the least reserve, in words.
    """

    phase: str
    share: float
    gains: Gains
    said: str


@dataclass(frozen=True)
class Tuned:
    """Result of a search.

    Attributes:
        before: values of the searched gains before.
        gains: their values now.
        met: whether all wishes are met, for the corners and the full diagram, too.
        stopped: whether the user ended the search.
        wishes: text of each wish, its values before and after as text, and whether it is met.
        steps: times (N) [s] of a step along each axis by name, and its response before and after
            (N).
        said: further remarks, as why wishes are not met.
        widened: number of default limits that were relaxed to what the rule's gains reach; `said`
            names them.
    """

    before: Gains
    gains: Gains
    met: bool
    stopped: bool
    wishes: tuple[tuple[str, str, str, bool], ...]
    steps: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
    said: tuple[str, ...]
    widened: int = 0


@dataclass(frozen=True)
class FlownAgain:
    """A logged flight, and the same flight with other gains, see `design.predict.what_if`.

    Columns of six are x, y, z, v_x, v_y, v_z [m, m/s].

    Attributes:
        vehicle: vehicle whose model flew it again.
        logged_vehicle: vehicle that the log names; "" without one.
        doubt: why the result may be wrong, as a sentence; else "".
        flown: the controller that flew the log.
        flown_gains: its values, as far as the log has them.
        time: time from the start of the log on (k) [s].
        setpoint: position (k, 3) [m].
        logged: motion of the log (k, 6).
        other: motion with other gains (k, 6); NaN once the drone is lost.
        low: lower edges of its band (k, 6).
        high: upper edges of its band (k, 6).
        off_setpoint: RMS distance of log and other flight from the setpoint (2, 3) [m].
        difference: RMS difference between the two (6).
        band: half of the band's width, mean over time (6).
        stays: whether the nominal vehicle survives.
        lost: number of lost vehicles.
        drawn: number of flown vehicles: the nominal one, and uncertain ones.
    """

    vehicle: str
    logged_vehicle: str
    doubt: str
    flown: str
    flown_gains: Gains
    time: np.ndarray
    setpoint: np.ndarray
    logged: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray
    off_setpoint: np.ndarray
    difference: np.ndarray
    band: np.ndarray
    stays: bool
    lost: int
    drawn: int
