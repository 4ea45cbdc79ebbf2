"""Stability margins of the exact sampled loop, in python-control's terms.

A grid of frequencies locates crossings and extrema of a response; refinement makes them exact.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import Enum

import numpy as np

from workbench.design.judge.loop_response import LoopResponses, loop_responses
from workbench.design.linear.model import LinearModel

MARGIN_GRID_DECADES = 5.0
"""Span of the grid below the highest frequency [decades]."""
MARGIN_GRID_POINTS = 320
"""Number of frequencies in the grid."""
_CROSSING_ZOOM_POINTS = np.linspace(0.0, 1.0, 9)
_CROSSING_ZOOM_STEPS = 3
"""Number of refinements, each of an interval by a factor of eight; linear interpolation then is
exact to 1e-8."""
_PHASE_CROSSING = 0
_GAIN_CROSSING = 1
_FALL_CROSSING = 2
_MIN_GAIN_MARGIN = 1e-6
"""Gain margins beyond this, or its inverse, are ignored, as rounding causes crossings there."""
HALF_POWER = 10.0 ** (-3.0 / 20.0)
"""-3 dB, which defines the bandwidth in python-control."""
PLATEAU_CROSSOVER_SHARE = 0.1
"""The reference plateau of the bandwidth lies below this share of the crossover."""
FLAT_SLOPE = 3e-3
"""A response is flat where it changes with a smaller power of the frequency."""


@dataclass(frozen=True)
class LoopMargins:
    """The margins of a closed loop, cut at one point.

    An unstable closed loop has no margins: factors are 1, angles, times and the disk are 0, the
    peak is infinite and frequencies are NaN.

    Attributes:
        gain_margin: smallest factor above 1 on the loop gain that makes the loop marginally stable;
            infinite if there is none.
        gain_reduction_margin: largest factor below 1 that makes it marginally stable; 0 if there is
            none.
        phase_margin: smallest change of phase of either sign that makes it marginally stable [rad].
        delay_margin: smallest delay in the loop that makes it marginally stable [s].
        disk_margin: python-control's balanced one (skew 0), alpha = 1 / max abs(S - 1/2): the gain
            may change by any factor between (2 - alpha) / (2 + alpha) and its inverse while the
            phase changes as well.
        peak_sensitivity: largest abs(S) = abs(1 / (1 + L)).
        bandwidth: frequency at which abs(T), T = L / (1 + L), first falls 3 dB below its plateau,
            the value where it first is flat [rad/s]. If it is flat from zero frequency on, this is
            python-control's `bandwidth`.
        crossover: highest frequency at which abs(L) is 1 [rad/s].
        stable: whether the closed loop is stable, see `LoopResponses.stable`.
    """

    gain_margin: float
    gain_reduction_margin: float
    phase_margin: float
    delay_margin: float
    disk_margin: float
    peak_sensitivity: float
    bandwidth: float
    crossover: float
    stable: bool = True

    @property
    def phase_margin_deg(self) -> float:
        """The phase margin [deg], as files and JSON have it."""
        return math.degrees(self.phase_margin)

    def to_json(self) -> dict[str, float]:
        """Return the numbers for JSON, the phase margin in degrees."""
        names = ["phase_margin_deg" if f.name == "phase_margin" else f.name for f in fields(self)]
        return {name: getattr(self, name) for name in names}


class RobustnessMeasure(Enum):
    """The measures of robustness in `LoopMargins`."""

    PHASE = "phase_margin"
    DISK = "disk_margin"

    def of(self, margins: LoopMargins) -> float:
        """Return the phase margin [rad] or the disk margin of a loop."""
        found: float = getattr(margins, self.value)
        return found


UNSTABLE_LOOP_MARGINS = LoopMargins(
    1.0, 1.0, 0.0, 0.0, 0.0, math.inf, math.nan, math.nan, stable=False
)


def loop_margins(model: LinearModel, point: str) -> LoopMargins:
    """Return the margins of a model at a loop point.

    Args:
        model: a closed loop that can be cut.
        point: name of one of the controller's loop points, such as pitch_acceleration.
    """
    return all_margins(model, [point])[0]


def all_margins(model: LinearModel, points: Sequence[str]) -> tuple[LoopMargins, ...]:
    """Return the margins at several points of one model, in one pass."""
    return response_margins(loop_responses(model, points))


def response_margins(loops: LoopResponses) -> tuple[LoopMargins, ...]:
    """Return the margins of open loops."""
    if not loops.stable or not len(loops.opened):
        return (UNSTABLE_LOOP_MARGINS,) * len(loops.opened)
    grid = frequency_grid(loops)
    response = loops.at(grid)
    edges = _edge_responses(loops)
    plateau = plateaus(grid, response)
    level = HALF_POWER * np.abs(complementary(response))[range(len(response)), plateau]
    loop, kind, frequency, there = _zeros(loops, grid, response, level)
    peaks, disks = _lowest(loops, grid, response, np.nan_to_num(edges[:, 1:]))
    found = []
    for index in range(len(loops.opened)):
        phase, size, fall = (
            (loop == index) & (kind == each)
            for each in (_PHASE_CROSSING, _GAIN_CROSSING, _FALL_CROSSING)
        )
        real = -np.append(there[phase].real, edges[index].real)
        factors = 1.0 / real[(real > _MIN_GAIN_MARGIN) & (real < 1.0 / _MIN_GAIN_MARGIN)]
        fall &= frequency > grid[plateau[index]]
        crossings = frequency[size]
        turn = (np.angle(there[size]) + math.pi) % (2.0 * math.pi)
        found.append(
            LoopMargins(
                gain_margin=float(factors[factors > 1.0].min(initial=math.inf)),
                gain_reduction_margin=float(factors[factors <= 1.0].max(initial=0.0)),
                phase_margin=float(np.minimum(turn, 2.0 * math.pi - turn).min(initial=math.inf)),
                delay_margin=float((turn / crossings).min(initial=math.inf)),
                disk_margin=float(disks[index]),
                peak_sensitivity=float(1.0 / peaks[index]),
                bandwidth=float(frequency[fall][0]) if fall.any() else math.nan,
                crossover=float(crossings.max()) if len(crossings) else math.nan,
            )
        )
    return tuple(found)


def frequency_grid(loops: LoopResponses) -> np.ndarray:
    """Return a logarithmic grid of frequencies (F) [rad/s], denser near poles of low damping."""
    top = loops.highest
    even = np.geomspace(top * 10.0**-MARGIN_GRID_DECADES, top * 0.99999, MARGIN_GRID_POINTS)
    poles = np.append(loops.closed, loops.opened)
    if loops.period:
        with np.errstate(divide="ignore"):
            poles = np.log(poles[poles != 0.0]) / loops.period
    size = np.abs(poles)
    damping = np.abs(poles.real) / np.maximum(size, 1e-300)
    faint = (damping < 0.15) & (poles.imag > even[0]) & (size < top)
    spread = np.array([-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0])
    near = poles.imag[faint, None] + np.abs(poles.real[faint, None]) * spread
    near = near[(near > even[0]) & (near < even[-1])]
    return np.unique(np.append(even, near))


def complementary(response: np.ndarray) -> np.ndarray:
    """Return T = L / (1 + L); it is 1 for an infinite L, as of an integrator at zero frequency."""
    with np.errstate(divide="ignore", invalid="ignore"):
        closed: np.ndarray = 1.0 / (1.0 + 1.0 / response)
    return closed


def plateaus(grid: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Return where (P) in the grid |T| first is flat, or flattest, well below the crossover.

    At the lowest frequencies it may still rise: if wind turns the heading back within minutes, the
    yaw rate has no response at zero frequency.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        steepness = np.abs(np.diff(np.log(np.abs(complementary(response)))) / np.diff(np.log(grid)))
    above = np.abs(response) > 1.0
    last = len(grid) - 1 - np.argmax(above[:, ::-1], axis=1)
    crossover = np.where(above.any(axis=1), grid[last], 0.0)
    steepness[~(grid[1:] < PLATEAU_CROSSOVER_SHARE * crossover[:, None]) | np.isnan(steepness)] = (
        np.inf
    )
    flat = steepness < FLAT_SLOPE
    found: np.ndarray = np.argmax(flat, axis=1)
    return np.where(flat.any(axis=1), found, np.argmin(steepness, axis=1))


def _zeros(
    loops: LoopResponses, grid: np.ndarray, response: np.ndarray, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return all crossings (K) that margins are read from: where L is real, or of size 1, or |T|
    falls through its `level` (P).

    Returns:
        Number of the loop, kind, frequency [rad/s] and L of each (K).
    """
    with np.errstate(invalid="ignore"):
        values = _crossing_values(response, level[:, None])
        crosses = (values[..., 1:] > 0.0) != (values[..., :-1] > 0.0)
        crosses &= np.isfinite(values[..., 1:]) & np.isfinite(values[..., :-1])
    crosses[_FALL_CROSSING] &= values[_FALL_CROSSING, :, :-1] > 0.0
    crosses[_PHASE_CROSSING] &= (response.real[:, 1:] < 0.0) | (response.real[:, :-1] < 0.0)
    kind, loop, place = np.nonzero(crosses)
    low, high = grid[place], grid[place + 1]
    rows = np.arange(len(kind))
    first = last = np.zeros(len(kind))
    for _ in range(_CROSSING_ZOOM_STEPS):
        at = low[:, None] + (high - low)[:, None] * _CROSSING_ZOOM_POINTS
        values = _crossing_values(loops.at(at, loop), level[loop, None])[kind, rows]
        positive = values > 0.0
        step = np.argmax(positive[:, 1:] != positive[:, :-1], axis=1)
        low, high = at[rows, step], at[rows, step + 1]
        first, last = values[rows, step], values[rows, step + 1]
    rise = np.where(last == first, 1.0, last - first)
    zero = low - first * (high - low) / rise
    return loop, kind, zero, loops.at(zero[:, None], loop)[:, 0]


def _crossing_values(response: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Return values that are zero where L is real, where |L| is 1, and where |T| is at a level."""
    size = response.real**2 + response.imag**2
    return np.stack(
        [response.imag, size - 1.0, size - level**2 * (size + 2.0 * response.real + 1.0)]
    )


def disk_margins(response: np.ndarray) -> np.ndarray:
    """Return the disk margins (S) of L (S, F) on a grid; `response_margins` refines one."""
    found: np.ndarray = _distances(response)[1].min(axis=1)
    return found


def _lowest(
    loops: LoopResponses, grid: np.ndarray, response: np.ndarray, edge: np.ndarray
) -> np.ndarray:
    """Return the lowest distance from -1 and the lowest disk margin, (2, P)."""
    count = len(response)
    loop, rows = np.tile(np.arange(count), 2), np.arange(2 * count)
    values = _distances(response).reshape(2 * count, -1)
    place = np.argmin(values, axis=1)
    low, high = grid[np.maximum(place - 1, 0)], grid[np.minimum(place + 1, len(grid) - 1)]
    for _ in range(_CROSSING_ZOOM_STEPS + 1):
        at = low[:, None] + (high - low)[:, None] * _CROSSING_ZOOM_POINTS
        both = _distances(loops.at(at, loop))
        values = np.concatenate([both[0, :count], both[1, count:]])
        place = np.argmin(values, axis=1)
        low = at[rows, np.maximum(place - 1, 0)]
        high = at[rows, np.minimum(place + 1, len(_CROSSING_ZOOM_POINTS) - 1)]
    lowest: np.ndarray = np.fmin(values.min(axis=1).reshape(2, count), _distances(edge)[..., 0])
    return lowest


def _distances(response: np.ndarray) -> np.ndarray:
    """Return |1 + L| and 2 |1 + L| / |1 - L|, infinite where L is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near = np.abs(1.0 + response)
        both = np.stack([near, 2.0 * near / np.abs(1.0 - response)])
    both[np.isnan(both)] = math.inf
    return both


def _edge_responses(loops: LoopResponses) -> np.ndarray:
    """Return L (P, 2) at zero frequency and half the sampling rate, where it is real, else NaN.

    Above the highest frequency of a continuous loop it is zero.
    """
    edges = loops.at(np.array([0.0, loops.highest]))
    if not loops.period:
        edges[:, 1] = math.nan
    edges[~(np.abs(edges) < 1.0 / _MIN_GAIN_MARGIN) | (edges == 0.0)] = math.nan
    return edges
