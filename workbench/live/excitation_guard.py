"""Tells whether an excitation has room, and when it must end before it is over."""

import math
from collections import deque

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.live.hard_hit import hit_speed
from workbench.live.step_plan import StepPlan
from workbench.scenario.axes import AXES
from workbench.scenario.excitation import Excitation
from workbench.session.session import Session

SLOWING = 4.0
"""Deceleration that any drone reaches [m/s²]."""
REACTION = 0.5
"""Until it slows down so, and until this is looked for again [s]."""
MARGIN = 0.1
"""That is left free [m]."""
OVERTILT = math.radians(20.0)
"""Beyond `max_tilt`: a step swings over it by less [rad]."""
CALM = 1.0
"""A step has died out after this [s] …"""
SWING_RATE = 1.0
"""… to tilt rates below this [rad/s], unless the drone swings."""
SEEN = 1.0
"""A swing goes to both sides within this [s]."""
DIRECTIONS = {"x": ("east", "west"), "y": ("north", "south"), "z": ("up", "down")}
"""Along the axis, and against it."""


class ExcitationGuard:
    """Watches one excitation.

    Args:
        session: that is flown.
        excitation: that is to be flown.
    """

    def __init__(self, session: Session, excitation: Excitation) -> None:
        self._session, self._excitation = session, excitation
        self._time, self._v_WB = session.time, session.state()[10:13]
        self._calm_from = math.inf
        self._rates: deque[tuple[float, float, float]] = deque()

    def check_room(self) -> None:
        """Refuse an excitation that leads into an obstacle.

        Raises:
            WorkbenchError: with what is in the way.
        """
        axis, size = self._excitation.axis, abs(self._excitation.amplitude)
        if axis not in DIRECTIONS:
            return
        rates = self._session.scenario.rates
        plan = StepPlan(self._excitation, rates)
        times = range(0, plan.length, round(rates.control_period / rates.physics_step))
        command = np.array([plan.value(step) for step in times])
        place = np.append(0.0, np.cumsum(command) * rates.control_period)
        for sign, where in zip((1.0, -1.0), DIRECTIONS[axis], strict=True):
            if not (sign * command > 0.0).any():
                continue
            needed = float((sign * place).max()) + _stopping_way(size)
            direction = [sign if name == axis else 0.0 for name in AXES[:3]]
            free, what = self._session.free_way(direction, needed)
            if what:
                raise WorkbenchError(
                    f"there is no room: the excitation needs {needed:.1f} m {where}, and {what} is "
                    f"{free:.1f} m away: give it a smaller amplitude, a shorter period or the "
                    "other sign, or fly elsewhere first"
                )

    def step(self) -> None:
        """Take note that the command steps now."""
        self._calm_from = self._session.time + CALM
        self._rates.clear()

    def trouble(self) -> str:
        """Return how the drone has hit something or swings, "" if it has not and does not."""
        session = self._session
        state, now, before = session.state(), session.time, self._v_WB
        duration, self._time, self._v_WB = now - self._time, now, state[10:13]
        hit = hit_speed(session.vehicle, before, self._v_WB, duration)
        if hit:
            return f"the drone has hit something: its velocity changed by {hit:.1f} m/s at once"
        return self._swing(state)

    def obstacle(self) -> str:
        """Return what is so near ahead that the drone must stop now, "" if nothing is."""
        v_WB = self._session.state()[10:13]
        speed = float(np.linalg.norm(v_WB))
        if not 0.0 < speed < math.inf:
            return ""
        free, what = self._session.free_way((v_WB / speed).tolist(), _stopping_way(speed))
        return f"{what} is {free:.1f} m ahead" if what else ""

    def _swing(self, state: np.ndarray) -> str:
        """Return how the drone swings, "" if it does not."""
        _, x, y, _ = state[0:4] / np.linalg.norm(state[0:4])
        tilt = math.acos(max(-1.0, 1.0 - 2.0 * (x * x + y * y)))
        if tilt > self._session.get("max_tilt") + OVERTILT:
            return f"the drone swings: it tilts by {math.degrees(tilt):.0f}°"
        now = self._session.time
        if now < self._calm_from:
            return ""
        self._rates.append((now, float(state[7]), float(state[8])))
        while self._rates[0][0] < now - SEEN:
            self._rates.popleft()
        _, *rates = zip(*self._rates, strict=True)
        least = max(min(max(rate), -min(rate)) for rate in rates)
        if least < SWING_RATE:
            return ""
        since = now - self._calm_from + CALM
        return (
            f"the drone swings: {math.degrees(least):.0f}°/s to both sides {since:.1f} s after the "
            "step"
        )


def _stopping_way(speed: float) -> float:
    """Return how far a drone flies on until it stands [m]."""
    return REACTION * speed + 0.5 * speed * speed / SLOWING + MARGIN
