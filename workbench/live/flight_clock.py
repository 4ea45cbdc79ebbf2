"""The pace of a live flight against real time."""

import math
from collections import deque

from workbench.common.errors import WorkbenchError
from workbench.live.messages import Pace

MIN_SPEED_FACTOR, MAX_SPEED_FACTOR = 0.01, 20.0
"""Limits of the speed; few machines keep up beyond the upper one."""
MAX_FLIGHT_LAG_S = 0.25
"""Largest lag of the flight behind the wall clock; time beyond it is skipped and never flown [s of
wall].

Other work delays a process by a tenth of a second now and then; the flight catches up on that
within a hundredth.
"""
FLIGHT_SLICE_S = 1 / 128
"""Wall time of one slice; orders are read between slices [s]."""
PACE_WINDOW_S = 1.0
"""Averaging time of the real-time factor [s of wall]."""


class FlightClock:
    """Tells how many steps to fly now, and whether the flight keeps up.

    A flight that falls behind by more than `MAX_FLIGHT_LAG_S` does not catch up: it continues from
    its present time, and `pace` reports it. The class reads no clock itself: every method takes the
    time, so that tests can use any clock.

    Args:
        step: simulated time of a step [s].
        now: wall time [s].
    """

    def __init__(self, step: float, now: float) -> None:
        self._step = step
        self._speed = 1.0
        self._paused = False
        self._given_up = 0.0
        self._worst_lag = 0.0
        self.restart(now)

    @property
    def paused(self) -> bool:
        """Whether no step is due."""
        return self._paused

    @property
    def slice(self) -> int:
        """Number of steps in a slice."""
        return max(1, round(self._speed * FLIGHT_SLICE_S / self._step))

    def pause(self) -> None:
        """Stop making steps due."""
        self._paused = True

    def resume(self, now: float) -> None:
        """Make steps due from now on."""
        if self._paused:
            self._paused = False
            self.restart(now)

    def set_speed(self, speed: float, now: float) -> None:
        """Set the number of simulated seconds per second from now on.

        Raises:
            WorkbenchError: if the flight cannot have that speed.
        """
        if not MIN_SPEED_FACTOR <= speed <= MAX_SPEED_FACTOR:
            raise WorkbenchError(
                f"the speed is {speed:g}: give it one from {MIN_SPEED_FACTOR:g} to "
                f"{MAX_SPEED_FACTOR:g}"
            )
        self._speed = speed
        self.restart(now)

    def restart(self, now: float) -> None:
        """Count as neither early nor late now."""
        self._origin = now
        self._flown = 0
        self._last_given_up = -math.inf
        self._marks: deque[tuple[float, int]] = deque([(now, 0)])

    def due(self, now: float) -> int:
        """Return how many steps to fly at once: none, or a slice."""
        if self._paused:
            return 0
        lag = self._lag(now)
        # a slow flight of long steps is behind by more until its next slice is due
        longest = max(MAX_FLIGHT_LAG_S, 2.0 * self.slice * self._step / self._speed)
        if lag > longest:
            self._given_up += lag - longest
            self._last_given_up = now
            self._origin += lag - longest
        self._worst_lag = max(self._worst_lag, lag)
        behind = math.floor(self._lag(now) * self._speed / self._step + 1e-6)
        return self.slice if behind >= self.slice else 0

    def flown(self, steps: int, now: float) -> None:
        """Record the flown steps."""
        self._flown += steps
        self._marks.append((now, self._flown))
        while now - self._marks[1][0] >= PACE_WINDOW_S:
            self._marks.popleft()

    def wait(self, now: float) -> float:
        """Return the time until the next slice is due [s], infinite while paused."""
        if self._paused:
            return math.inf
        return max(0.0, self.slice * self._step / self._speed - self._lag(now))

    def pace(self, now: float) -> Pace:
        """Return how well the flight keeps up; the lag is the largest since the last call."""
        began, flown = self._marks[0]
        wall = now - began
        achieved = (self._flown - flown) * self._step / wall if wall > 0.0 else self._speed
        worst, self._worst_lag = self._worst_lag, 0.0
        return Pace(
            asked=self._speed,
            achieved=0.0 if self._paused else achieved,
            lag=worst,
            given_up=self._given_up,
            slow=not self._paused and now - self._last_given_up < PACE_WINDOW_S,
        )

    def _lag(self, now: float) -> float:
        """Return the lag of the flight in wall time [s]."""
        return now - self._origin - self._flown * self._step / self._speed
