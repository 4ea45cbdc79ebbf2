"""Fly until a drone moves steadily, as it does in wind under a law without integral action."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from workbench.common.errors import FlightBrokenError
from workbench.design.flown_step import STEP_EDGE_S
from workbench.scenario.axes import AXIS_NAMES

if TYPE_CHECKING:
    from workbench.scenario.scenario import Action
    from workbench.session.session import Session

MAX_HOVER_S, HOVER_LOOK_S = 60.0, 0.25
"""Longest flight before a step until the drone is steady, and time after which it is looked at
again [s]."""


def steady_time(
    session: "Session",
    script: "Sequence[Action]",
    axis: str,
    spread: float,
    kept: float,
    progress: Callable[[float], None] | None = None,
) -> float:
    """Return the time at which a drone has become steady [s], 0 if it does not.

    Args:
        session: that flies it, from its start.
        script: of the flight; the drone has until its last action to become steady.
        axis: x, y, z (velocity in W) or yaw (rate).
        spread: by which the velocity or the rate of a steady drone changes at most [m/s or rad/s]..
        kept: .. within this time [s].
        progress: called with the share of the longest time, 0 .. 1.
    """
    end, place = script[-1].at, AXIS_NAMES.index(axis)
    session.follow(script, end)
    seen: deque[float] = deque(maxlen=1 + math.ceil(kept / HOVER_LOOK_S))
    try:
        session.tick(STEP_EDGE_S)
        while session.time < end:
            now = session.snapshot()
            seen.append((*now.v_WB, now.w_WB[2])[place])
            if len(seen) == seen.maxlen and max(seen) - min(seen) <= spread:
                return session.time
            session.tick(HOVER_LOOK_S)
            if progress:
                progress(session.time / end)
    except FlightBrokenError:
        pass  # a drone that is lost is not steady
    return 0.0
