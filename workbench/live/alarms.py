"""Alarms of a live flight: each states a problem and its remedy, once while the problem lasts.

The announcer reports the battery and the estimate.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np

from workbench.control.flight_mode import MAX_HOVERING_SPEED
from workbench.control.mode import FlightMode, Reason
from workbench.live.messages import HardHit, Pace
from workbench.live.oscillation import ALARM_CHECK_PERIOD_S, OscillationDetector
from workbench.live.suspect import Suspect
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

MIN_HIT_M_S = 0.6
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
    return change if change > MIN_HIT_M_S + flown else 0.0


SAME_HIT_S = 1.0
"""Impacts within this time count as one hit [s]."""
MOTION_PERIOD_S = 1 / 64
"""Period between samples of the motion [s]: short enough to detect a swing of 20 Hz."""
ALARM_QUIET_S = 10.0
"""An alarm is repeated if its cause was absent for this long [s]."""
MIN_SWING_RATE_RAD_S, MIN_SWING_SPEED_M_S = 0.6, 0.3
"""Least amplitude of a swing: of rates [rad/s], and of vertical speed [m/s]."""
SLOW_SWING_WINDOWS_S = (5.0, 15.0)
"""A slow swing, of a velocity or position loop, is detected over one of these times [s]."""
MIN_SLOW_SWING_TURNS = 5
MAX_SLOW_UNEVENNESS = 0.2
MIN_HALF_WAVE_RATIO = 0.6
"""Least crossings of the mean, largest relative spread of the times between, and least ratio of
each half wave to the one before: waves in turbulence vary in size, and a drone with a damping ratio
of 0.16 comes to rest."""
SLOW_CHECK_PERIOD_S = 0.5
"""Period between checks for a slow swing [s]."""
MIN_PILOT_COMMAND = 0.05
"""Least command of a pilot that counts as a change of side [m/s] or [rad/s]."""
PILOT_SWING_TURNS = 2
"""A pilot whose command changes side this often within `SWING_WINDOW_S` causes the swing
himself."""
SATURATED_THRUST_SHARE, SATURATED_TIME_S = 0.985, 0.5
"""A rotor at this share of its largest thrust for this long [s] is saturated."""
HIT_ALARMS = ("fall", "ground", "collision")
"""Alarms that only a reset ends."""
MIN_SUNK_M, NOT_SUNK_TIME_S = 0.1, 10.0
"""A landing that has sunk by less [m] within this time [s] does not sink."""
BEHIND_TIME_S = 2.0
"""Time of falling behind real time before the alarm [s of wall]."""
TOUCH_DOWN_HEIGHT_M = 0.3
"""A hit below this height above the ground can be a touch-down [m]."""
MIN_UPRIGHT_Z, MAX_TOUCH_DOWN_M_S = 0.8, 4.0
"""A touch-down also needs a drone whose z axis points up by at least this much and that sinks no
faster than this [m/s]; otherwise it is a crash."""

_FALL_REMEDIES = {
    Reason.NONE: "Reset to fly again; come down by Land, as STOP switches the rotors off",
    Reason.BATTERY_EMPTY: "Reset to fly again; land before the battery is empty",
    Reason.IMU_FAILED: "Repair the IMU, then reset",
}
"""What to do after a fall, by what switched the rotors off; NONE is a pilot's STOP."""


class Alarms:
    """Watches a flight.

    Args:
        session: the flown session.
        told: called with every alarm: a sentence, and what to do about it.

    Attributes:
        hit: the last hard hit, None without one.
    """

    def __init__(self, session: Session, told: Callable[[str], None]) -> None:
        self._session, self._told = session, told
        rates = session.scenario.rates
        self._longest = rates.control_steps * max(1, round(MOTION_PERIOD_S / rates.control_period))
        self._axes = {
            "roll": OscillationDetector(MIN_SWING_RATE_RAD_S),
            "pitch": OscillationDetector(MIN_SWING_RATE_RAD_S),
            "yaw": OscillationDetector(MIN_SWING_RATE_RAD_S),
            "height": OscillationDetector(MIN_SWING_SPEED_M_S),
        }
        self._asked = [OscillationDetector(MIN_PILOT_COMMAND) for _ in range(4)]
        least = {
            "x": MIN_SWING_SPEED_M_S,
            "y": MIN_SWING_SPEED_M_S,
            "yaw": MIN_SWING_RATE_RAD_S,
            "height": MIN_SWING_SPEED_M_S,
        }
        self._slow = {
            axis: [
                OscillationDetector(
                    each, seen, MIN_SLOW_SWING_TURNS, MAX_SLOW_UNEVENNESS, MIN_HALF_WAVE_RATIO
                )
                for seen in SLOW_SWING_WINDOWS_S
            ]
            for axis, each in least.items()
        }
        self._slow_since = math.inf
        self.begin()

    def begin(self) -> None:
        """Start again with a new flight."""
        self.hit: HardHit | None = None
        self._forget_swings()
        for swing in self._asked:
            swing.clear()
        self._wish: tuple[float, ...] = ()
        self._next_slow_look = 0.0
        self._last: dict[str, float] = {}
        self._said: dict[str, str] = {}
        self._full_since = self._slow_since = math.inf
        self._lowest, self._sunk_at = math.inf, 0.0
        self._next_look = 0.0
        self._suspect: Suspect | None = None
        self._motion = self._session.state()

    @property
    def lasting(self) -> tuple[str, ...]:
        """What the alarms say whose cause was present lately, but for those of a hit."""
        since = self._session.time - ALARM_QUIET_S
        return tuple(
            said
            for kind, said in self._said.items()
            if kind not in HIT_ALARMS and self._last[kind] >= since
        )

    def parts(self, steps: int) -> Iterator[int]:
        """Yield numbers of steps to fly one after the other; a sample follows each."""
        while steps:
            part = min(steps, self._longest)
            yield part
            steps -= part

    def look_for_hit(self, before: np.ndarray, duration: float) -> None:
        """Note a hard hit.

        Args:
            before: velocity before a flown part (3) [m/s].
            duration: time of that part [s].
        """
        session = self._session
        speed = hit_speed(session.vehicle, before, session.state()[10:13], duration)
        again = self.hit is not None and session.time - self.hit.time < SAME_HIT_S
        if speed and not again:
            self.hit = HardHit(session.time, speed)

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
        self._tell_hit(before, state, time)
        if time >= self._next_look:
            self._next_look = time + ALARM_CHECK_PERIOD_S
            self._look_at(session.snapshot())

    def look_at_pace(self, pace: Pace, now: float) -> None:
        """Check whether the flight keeps up with real time.

        Args:
            pace: its pace.
            now: wall time [s].
        """
        if not pace.too_slow:
            self._slow_since = math.inf
            self._said.pop("real time", None)
            return
        self._slow_since = min(self._slow_since, now)
        if now - self._slow_since >= BEHIND_TIME_S:
            self._alarm(
                "real time",
                f"the flight is slower than real time: {pace.text}",
                "Choose a lower speed, fly with fewer sensors, or hide the 3-D view if it is open",
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
        if time < self._next_look or any(swing.turns >= PILOT_SWING_TURNS for swing in self._asked):
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
        self._next_slow_look = time + SLOW_CHECK_PERIOD_S
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
            signals = self._session.loop_signals()
            suspect.look(time, moves[suspect.axis], signals)
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

    def _tell_hit(self, before: np.ndarray, state: np.ndarray, time: float) -> None:
        duration = MOTION_PERIOD_S
        speed = hit_speed(self._session.vehicle, before[10:13], state[10:13], duration)
        if not speed:
            return
        self._suspect = None
        self._forget_swings()
        height = state[6] - self._session.vehicle.ground_clearance
        _, x, y, _ = state[0:4]
        upright = 1.0 - 2.0 * (x * x + y * y) > MIN_UPRIGHT_Z
        at_ground, now = height < TOUCH_DOWN_HEIGHT_M, self._session.snapshot()
        if now.mode is FlightMode.OFF:
            why = f" ({now.reason.label})" if now.reason is not Reason.NONE else ""
            self._alarm(
                "fall",
                f"the drone fell with its rotors off{why}, and hit something at "
                f"{np.linalg.norm(before[10:13]):.1f} m/s",
                _FALL_REMEDIES.get(now.reason, "Reset to fly again"),
            )
        elif at_ground and -MAX_TOUCH_DOWN_M_S < before[12] < 0.0 and upright:
            self._alarm(
                "touch-down",
                f"hard touch-down, at {-before[12]:.1f} m/s",
                "Sink more slowly: landing_speed, and the gains of velocity z",
            )
        elif at_ground:
            self._alarm(
                "ground",
                f"the drone has hit the ground at {np.linalg.norm(before[10:13]):.1f} m/s",
                "Reset, then fly higher, or bring the kept gains back (Ctrl+Shift+K) if it did "
                "not follow its commands",
            )
        else:
            self._alarm(
                "collision",
                f"the drone has hit something hard at t = {time:.1f} s: its velocity changed by "
                f"{speed:.1f} m/s at once",
                "Reset, fly farther from obstacles, or switch on the obstacle brake",
            )

    def _look_at_landing(self, now: Snapshot) -> None:
        """Check whether a landing sinks; its rotors go on meanwhile, as it is in the air."""
        if now.mode is not FlightMode.LANDING:
            self._lowest = math.inf
            self._said.pop("landing", None)
            return
        height = now.p_WB[2] - self._session.vehicle.ground_clearance
        if height < self._lowest - MIN_SUNK_M:
            self._lowest, self._sunk_at = height, now.time
            self._said.pop("landing", None)
        elif now.time - self._sunk_at >= NOT_SUNK_TIME_S:
            updraft, speed = self._session.get("wind_z"), math.hypot(*now.v_WB[:2])
            why = "it may stand on something"
            if speed > MAX_HOVERING_SPEED:
                why = f"it has to brake first, and still moves at {speed:.1f} m/s"
            elif updraft >= self._session.get("landing_speed"):
                why = f"the air rises at {updraft:.3g} m/s"
            self._alarm(
                "landing",
                f"the drone does not sink, though it has been landing for over "
                f"{NOT_SUNK_TIME_S:g} s, at {height:.1f} m: {why}",
                "Its rotors go on: hold, and land elsewhere or in calmer air",
            )

    def _look_at(self, now: Snapshot) -> None:
        self._look_at_landing(now)
        limits = [rotor.max_thrust for rotor in self._session.vehicle.rotors]
        full = [
            number
            for number, (thrust, most) in enumerate(zip(now.thrusts, limits, strict=True), 1)
            if thrust >= SATURATED_THRUST_SHARE * most
        ]
        self._full_since = min(self._full_since, now.time) if full else math.inf
        if now.time - self._full_since >= SATURATED_TIME_S:
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
        is_told = now - self._last.get(kind, -math.inf) > ALARM_QUIET_S
        if is_told:
            self._said[kind] = said
            self._told(f"{said}. {remedy}")
        if kind in self._said:  # one that has ended is told again once it was quiet for so long
            self._last[kind] = now
