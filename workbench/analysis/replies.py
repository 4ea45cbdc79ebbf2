"""Replies of an analyst that no record of `design` can be: frozen, of plain numbers and arrays.

None contains an object of Drake's, so a screen need not load Drake.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.analysis.queries import Gains
from workbench.design.judge.margins import LoopMargins
from workbench.design.load_metrics import ResponseMetrics


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
        pole_loops: name of the loop that each belongs to (k), "" for none.
        pole_joints: name of the joint that moves most in each (k), "" for none.
        stable: whether everything is stable.
        said: what is unstable, as a sentence; "" if everything is stable.
    """

    loops: tuple[JudgedLoop, ...]
    poles: np.ndarray
    stable: bool
    said: str
    pole_loops: tuple[str, ...] = ()
    pole_joints: tuple[str, ...] = ()


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


MarginSample = tuple[float, tuple[LoopMargins, ...]]
"""A bandwidth [rad/s], a phase margin [rad] or a disk margin of one loop, and the margins of all
loops with gains for it."""


@dataclass(frozen=True)
class ReachSampled:
    """The margins of all loops over the reach of one loop, in rising order.

    Attributes:
        loops: names of the loops.
        bandwidths: over its bandwidth, with the present margin.
        margins: over its margin, with the present bandwidth.
    """

    loops: tuple[str, ...] = ()
    bandwidths: tuple[MarginSample, ...] = ()
    margins: tuple[MarginSample, ...] = ()


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
    numbers: ResponseMetrics
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
