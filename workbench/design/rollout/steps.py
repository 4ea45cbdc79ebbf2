"""Steps in compiled code; in wind they begin at the steady drift, as those of `fly_step` do."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from workbench.design.rollout.planned_flights import PlannedFlights
from workbench.design.rollout.rollouts import MeasuredSteps, Rollouts
from workbench.design.steady_drift import look_period, steady_looks, window_looks
from workbench.design.step_metrics import (
    FROM_REST_NUMBERS,
    STEADY_STATE_NUMBERS,
    STEP_NUMBERS,
    StepMetrics,
    step_metrics,
)
from workbench.scenario.axes import AXIS_NAMES
from workbench.session.drift import (
    MAX_HOVER_S,
    NEVER_STEADY,
    NOT_STEADY,
    WIND_SPEEDS,
    drift_commands,
    moving_speed,
    steady_window,
)
from workbench.session.hover_attitude import AT_REST_SHARE

VELOCITY_INDICES = (7, 8, 9, 10, 11, 12)
"""Places in the state of angular velocity and velocity."""
RESPONSE_INDICES = (10, 11, 12, 9)
"""Places in the state of what steps along each of `AXIS_NAMES` move."""
FIRST_WINDOWS = 3
"""Number of windows that are flown first to find the drift; most are steady by then."""


def fly_steps(
    planned: PlannedFlights,
    axis: str,
    amplitude: float,
    duration: float,
    velocity: Sequence[float],
    threads: int,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Rollouts:
    """Fly steps, and keep their curves.

    Args: as for `RolloutEngine.fly`, and
        planned: the flights from a held point, or from a velocity.
        threads: that fly at a time.
    """
    curves, used, lost_at = planned.curves(VELOCITY_INDICES, threads, progress, stop)
    before, column = np.zeros(len(used)), VELOCITY_INDICES.index(_response_index(axis))
    unsteady, whole = {}, len(used)
    if not any(velocity):
        how = axis, amplitude, duration, threads, stop
        drifting = _drifting_steps(planned, curves[:, 0, column], lost_at, *how)
        unsteady = drifting.unsteady

        def keep(places: np.ndarray, flown: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
            curves[places], used[places], lost_at[places] = flown
            before[places] = curves[places, 0, column]

        whole = drifting.fly(VELOCITY_INDICES, keep, threads, stop)
    return Rollouts(
        axis=axis,
        time=planned.time,
        velocity_W=curves[:whole, :, 3:],
        angular_velocity_W=curves[:whole, :, :3],
        peak_rotor_use=used[:whole],
        diverged_at=lost_at[:whole],
        before=before[:whole],
        unsteady={place: why for place, why in unsteady.items() if place < whole},
    )


def measure_steps(
    planned: PlannedFlights,
    axis: str,
    amplitude: float,
    duration: float,
    decay: float | np.ndarray,
    threads: int,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> MeasuredSteps:
    """Fly steps, and keep their metrics alone.

    Args: as for `RolloutEngine.measure`, and
        planned: the flights from a held point.
        threads: that fly at a time.
    """
    times, at_edge = planned.time, np.zeros(planned.size)
    numbers = np.full((len(STEP_NUMBERS), planned.size), np.nan)
    decays = np.broadcast_to(decay, planned.size)

    def keep(first: int, last: int, samples: np.ndarray) -> None:
        responses = samples[:, 0, : last - first].T
        found = step_metrics(times, responses, amplitude, decay=decays[first:last])
        numbers[:, first:last] = [*found.numbers.values()]
        at_edge[first:last] = responses[:, 0]

    kept, how = (_response_index(axis),), (axis, amplitude, duration, threads, stop)
    used, lost_at = planned.fly(kept, keep, threads, progress, stop)
    drifting = _drifting_steps(planned, at_edge[: len(used)], lost_at, *how)

    def replace(places: np.ndarray, flown: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
        curves, used[places], lost_at[places] = flown
        responses = curves[:, :, 0] - curves[:, :1, 0]
        found = step_metrics(times, responses, amplitude, decay=decays[places])
        numbers[:, places] = [*found.numbers.values()]

    whole = drifting.fly(kept, replace, threads, stop)
    for name in (*FROM_REST_NUMBERS, *STEADY_STATE_NUMBERS, "peak_time"):
        numbers[STEP_NUMBERS.index(name), list(drifting.unsteady)] = np.nan
    return MeasuredSteps(
        metrics=StepMetrics(*numbers[:, :whole], peak_rotor_use=used[:whole]),
        diverged_at=lost_at[:whole],
    )


class _DriftingSteps(NamedTuple):
    """What moving air does to steps from a held point.

    Attributes:
        again: candidates (K) and their flights from the drift, a part for each time of the edge.
        unsteady: why a step has no steady state, by candidate.
        whole: number of candidates, from the first on, before one that was stopped.
    """

    again: list[tuple[np.ndarray, PlannedFlights]]
    unsteady: dict[int, str]
    whole: int

    def fly(
        self,
        kept: tuple[int, ...],
        keep: Callable[[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]], None],
        threads: int,
        stop: Callable[[], bool] | None,
    ) -> int:
        """Fly those from the drift, and return the number of candidates before one not flown.

        Args:
            kept: places in the state of what is kept.
            keep: called with candidates (K) and what `PlannedFlights.curves` returns of them.
            threads: that fly at a time.
            stop: asked before each part; when it returns true, no more are flown.
        """
        whole = self.whole
        for places, flights in self.again:
            if stop and stop():
                whole = min(whole, int(places[0]))
            else:
                keep(places, flights.curves(kept, threads))
        return whole


def _drifting_steps(
    planned: PlannedFlights,
    speeds: np.ndarray,
    lost_at: np.ndarray,
    axis: str,
    amplitude: float,
    duration: float,
    threads: int,
    stop: Callable[[], bool] | None,
) -> _DriftingSteps:
    """Return which candidates fly again from their drift, and which have no steady state.

    Args:
        planned: the flights of a step from a held point.
        speeds: of the first of them at the edge, along the axis (N) [m/s or rad/s].
        lost_at: when they were lost (N) [s], NaN if they were not.
        axis: x, y, z or yaw.
        amplitude: of the command [m/s or rad/s].
        duration: flown after the edge [s].
        threads: that fly at a time.
        stop: asked every few flights; when it returns true, no more are flown.
    """
    air = planned.flights[: len(speeds)]["air"]
    blows = np.any([air[name] != 0.0 for name in WIND_SPEEDS], axis=0)
    fastest = moving_speed(amplitude, is_estimated=planned.senses is not None)
    moving = blows & np.isnan(lost_at) & (np.abs(speeds) > fastest)
    turbulent = moving & (air["turbulence"] != 0.0)
    unsteady = dict.fromkeys(np.flatnonzero(turbulent).tolist(), NEVER_STEADY)
    left = np.flatnonzero(moving & ~turbulent)
    again: list[tuple[np.ndarray, PlannedFlights]] = []
    when, period = planned.schedule, planned.clock.period
    window, look = steady_window(duration), look_period(period)
    every, looks = round(look / period), window_looks(window, look)
    before, commands = drift_commands(axis, amplitude)
    kept, spread = (_response_index(axis),), AT_REST_SHARE * abs(amplitude)
    for hover in dict.fromkeys((min(FIRST_WINDOWS * window, MAX_HOVER_S), MAX_HOVER_S)):
        if not left.size:
            break
        if stop and stop():
            return _DriftingSteps(again, unsteady, int(left[0]))
        end = when.edge + math.floor(hover / look) * every
        schedule = when._replace(end=end, stride=every)
        speeds = planned.again(left, before, before, schedule).curves(kept, threads)[0][:, :, 0]
        found = steady_looks(speeds, looks, spread)
        for number in np.unique(found[found >= 0]).tolist():
            later = number * every
            schedule = when._replace(
                edge=when.edge + later,
                edge_time=when.edge_time + later * period,
                end=when.end + later,
            )
            places = left[found == number]
            again.append((places, planned.again(places, before, commands, schedule)))
        left = left[found < 0]
    unsteady |= dict.fromkeys(left.tolist(), NOT_STEADY)
    return _DriftingSteps(again, unsteady, len(air))


def _response_index(axis: str) -> int:
    """Return the place in the state of what a step along an axis moves."""
    return RESPONSE_INDICES[AXIS_NAMES.index(axis)]
