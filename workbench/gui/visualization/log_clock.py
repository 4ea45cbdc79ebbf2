"""Where a log is played, and how fast."""

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
STEP = 0.1
"""Time of a single step [s]."""


class LogClock:
    """A time within a log that runs, stands, or is moved.

    Args:
        begin: time of the log's first sample [s].
        end: of its last one [s].

    Attributes:
        begin: see there.
        end: see there.
        time: that is shown [s].
        speed: seconds of the log in a second.
        plays: whether it runs.
        loops: whether it begins again at the end.
    """

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end = begin, max(begin, end)
        self.time = self.end
        self.speed = 1.0
        self.plays = False
        self.loops = False

    def play(self) -> None:
        """Run; from the start if it stands at the end."""
        if self.time >= self.end:
            self.time = self.begin
        self.plays = True

    def pause(self) -> None:
        """Stand."""
        self.plays = False

    def go_to(self, time: float) -> None:
        """Show a time [s]."""
        self.time = min(max(time, self.begin), self.end)

    def step(self, steps: int) -> None:
        """Stand, and show a time some steps later."""
        self.pause()
        self.go_to(self.time + STEP * steps)

    def advance(self, passed: float) -> None:
        """Let a wall time pass [s]."""
        if not self.plays:
            return
        self.time += self.speed * passed
        if self.time >= self.end:
            duration = self.end - self.begin
            if self.loops and duration > 0.0:
                self.time = self.begin + (self.time - self.begin) % duration
            else:
                self.time = self.end
                self.plays = False
