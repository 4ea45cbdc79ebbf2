"""Fly a step of a command from where the law is at rest under the present air.

A law without integral action drifts with the wind while it is told to stand. A drone that moves at
the edge of its step flies again: it steers at no speed until it drifts steadily, and steps from
there. In turbulence nothing becomes steady.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.flown_step import STEP_EDGE_S, axis_velocity
from workbench.design.step_metrics import SETTLING_BAND
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.scenario import Action
from workbench.session.drift import (
    HOVER_LOOK_S,
    NEVER_STEADY,
    NOT_STEADY,
    air_moves,
    drift_commands,
    moving_speed,
    steady_window,
)

if TYPE_CHECKING:
    from workbench.design.flier import Flier, FlierFlight
    from workbench.session.session import Session
    from workbench.setup import Setup


class FlownFromRest(NamedTuple):
    """A step from where the law is at rest.

    Attributes:
        flown: its flight.
        edge: time of the command [s].
        rests: whether the drone was steady before it, as far as the response does not tell.
        unsteady: why there is no steady state, "" if there may be.
    """

    flown: "FlierFlight"
    edge: float = STEP_EDGE_S
    rests: bool = True
    unsteady: str = ""


def fly_from_rest(
    flier: "Flier",
    setup: "Setup",
    axis: str,
    amplitude: float,
    duration: float,
    longest_hover: float,
    progress: Callable[[float], None] | None = None,
    *,
    programs: bool = True,
) -> FlownFromRest:
    """Fly a step, and again from its steady drift if the drone moves along the axis at the edge.

    Args:
        flier: with the script of the step from a held point.
        setup: of the flight.
        axis: x, y, z (velocity in W) or yaw (rate).
        amplitude: of the command [m/s or rad/s].
        duration: flown after the edge [s].
        longest_hover: longest time to become steady [s]; 0 flies once, whatever the drone does.
        progress: called with the flown share, 0 .. 1.
        programs: as for `Flier.fly`.

    Raises:
        FlightBrokenError: as `Flier.fly`.
    """
    from workbench.design.lost import find_loss
    from workbench.session.hover_attitude import AT_REST_SHARE

    first = FlownFromRest(flier.fly(progress, programs=programs))
    flown = first.flown
    speed = axis_velocity(flown.recording.between(STEP_EDGE_S, np.inf), axis)[:1]
    fastest = moving_speed(amplitude, is_estimated=setup.scenario.is_estimated)
    moves = np.abs(speed).max(initial=0.0) > fastest
    if not longest_hover or not moves or flown.exchange or find_loss(flown.recording):
        return first
    if setup.values["turbulence"]:
        return first._replace(unsteady=NEVER_STEADY)
    window, size = steady_window(duration), abs(amplitude)
    script = _drifting_script(axis, amplitude, STEP_EDGE_S + longest_hover)
    edge = steady_time(flier.session, script, axis, AT_REST_SHARE * size, window, progress)
    if not edge:
        return first._replace(unsteady=NOT_STEADY if air_moves(setup.values) else "")
    flier.follow(_drifting_script(axis, amplitude, edge), edge + duration)
    again = flier.fly(progress, programs=programs)
    before = axis_velocity(again.recording.between(edge - window, edge), axis)
    return FlownFromRest(again, edge, bool(np.ptp(before) <= SETTLING_BAND * size))


def _drifting_script(axis: str, amplitude: float, edge: float) -> list[Action]:
    """Return the script of a step from a drift."""
    if axis == "yaw":
        return [Action(at=edge, yaw_rate=amplitude)]
    drift, command = drift_commands(axis, amplitude)
    return [Action(velocity=drift[:3]), Action(at=edge, velocity=command[:3])]


def look_period(control_period: float) -> float:
    """Return the time between two looks at a drone, whole control periods [s]."""
    return control_period * math.ceil(HOVER_LOOK_S / control_period - 1e-6)


def window_looks(kept: float, look: float) -> int:
    """Return the number of looks at a drone within a time [s], a look period [s] apart."""
    return 1 + math.ceil(kept / look - 1e-6)


def hover_until(
    session: "Session",
    is_steady: Callable[[], bool],
    end: float,
    look: float = HOVER_LOOK_S,
    progress: Callable[[], None] | None = None,
) -> bool:
    """Fly on until a drone is steady, and return whether it is.

    Args:
        session: that flies it.
        is_steady: asked time and again.
        end: time at which it ends otherwise [s].
        look: time between [s].
        progress: called as it flies.
    """
    while session.time < end:
        session.tick(look)
        if progress:
            progress()
        if is_steady():
            return True
    return False


def steady_time(
    session: "Session",
    script: "Sequence[Action]",
    axis: str,
    spread: float,
    kept: float,
    progress: Callable[[float], None] | None = None,
) -> float:
    """Return the time at which a drone has become steady [s], 0 if it does not or is lost.

    Args:
        session: that flies it, from its start.
        script: of the flight; the drone has until its last action to become steady.
        axis: x, y, z (velocity in W) or yaw (rate).
        spread: by which the velocity or the rate of a steady drone changes at most [m/s or rad/s]..
        kept: .. within this time [s].
        progress: called with the share of the longest time, 0 .. 1.
    """
    from workbench.design.lost import find_loss

    end, place = script[-1].at, AXIS_NAMES.index(axis)
    session.follow(script, end)
    look = look_period(session.scenario.rates.control_period)
    seen: deque[float] = deque(maxlen=window_looks(kept, look))

    def is_steady() -> bool:
        now = session.snapshot()
        seen.append((*now.v_WB, now.w_WB[2])[place])
        return len(seen) == seen.maxlen and max(seen) - min(seen) <= spread

    def show_share() -> None:
        if progress:
            progress(min(1.0, session.time / end))

    try:
        session.tick(STEP_EDGE_S)
        is_steady()
        is_found = hover_until(session, is_steady, end, look, show_share)
        if is_found and not find_loss(session.recording()):  # it may stand on the ground
            return session.time
    except FlightBrokenError:
        pass  # a drone that is lost is not steady
    return 0.0


def steady_looks(speeds: np.ndarray, looks: int, spread: float) -> np.ndarray:
    """Return the look (N) at which each drone has become steady, -1 for one that does not.

    Args:
        speeds: at the looks (N, M) [m/s or rad/s]; NaN for a drone that is lost.
        looks: number of looks for which it has to be steady, see `window_looks`.
        spread: as for `steady_time`.
    """
    if speeds.shape[1] < looks:
        return np.full(len(speeds), -1)
    windows = np.lib.stride_tricks.sliding_window_view(speeds, looks, axis=1)
    steady = windows.max(axis=2) - windows.min(axis=2) <= spread
    return np.where(steady.any(axis=1), steady.argmax(axis=1) + looks - 1, -1)
