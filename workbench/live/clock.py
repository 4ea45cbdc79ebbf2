"""Which physics steps are due, for a flight that keeps up with the wall clock.

It looks at no clock itself: every method is told the time, so that it can be tried with any.
"""

import math
from collections import deque

from workbench.live.messages import Pace

LONGEST_LAG = 0.25
"""Of the flight behind the wall clock; what is more is given up and never flown [s of wall].

A machine with other work keeps a process waiting for a tenth of a second now and then; that is
caught up within a hundredth.
"""
SLICE = 1 / 128
"""Wall time that is flown at once; between slices a pilot is heard [s]."""
WINDOW = 1.0
"""Over which the real-time factor is taken [s of wall]."""
SLOWEST, FASTEST = 0.01, 20.0
"""Bounds of the speed; beyond the upper one few machines keep up."""


class FlightClock:
    """Tells how many steps to fly now, and how well that goes.

    A flight that has fallen behind by more than `LONGEST_LAG` does not run after the wall clock:
    it goes on from where it is, and `pace` says so.

    Args:
        step: simulated time of a physics step [s].
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
        """Steps that are flown at once."""
        return max(1, round(self._speed * SLICE / self._step))

    def pause(self) -> None:
        """Let no step be due."""
        self._paused = True

    def resume(self, now: float) -> None:
        """Let steps be due from now on."""
        if self._paused:
            self._paused = False
            self.restart(now)

    def set_speed(self, speed: float, now: float) -> None:
        """Fly so many seconds in a second from now on."""
        self._speed = speed
        self.restart(now)

    def restart(self, now: float) -> None:
        """Be neither early nor late now."""
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
        longest = max(LONGEST_LAG, 2.0 * self.slice * self._step / self._speed)
        if lag > longest:
            self._given_up += lag - longest
            self._last_given_up = now
            self._origin += lag - longest
        self._worst_lag = max(self._worst_lag, lag)
        behind = math.floor(self._lag(now) * self._speed / self._step + 1e-6)
        return self.slice if behind >= self.slice else 0

    def flown(self, steps: int, now: float) -> None:
        """Take note of what was flown."""
        self._flown += steps
        self._marks.append((now, self._flown))
        while now - self._marks[1][0] >= WINDOW:
            self._marks.popleft()

    def wait(self, now: float) -> float:
        """Return how long it is until the next slice is due [s], infinite in a pause."""
        if self._paused:
            return math.inf
        return max(0.0, self.slice * self._step / self._speed - self._lag(now))

    def pace(self, now: float) -> Pace:
        """Return how well the flight keeps up; the lag is the worst one since the last call."""
        began, flown = self._marks[0]
        wall = now - began
        achieved = (self._flown - flown) * self._step / wall if wall > 0.0 else self._speed
        worst, self._worst_lag = self._worst_lag, 0.0
        return Pace(
            asked=self._speed,
            achieved=0.0 if self._paused else achieved,
            lag=worst,
            given_up=self._given_up,
            slow=not self._paused and now - self._last_given_up < WINDOW,
        )

    def _lag(self, now: float) -> float:
        """Return by how much wall time the flight is behind [s]."""
        return now - self._origin - self._flown * self._step / self._speed
