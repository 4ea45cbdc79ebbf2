"""Alarms of a live flight: each states a problem and its remedy, once while the problem lasts.

The announcer reports the battery and the estimate.
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
"""Least change of velocity of a hard hit beyond what flight explains [m/s]; a landing makes 0.4."""


def hit_speed(vehicle: Vehicle, before: np.ndarray, after: np.ndarray, duration: float) -> float:
    """Return the change of velocity caused by a hit [m/s], 0 if flight explains the change.

    Args:
        vehicle: the flying vehicle.
        before: velocity before (3) [m/s].
        after: velocity after (3) [m/s].
        duration: time between the two [s].
    """
    change = float(np.linalg.norm(after - before))
    flown = (1.0 + vehicle.thrust_to_weight) * GRAVITY * max(0.0, duration)
    return change if change > LEAST_HIT + flown else 0.0


PERIOD = 1 / 64
"""Period between samples of the motion [s]: short enough to detect a swing of 20 Hz."""
LOOK = 1 / 16
"""Period between checks of everything else [s]."""
QUIET = 10.0
"""An alarm is repeated if its cause was absent for this long [s]."""
SEEN = 2.0
PARTS = 3
"""A swing is detected over this time [s], and must be present in each of this number of parts."""
LEAST_RATE, LEAST_SPEED = 0.6, 0.3
"""Least amplitude of a swing: of rates [rad/s], and of vertical speed [m/s]."""
TURNS = 4
UNEVEN = 0.3
"""A swing crosses its mean at least this often, at times with at most this relative spread."""
SLOW_SEEN = (5.0, 15.0)
"""A slow swing, of a velocity or position loop, is detected over one of these times [s]."""
SLOW_TURNS = 5
SLOW_UNEVEN = 0.2
STEADY = 0.6
"""Least crossings of the mean, largest relative spread of the times between, and least ratio of
each half wave to the one before: waves in turbulence vary in size, and a drone with a damping ratio
of 0.16 comes to rest."""
SLOW_LOOK = 0.5
"""Period between checks for a slow swing [s]."""
LEAST_ASKED = 0.05
"""Least command of a pilot that counts as a change of side [m/s] or [rad/s]."""
ASKED_TURNS = 2
"""A pilot whose command changes side this often within `SEEN` causes the swing himself."""
RESONANT, BLAMED = 1.25, 0.7
"""A loop that amplifies its command by this factor causes the swing, observed over whole waves for
at least this time [s]."""
ANGLES = ("1", "rad")
"""Units of the error of an attitude loop."""
SPEEDS = ("m/s",)
"""Units of the error of a velocity loop."""
FULL, FULL_TIME = 0.985, 0.5
"""A rotor at this share of its largest thrust for this long [s] is saturated."""
SLOW_TIME = 2.0
"""Time of falling behind real time before the alarm [s of wall]."""
TOUCH_DOWN = 0.3
"""A hit below this height above the ground can be a touch-down [m]."""
UPRIGHT, FASTEST_TOUCH_DOWN = 0.8, 4.0
"""A touch-down also needs a drone whose z axis points up by at least this much and that sinks no
faster than this [m/s]; otherwise it is a crash."""


class Swing:
    """Detects a steady swing in a signal.

    Args:
        least: least amplitude to each side.
        seen: observed time [s].
        turns: least number of crossings of the mean.
        uneven: largest spread of the times between crossings, as a share of their mean.
        steady: least ratio of each half wave to the one before.
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
        """Add the signal's value at a time [s]."""
        self._seen.append((time, value))
        while self._seen[0][0] < time - self._span - 1e-9:
            self._seen.popleft()

    def clear(self) -> None:
        """Forget all values."""
        self._seen.clear()

    @property
    def turns(self) -> int:
        """Number of crossings of the mean, even or not."""
        return len(self._passes()[2]) if self._seen else 0

    @property
    def frequency(self) -> float:
        """Frequency of the present swing [Hz], 0 for none."""
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
        # the first and the last half wave are incomplete
        sizes = np.maximum.reduceat(np.abs(value), places)[:-1]
        if (sizes[1:] < self._steady * sizes[:-1]).any():
            return 0.0
        return float(0.5 / gaps.mean())

    def _about_middle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the times [s] and the signal minus its mean."""
        time, value = np.array(self._seen).T
        return time, value - value.mean()

    def _passes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times and signal outside a dead band, and the indices at which the sign changes.

        The dead band suppresses crossings caused by noise.
        """
        time, value = self._about_middle()
        kept = np.abs(value) > 0.3 * self._least
        time, value = time[kept], value[kept]
        return time, value, 1 + np.flatnonzero(np.diff(np.sign(value)))


class Alarms:
    """Watches a flight.

    Args:
        session: the flown session.
        told: called with every alarm: a sentence, and what to do about it.
    """

    def __init__(self, session: Session, told: Callable[[str], None]) -> None:
        self._session, self._told = session, told
        rates = session.scenario.rates
        self._longest = rates.control_steps * max(1, round(PERIOD / rates.control_period))
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
        """Start again with a new flight."""
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
        """Yield numbers of steps to fly one after the other; a sample follows each."""
        while steps:
            part = min(steps, self._longest)
            yield part
            steps -= part

    def look(self, *, excited: bool) -> None:
        """Check the present state of the flight.

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
        """Check whether the flight keeps up with real time.

        Args:
            pace: its pace.
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
        """Look for a swing of a velocity or position loop while the command is constant."""
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
        """Find out which loop swings, and report it."""
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
                f"the drone oscillates in the loop {loop}, at {frequency:.{digits}f} Hz "
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
        """Report an alarm, unless its cause has been present all the time."""
        now = self._session.time
        before = self._last.get(kind, -math.inf)
        self._last[kind] = now
        if now - before > QUIET:
            self._told(f"{said}. {remedy}")


class Suspect:
    """Finds out which loop along an axis causes a swing.

    The loop that amplifies its command is the cause. A loop that only follows its command is not;
    then the loop around it is. With T = y / (y + e) at the frequency of the swing, y is the
    controlled signal of a loop and e its error. For a swing of roll and pitch the inner loop is
    attitude and the outer one velocity; for a slow swing the inner one is velocity, and the outer
    one position while the position is held.

    Args:
        controller: the flying controller.
        axis: roll, pitch, yaw, height, or x and y of a slow swing.
        frequency: frequency of the swing [Hz].
        begun: time at which observation starts [s].
        slow: whether it is a swing of a velocity or position loop.
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
        """Whether the law's signals are needed beside the axis's own."""
        return self._inner is not None and self._inner is not self._outer

    def look(self, time: float, value: float, signals: np.ndarray, update: int) -> None:
        """Add the inner loop's controlled signal, and the signals at the loop points.

        Args:
            time: present time [s].
            value: controlled signal, in its unit.
            signals: signals that the next update reads.
            update: number of that update; a part of the law that does not run in it leaves its
                signal out.
        """
        if update % self._divider == 0:
            self._error = float(signals[self._place])
        turn = cmath.exp(-2j * math.pi * self.frequency * time)
        for index, each in enumerate((value, self._error)):
            self._phasors[index] += turn * each

    def is_known(self, time: float) -> bool:
        """Return whether enough was observed by a time [s]."""
        waves = math.ceil(BLAMED * self.frequency) / self.frequency
        return not self.needs_signals or time >= self._begun + waves

    @property
    def loop(self) -> str:
        """The loop that causes the swing, in words."""
        if self._outer is None:
            return self.axis
        found = self._outer
        value, error = self._phasors
        if self._inner is not None and abs(value) > RESONANT * abs(value + error):
            found = self._inner
        return found.name.replace("_", " ")
