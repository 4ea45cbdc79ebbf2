"""Alarms of a live flight: what goes wrong, with what to do about it; each once while it lasts.

Those of battery and estimate are the announcer's.
"""

import cmath
import math
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np

from workbench.control.controller import Controller
from workbench.live.messages import Pace
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

LEAST_HIT = 0.6
"""A change of velocity of a hard hit, beyond what flying makes [m/s]; a landing makes 0.4."""


def hit_speed(vehicle: Vehicle, before: np.ndarray, after: np.ndarray, duration: float) -> float:
    """Return by how much a hit changed a velocity [m/s], 0 where flying explains the change.

    Args:
        vehicle: that flies.
        before: velocity (3) [m/s].
        after: velocity (3) [m/s].
        duration: between the two [s].
    """
    change = float(np.linalg.norm(after - before))
    flown = (1.0 + vehicle.thrust_to_weight) * GRAVITY * max(0.0, duration)
    return change if change > LEAST_HIT + flown else 0.0


PERIOD = 1 / 64
"""Between two looks at the motion [s]: a swing of 20 Hz is seen."""
LOOK = 1 / 16
"""Between two looks at everything else [s]."""
QUIET = 10.0
"""What has been away for so long is told again [s]."""
SEEN, PARTS = 2.0, 3
"""A swing is seen over this time [s], and in each of so many parts of it."""
LEAST_RATE, LEAST_SPEED = 0.6, 0.3
"""Of a swing to both sides [rad/s] and, up and down, [m/s]."""
TURNS, UNEVEN = 4, 0.3
"""A swing passes its middle so often at least, at times as even as this share."""
SLOW_SEEN = (5.0, 15.0)
"""A slow swing, of a velocity or position loop, is seen over one of these times [s]."""
SLOW_TURNS, SLOW_UNEVEN, STEADY = 5, 0.2, 0.6
"""It passes its middle so often at least, so evenly, and each wave is so large as the one before
at least: air that shakes has waves of all sizes, and a drone with damping of 0.16 comes to rest."""
SLOW_LOOK = 0.5
"""Between two looks for a slow swing [s]."""
LEAST_ASKED = 0.05
"""Of what a pilot asks for from one side to the other [m/s] or [rad/s]."""
ASKED_TURNS = 2
"""A pilot who asks for one side and the other so often within `SEEN` swings the drone himself."""
RESONANT, BLAMED = 1.25, 0.7
"""What swings by so many times what is asked of it is to blame, seen over whole waves for this
long at least [s]."""
ANGLES = ("1", "rad")
"""Units of the error of an attitude loop."""
SPEEDS = ("m/s",)
"""And of a velocity loop."""
FULL, FULL_TIME = 0.985, 0.5
"""A rotor at this share of its largest thrust for this long saturates [s]."""
SLOW_TIME = 2.0
"""Real time is lost where it is for so long [s of wall]."""
TOUCH_DOWN = 0.3
"""A hit this near the ground is a touch-down [m]."""
UPRIGHT, FASTEST_TOUCH_DOWN = 0.8, 4.0
"""And of a drone whose z axis points up by this much, and that sinks no faster [m/s]: others have
crashed."""


class Swing:
    """Finds a steady swing in a signal.

    Args:
        least: amplitude to both sides.
        seen: over which time [s].
        turns: how often it passes its middle, at least.
        uneven: spread of the times between, as a share of their mean, at most.
        steady: size of each half wave over that of the one before, at least.
    """

    def __init__(
        self,
        least: float,
        seen: float = SEEN,
        turns: int = TURNS,
        uneven: float = UNEVEN,
        steady: float = 0.0,
    ) -> None:
        self._least, self._span = least, seen
        self._turns, self._uneven, self._steady = turns, uneven, steady
        self._seen: deque[tuple[float, float]] = deque()

    def look(self, time: float, value: float) -> None:
        """Take the signal at a time [s]."""
        self._seen.append((time, value))
        while self._seen[0][0] < time - self._span - 1e-9:
            self._seen.popleft()

    def clear(self) -> None:
        """Forget what was seen."""
        self._seen.clear()

    @property
    def turns(self) -> int:
        """How often the signal passes its middle, evenly or not."""
        return len(self._passes()[2]) if self._seen else 0

    @property
    def frequency(self) -> float:
        """Of the swing that there is [Hz], 0 for none."""
        if not self._seen or self._seen[-1][0] - self._seen[0][0] < self._span - 2.0 * LOOK:
            return 0.0
        time, value, places = self._passes()
        if len(places) < self._turns:
            return 0.0
        parts = np.array_split(self._about_middle()[1], PARTS)
        if any(min(part.max(), -part.min()) < self._least for part in parts):
            return 0.0
        gaps = np.diff(time[places])
        if gaps.std() > self._uneven * gaps.mean():
            return 0.0
        # the first and the last half wave are seen in part
        sizes = np.maximum.reduceat(np.abs(value), places)[:-1]
        if (sizes[1:] < self._steady * sizes[:-1]).any():
            return 0.0
        return float(0.5 / gaps.mean())

    def _about_middle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the times [s] and the signal about its mean."""
        time, value = np.array(self._seen).T
        return time, value - value.mean()

    def _passes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times and signal outside a dead band, and where it has come to the other side.

        The dead band keeps noise around the middle from counting.
        """
        time, value = self._about_middle()
        kept = np.abs(value) > 0.3 * self._least
        time, value = time[kept], value[kept]
        return time, value, 1 + np.flatnonzero(np.diff(np.sign(value)))


class Alarms:
    """Watches a flight.

    Args:
        session: that is flown.
        told: told of every alarm: a sentence, and behind it what to do.
    """

    def __init__(self, session: Session, told: Callable[[str], None]) -> None:
        self._session, self._told = session, told
        self._step = session.scenario.rates.physics_step
        self._axes = {
            "roll": Swing(LEAST_RATE),
            "pitch": Swing(LEAST_RATE),
            "yaw": Swing(LEAST_RATE),
            "height": Swing(LEAST_SPEED),
        }
        self._asked = [Swing(LEAST_ASKED) for _ in range(4)]
        least = {"x": LEAST_SPEED, "y": LEAST_SPEED, "yaw": LEAST_RATE, "height": LEAST_SPEED}
        self._slow = {
            axis: [Swing(each, seen, SLOW_TURNS, SLOW_UNEVEN, STEADY) for seen in SLOW_SEEN]
            for axis, each in least.items()
        }
        self._slow_since = math.inf
        self.begin()

    def begin(self) -> None:
        """Begin with a new flight."""
        self._forget_swings()
        for swing in self._asked:
            swing.clear()
        self._wish: tuple[float, ...] = ()
        self._next_slow_look = 0.0
        self._last: dict[str, float] = {}
        self._full_since = self._slow_since = math.inf
        self._next_look = 0.0
        self._suspect: Suspect | None = None
        self._motion = self._session.state()

    def parts(self, steps: int) -> Iterator[int]:
        """Yield how many steps are to be flown one after the other, each followed by a look."""
        longest = max(1, round(PERIOD / self._step))
        while steps:
            part = min(steps, longest)
            yield part
            steps -= part

    def look(self, *, excited: bool) -> None:
        """Look at what the flight has become.

        Args:
            excited: whether something makes the drone swing on purpose.
        """
        session = self._session
        time, state = session.time, session.state()
        before, self._motion = self._motion, state
        if excited:
            self._suspect = None
            self._forget_swings()
        else:
            self._look_for_swing(time, state)
            self._look_for_slow_swing(time, state)
            self._look_at_suspect(time)
        self._look_for_hit(before, state, time)
        if time >= self._next_look:
            self._next_look = time + LOOK
            self._look_at(session.snapshot())

    def look_at_pace(self, pace: Pace, now: float) -> None:
        """Look at how the flight keeps its time.

        Args:
            pace: that it has.
            now: wall time [s].
        """
        if not pace.too_slow:
            self._slow_since = math.inf
            return
        self._slow_since = min(self._slow_since, now)
        if now - self._slow_since >= SLOW_TIME:
            self._alarm(
                "real time",
                f"the flight is slower than real time: {pace.text}",
                "Hide the 3-D view, fly with fewer sensors, or choose a lower speed",
            )

    def _look_for_swing(self, time: float, state: np.ndarray) -> None:
        w, x, y, z = state[0:4]
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        ahead, aside = math.cos(yaw), math.sin(yaw)
        values = {
            "roll": ahead * state[7] + aside * state[8],
            "pitch": ahead * state[8] - aside * state[7],
            "yaw": state[9],
            "height": state[12],
        }
        for axis, value in values.items():
            self._axes[axis].look(time, float(value))
        asked = self._session.asked
        for swing, value in zip(self._asked, asked, strict=True):
            swing.look(time, value)
        if time < self._next_look or any(swing.turns >= ASKED_TURNS for swing in self._asked):
            return
        found = {axis: swing.frequency for axis, swing in self._axes.items()}
        axis = next((axis for axis, frequency in found.items() if frequency), "")
        if not axis:
            if self._suspect is not None and not self._suspect.slow:
                self._suspect = None
        elif self._suspect is None or self._suspect.slow or self._suspect.axis != axis:
            law = self._session.controller
            self._suspect = Suspect(law, axis, found[axis], time)

    def _look_for_slow_swing(self, time: float, state: np.ndarray) -> None:
        """Look for a swing of a velocity or position loop, while one thing is asked for."""
        wish = self._session.asked
        if wish != self._wish or self._session.scenario.figure_eight:
            self._wish = wish
            self._forget_slow_swings()
            if self._suspect is not None and self._suspect.slow:
                self._suspect = None
            return
        if time < self._next_look:
            return
        values = {"x": state[10], "y": state[11], "yaw": state[9], "height": state[12]}
        for axis, value in values.items():
            for swing in self._slow[axis]:
                swing.look(time, float(value))
        if self._suspect is not None or time < self._next_slow_look:
            return
        self._next_slow_look = time + SLOW_LOOK
        for axis, swings in self._slow.items():
            frequency = next(filter(None, (swing.frequency for swing in swings)), 0.0)
            if frequency:
                held = not any(wish[:3])
                law = self._session.controller
                self._suspect = Suspect(law, axis, frequency, time, slow=True, held=held)
                return

    def _forget_slow_swings(self) -> None:
        for swings in self._slow.values():
            for swing in swings:
                swing.clear()

    def _forget_swings(self) -> None:
        for swing in self._axes.values():
            swing.clear()
        self._forget_slow_swings()

    def _look_at_suspect(self, time: float) -> None:
        """Find out which loop swings, and tell it."""
        suspect = self._suspect
        if suspect is None:
            return
        if suspect.needs_signals:
            now = self._session.snapshot()
            x, y, z = now.v_WB
            roll, pitch, _ = now.roll_pitch_yaw
            moves = {"roll": roll, "pitch": pitch, "x": x, "y": y, "height": z}
            update = round(time / self._session.scenario.rates.control_period)
            signals = self._session.loop_signals()
            suspect.look(time, moves[suspect.axis], signals, update)
        if suspect.is_known(time):
            loop, frequency = suspect.loop, suspect.frequency
            if suspect.axis in self._axes:
                frequency = self._axes[suspect.axis].frequency or frequency
            self._suspect = None
            digits = 1 if frequency >= 1.0 else 2
            self._alarm(
                "swing",
                f"the drone swings through {loop}, at {frequency:.{digits}f} Hz "
                f"({2.0 * math.pi * frequency:.{digits - 1}f} rad/s)",
                f"Bring the kept gains back (Ctrl+Shift+K), or give {loop} more phase margin: "
                "Tuning > Frequency",
            )

    def _look_for_hit(self, before: np.ndarray, state: np.ndarray, time: float) -> None:
        duration = PERIOD
        speed = hit_speed(self._session.vehicle, before[10:13], state[10:13], duration)
        if not speed:
            return
        self._suspect = None
        self._forget_swings()
        height = state[6] - self._session.vehicle.ground_clearance
        _, x, y, _ = state[0:4]
        upright = 1.0 - 2.0 * (x * x + y * y) > UPRIGHT
        if height < TOUCH_DOWN and -FASTEST_TOUCH_DOWN < before[12] < 0.0 and upright:
            self._alarm(
                "touch-down",
                f"hard touch-down, at {-before[12]:.1f} m/s",
                "Sink more slowly: landing_speed, and the gains of velocity z",
            )
        else:
            self._alarm(
                "collision",
                f"the drone has hit something hard at t = {time:.1f} s: its velocity changed by "
                f"{speed:.1f} m/s at once",
                "Reset, fly farther from obstacles, or switch on the obstacle brake",
            )

    def _look_at(self, now: Snapshot) -> None:
        limits = [rotor.max_thrust for rotor in self._session.vehicle.rotors]
        full = [
            number
            for number, (thrust, most) in enumerate(zip(now.thrusts, limits, strict=True), 1)
            if thrust >= FULL * most
        ]
        self._full_since = min(self._full_since, now.time) if full else math.inf
        if now.time - self._full_since >= FULL_TIME:
            rotors = " and ".join(str(number) for number in full)
            self._alarm(
                "saturation",
                f"rotor {rotors} is at its largest thrust"
                if len(full) == 1
                else f"rotors {rotors} are at their largest thrust",
                "Ask for less: gentler commands, lower gains, or less payload",
            )

    def _alarm(self, kind: str, said: str, remedy: str) -> None:
        """Tell of it, unless it has been so all the time."""
        now = self._session.time
        before = self._last.get(kind, -math.inf)
        self._last[kind] = now
        if now - before > QUIET:
            self._told(f"{said}. {remedy}")


class Suspect:
    """Finds out which loop along an axis makes the drone swing.

    A loop that amplifies what the loops around it ask of it is to blame; one that follows that is
    not, and the loop around it is: T = y / (y + e) at the frequency of the swing, of what the loop
    controls y and its error e. For a swing of roll and pitch that is the attitude's, and velocity
    is around it; for a slow one the velocity's, and position is around it where a place is held.

    Args:
        controller: that flies.
        axis: roll, pitch, yaw, height, or x and y of a slow swing.
        frequency: of the swing [Hz].
        begun: when it is looked at first [s].
        slow: whether it is one of a velocity or position loop.
        held: whether a place is held.
    """

    def __init__(
        self,
        controller: Controller,
        axis: str,
        frequency: float,
        begun: float,
        *,
        slow: bool = False,
        held: bool = False,
    ) -> None:
        self.axis, self.frequency, self._begun, self.slow = axis, frequency, begun, slow
        along = {"roll": "y", "pitch": "x", "height": "z"}.get(axis, axis)
        loops = [loop for loop in controller.loops if loop.axis == along]
        moving = [loop for loop in loops if not loop.hold]
        holding = [loop for loop in loops if loop.hold and slow and held]
        inner = {"roll": ANGLES, "pitch": ANGLES, "yaw": ()}.get(axis, SPEEDS if slow else ())
        follows = (loop for loop in moving if controller.points[loop.error] in inner)
        self._outer = next(iter(holding + moving), None)
        self._inner = next(follows, None)
        if self._inner is not None:
            self._place = controller.point_names.index(self._inner.error)
            self._divider = controller.point_dividers[self._inner.error]
        self._error = 0.0
        self._phasors = [0j, 0j]

    @property
    def needs_signals(self) -> bool:
        """Whether the law's signals tell more than the axis does."""
        return self._inner is not None and self._inner is not self._outer

    def look(self, time: float, value: float, signals: np.ndarray, update: int) -> None:
        """Take what the inner loop controls, and the signals at the loop points.

        Args:
            time: now [s].
            value: of the loop, in its unit.
            signals: that the next update sees.
            update: its number; a part that does not run in it says nothing of its signal.
        """
        if update % self._divider == 0:
            self._error = float(signals[self._place])
        turn = cmath.exp(-2j * math.pi * self.frequency * time)
        for index, each in enumerate((value, self._error)):
            self._phasors[index] += turn * each

    def is_known(self, time: float) -> bool:
        """Return whether enough was seen at a time [s]."""
        waves = math.ceil(BLAMED * self.frequency) / self.frequency
        return not self.needs_signals or time >= self._begun + waves

    @property
    def loop(self) -> str:
        """The loop to blame, in words."""
        if self._outer is None:
            return self.axis
        found = self._outer
        value, error = self._phasors
        if self._inner is not None and abs(value) > RESONANT * abs(value + error):
            found = self._inner
        return found.name.replace("_", " ")
