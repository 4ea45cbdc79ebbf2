"""Decide whether there is space and calm for an excitation in flight."""

import bisect
import dataclasses
import math
from collections import deque

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.live.alarms import hit_speed
from workbench.plant.gravity import GRAVITY
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import Rates
from workbench.session.script import acting_step
from workbench.session.session import Session

DECELERATION_M_S2 = 4.0
"""Deceleration that every drone can reach [m/s²]."""
REACTION_TIME_S = 0.5
"""Time before a drone decelerates at that rate, and between checks for obstacles [s]."""
STOPPING_MARGIN_M = 0.1
"""Distance kept free [m]."""
MAX_OVERTILT_RAD = math.radians(20.0)
"""Overshoot above `max_tilt`: a step swings past it by less [rad]."""
SETTLED_TIME_S = 1.0
"""A step has settled after this time [s] …"""
MAX_SETTLED_RATE_RAD_S = 1.0
"""… to tilt rates below this [rad/s], unless the drone swings."""
SIDES_WINDOW_S = 1.0
"""A swing goes to both sides within this time [s]."""
AXIS_DIRECTIONS = {"x": ("east", "west"), "y": ("north", "south"), "z": ("up", "down")}
"""Direction along the axis, and against it."""
TILT_DIRECTIONS = (("to its right", "to its left"), ("ahead", "behind"))
"""Direction into which a positive setpoint of roll or pitch leads, and against it."""
IN_FLIGHT = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)
"""Modes in which a drone follows commands."""
WATCH_PERIOD_S = 1 / 32
"""Approximate period of checks of the drone [s]."""


class StepPlan:
    """Tells at which steps of a round a command or a load changes, and its new value.

    A round takes the nearest whole number of control periods and begins with a control update, so
    every round looks the same to the law. A chirp changes with every control update.

    Args:
        excitation: the flown excitation.
        rates: rates of the flight.

    Attributes:
        length: length of a round, in steps.
    """

    def __init__(self, excitation: Excitation, rates: Rates) -> None:
        self._once = dataclasses.replace(excitation, repeats=False)
        self._step = rates.physics_step
        control = rates.control_steps
        self.length = control * max(1, round(excitation.round_time / rates.control_period))
        edges = [acting_step(edge, rates) for edge in excitation.edges]
        self._changes = edges or range(0, self.length, control)

    def next_change(self, step: int) -> int:
        """Return the next step after a given one at which the command changes or the round ends."""
        place = bisect.bisect_right(self._changes, step)
        return min(self._changes[place], self.length) if place < len(self._changes) else self.length

    def value(self, step: int) -> float:
        """Return the command or the load at a step of the round, in its unit."""
        return self._once.command(step * self._step)


class ExcitationGuard:
    """Monitors one excitation.

    Args:
        session: the flown session.
        excitation: excitation to be flown, None for an injection, which hardly moves the drone.
    """

    def __init__(self, session: Session, excitation: Excitation | None = None) -> None:
        self._session, self._excitation = session, excitation
        self._time, self._v_WB = session.time, session.state()[10:13]
        self._calm_from = math.inf
        self._rates: deque[tuple[float, float, float]] = deque()

    def check_room(self) -> None:
        """Refuse an excitation that leads into an obstacle.

        Raises:
            WorkbenchError: names the obstacle.
        """
        if self._excitation is not None and isinstance(self._excitation.row, AttitudeAxis):
            self._check_tilted_room(self._excitation, self._excitation.row)
        if self._excitation is None or self._excitation.axis not in AXIS_DIRECTIONS:
            return
        axis, size = self._excitation.axis, abs(self._excitation.amplitude)
        rates = self._session.scenario.rates
        plan = StepPlan(self._excitation, rates)
        times = range(0, plan.length, rates.control_steps)
        command = np.array([plan.value(step) for step in times])
        place = np.append(0.0, np.cumsum(command) * rates.control_period)
        for sign, where in zip((1.0, -1.0), AXIS_DIRECTIONS[axis], strict=True):
            if not (sign * command > 0.0).any():
                continue
            needed = float((sign * place).max()) + _stopping_distance(size)
            direction = [sign if name == axis else 0.0 for name in AXIS_NAMES[:3]]
            self._check_way(direction, needed, where)

    def _check_tilted_room(self, excitation: Excitation, row: AttitudeAxis) -> None:
        """Refuse a setpoint of attitude or rate that leads into an obstacle."""
        period = self._session.scenario.rates.control_period
        plan = StepPlan(excitation, self._session.scenario.rates)
        times = range(0, plan.length, self._session.scenario.rates.control_steps)
        setpoints = np.array([plan.value(step) for step in times])
        given = setpoints != 0.0  # else the drone brakes
        speed = np.cumsum(given * GRAVITY * np.tan(row.tilts(setpoints, period))) * period
        place = np.cumsum(given * speed) * period
        forward = np.array(row.direction(self._session.snapshot().roll_pitch_yaw[2]))
        for sign, where in zip((1.0, -1.0), TILT_DIRECTIONS[row.place], strict=True):
            needed = float((sign * place).max()) + _stopping_distance(float((sign * speed).max()))
            if (sign * place).max() > 0.0:
                self._check_way((sign * forward).tolist(), needed, where)

    def _check_way(self, direction: list[float], needed: float, where: str) -> None:
        """Refuse an excitation that needs more room than there is.

        Args:
            direction: in W.
            needed: room along it [m].
            where: the direction in words.
        """
        free, what = self._session.free_way(direction, needed)
        if what:
            raise WorkbenchError(
                f"there is no room: the excitation needs {needed:.1f} m {where}, and {what} is "
                f"{free:.1f} m away: give it a smaller amplitude, a shorter period or the "
                "other sign, or fly elsewhere first"
            )

    def step(self) -> None:
        """Record that the command steps now."""
        self._calm_from = self._session.time + SETTLED_TIME_S
        self._rates.clear()

    def trouble(self) -> str:
        """Return a sentence if the drone has hit something or swings, else ""."""
        session = self._session
        state, now, before = session.state(), session.time, self._v_WB
        duration, self._time, self._v_WB = now - self._time, now, state[10:13]
        hit = hit_speed(session.vehicle, before, self._v_WB, duration)
        if hit:
            return f"the drone has hit something: its velocity changed by {hit:.1f} m/s at once"
        return self._swing(state)

    def obstacle(self) -> str:
        """Return the obstacle that is so close ahead that the drone must stop now, "" for none."""
        v_WB = self._session.state()[10:13]
        speed = float(np.linalg.norm(v_WB))
        if not 0.0 < speed < math.inf:
            return ""
        free, what = self._session.free_way((v_WB / speed).tolist(), _stopping_distance(speed))
        return f"{what} is {free:.1f} m ahead" if what else ""

    def _swing(self, state: np.ndarray) -> str:
        """Return how the drone swings, "" if it does not."""
        _, x, y, _ = state[0:4] / np.linalg.norm(state[0:4])
        tilt = math.acos(max(-1.0, 1.0 - 2.0 * (x * x + y * y)))
        if tilt > self._session.get("max_tilt") + MAX_OVERTILT_RAD:
            return f"the drone oscillates: it tilts by {math.degrees(tilt):.0f}°"
        now = self._session.time
        if now < self._calm_from:
            return ""
        self._rates.append((now, float(state[7]), float(state[8])))
        while self._rates[0][0] < now - SIDES_WINDOW_S:
            self._rates.popleft()
        _, *rates = zip(*self._rates, strict=True)
        least = max(min(max(rate), -min(rate)) for rate in rates)
        if least < MAX_SETTLED_RATE_RAD_S:
            return ""
        since = now - self._calm_from + SETTLED_TIME_S
        return (
            f"the drone oscillates: {math.degrees(least):.0f}°/s to both sides {since:.1f} s after "
            "the step"
        )


def _stopping_distance(speed: float) -> float:
    """Return the stopping distance of a drone [m]."""
    return REACTION_TIME_S * speed + 0.5 * speed * speed / DECELERATION_M_S2 + STOPPING_MARGIN_M
