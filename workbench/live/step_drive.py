"""Apply a step of a command, of a setpoint of attitude or rate, or of a load during a flight."""

import dataclasses
import math
from collections import deque
from collections.abc import Sequence

from workbench.parameters.parameter_table import flight_table
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import AXIS_NAMES, CommandAxis
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import Load
from workbench.scenario.scenario import Action, AttitudeSetpoint
from workbench.session.drift import (
    NEVER_STEADY,
    NOT_STEADY,
    WIND_SPEEDS,
    drift_commands,
    moving_speed,
    steady_window,
)
from workbench.session.hover_attitude import (
    AT_REST_SHARE,
    AT_REST_SPEED,
    AT_REST_TIME_S,
    HoverAttitude,
    attitude_unrest,
    hover_attitude,
)
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

MAX_STRAY, MAX_STRAY_TIME_S = 0.5, 0.5
"""Allowed drift between rounds without a rest: this distance, plus this time at the amplitude [m]
or [rad], [s]."""
LOADED_YAW_RATE_RAD_S = 0.5
"""Largest yaw rate during the return from a load [rad/s]."""
NO_DRIFT_BEFORE = "in wind it begins at a held point, and not at the drift: fly a step or a doublet"
"""Why an excitation without a rest has no numbers in wind."""


class StepDrive:
    """Turns the value of an excitation into an action of a flight.

    A value along an axis is commanded. One of an attitude or a rate is a setpoint, from that of the
    hover before; 0 ends it. A load pushes or blows by it, while the drone holds.

    Args:
        session: the flown session.
        excitation: that it flies.

    Attributes:
        limit: largest allowed amplitude, of an attitude from level.
        stray: allowed drift between rounds without a rest [m] or [rad].
        turn_rate: largest yaw rate during the return [rad/s].
        hover: from which an attitude steps, or a velocity from its drift in wind.

    Raises:
        WorkbenchError: if the law has no setpoint that it needs.
    """

    def __init__(self, session: Session, excitation: Excitation) -> None:
        self._session, self._excitation, self._row = session, excitation, excitation.row
        self._size = size = abs(excitation.amplitude)
        self.hover = HoverAttitude()
        self._seen: deque[tuple[float, float]] = deque()
        self._is_steady = False
        self.stray, self.turn_rate = MAX_STRAY, LOADED_YAW_RATE_RAD_S
        match excitation.row:
            case Load() as load:
                self.limit = flight_table().find(load.limit).maximum
            case AttitudeAxis() as axis:
                axis.check(session.controller)
                self.begin_round()
                tilt = axis.largest_tilt(1.0, excitation.longest_level)
                self.limit = session.get(axis.limit) / tilt
            case CommandAxis() as axis:
                self.limit = session.get(axis.limit)
                self.stray, self.turn_rate = MAX_STRAY + MAX_STRAY_TIME_S * size, size

    def unrest(self) -> float:
        """Return the motion over the largest one at rest; below 1 the drone is at rest."""
        now = self._session.snapshot()
        match self._row:
            case Load(turns=turns):
                return _speed(now, turns=turns) / AT_REST_SPEED
            case AttitudeAxis():
                return attitude_unrest(self._session, self._size)
            case CommandAxis(turns=turns):
                return _speed(now, turns=turns) / min(AT_REST_SPEED, AT_REST_SHARE * self._size)

    @property
    def drifts(self) -> bool:
        """Whether it steps a command from the drift in wind; in turbulence none is steady."""
        steady = self._blows and not self._session.get("turbulence")
        return steady and self._excitation.rests and isinstance(self._row, CommandAxis)

    def begin_drift(self) -> Action:
        """Return the action by which the drone steers at no speed, and holds no point."""
        self._seen.clear()
        self._is_steady = False
        before, _ = drift_commands(self._excitation.axis, self._excitation.amplitude)
        return Action(velocity=before[:3], yaw_rate=before[3])

    def drifts_steadily(self) -> bool:
        """Note the present velocity or rate, and return whether it has been steady for long."""
        kept = max(AT_REST_TIME_S, steady_window(self._excitation.longest_level))
        now, seen = self._session.time, self._seen
        seen.append((now, self._moved()))
        while len(seen) > 1 and seen[1][0] <= now - kept:
            seen.popleft()
        speeds = [speed for _, speed in seen]
        spread = max(speeds) - min(speeds)
        is_known = now - seen[0][0] >= kept
        self._is_steady = is_known and spread <= AT_REST_SHARE * self._size
        return self._is_steady

    def why_unsteady(self) -> str:
        """Return why steps of a command have no steady state in the air that blows now, or ""."""
        if not isinstance(self._row, CommandAxis) or not self._blows:
            return ""
        moves = abs(self._moved() - self.hover.angle) > self._fastest
        if self._session.get("turbulence"):
            return NEVER_STEADY if moves else ""
        if not self._excitation.rests:
            return NO_DRIFT_BEFORE
        return "" if self._is_steady else NOT_STEADY

    @property
    def _blows(self) -> bool:
        """Whether the air moves now; a gust that is over does not."""
        now = self._session.time - self._session.get("gust_start")
        gusts = 0.0 <= now < self._session.get("gust_duration")
        names = (name for name in WIND_SPEEDS if gusts or not name.startswith("gust"))
        return any(self._session.get(name) for name in names)

    @property
    def _fastest(self) -> float:
        return moving_speed(self._size, is_estimated=self._session.scenario.is_estimated)

    def _moved(self) -> float:
        """Return the velocity [m/s] or the rate [rad/s] along the axis of a command."""
        now = self._session.snapshot()
        return float((*now.v_WB, now.w_WB[2])[AXIS_NAMES.index(self._excitation.axis)])

    def begin_round(self) -> None:
        """Let it step from the present attitude or drift; from level or rest if that moves."""
        if isinstance(self._row, CommandAxis):
            self._is_steady &= self.drifts  # the air may have changed since an earlier round
            drift = self._moved() if self._is_steady else 0.0
            self.hover = HoverAttitude(drift if abs(drift) > self._fastest else 0.0)
        if isinstance(self._row, AttitudeAxis):
            rests = self.unrest() < 1.0
            hover = hover_attitude(self._session, self._row, self._size) if rests else None
            self.hover = hover or HoverAttitude()

    def check_tilt(self) -> None:
        """Refuse an attitude that would tilt the drone further than it may, from the hover.

        Raises:
            WorkbenchError: that says what to give instead.
        """
        if isinstance(self._row, AttitudeAxis):
            asked, most = self._excitation, self._session.get(self._row.limit)
            both = asked.shape not in (Shape.STEP, Shape.PULSE)
            for size in (asked.amplitude, -asked.amplitude) if both else (asked.amplitude,):
                self._row.check_tilt(size, asked.longest_level, most, self.hover.setpoint)

    def action(self, value: float, duration: float) -> Action:
        """Return the action of a value for at most a time [s]; the drone holds otherwise."""
        match self._row:
            case CommandAxis(name=name):
                numbers = [value if axis == name else 0.0 for axis in AXIS_NAMES]
                return Action(velocity=numbers[:3], yaw_rate=numbers[3])
            case AttitudeAxis() as axis:
                action = Action(setpoint=AttitudeSetpoint())
                if value:
                    action = axis.action(self.hover.setpoint + value)
            case Load() as load:
                action = self._load_with(load, value, duration)
        return dataclasses.replace(action, velocity=[0.0] * 3, yaw_rate=0.0)

    def left_behind(self, value: float) -> Action | None:
        """Return the action that ends what a value still does when someone else takes control."""
        if not value:
            return None
        match self._row:
            case CommandAxis(name=name):
                asked = self._session.snapshot().reference[AXIS_NAMES.index(name)]
                return self.action(0.0, 0.0) if asked == value else None
            case AttitudeAxis():
                return Action(setpoint=AttitudeSetpoint())
            case Load() as load:
                return self._load_with(load, 0.0, 0.0)

    def home(self, p_WB: Sequence[float]) -> Action:
        """Return the action that sends the drone back to a place in W [m]."""
        setpoint = AttitudeSetpoint() if isinstance(self._row, AttitudeAxis) else None
        return Action(go_to=list(p_WB), setpoint=setpoint)

    def _load_with(self, load: Load, value: float, duration: float) -> Action:
        least = flight_table().find("push_duration").minimum
        return load.action(value, max(duration, least), self._session.vehicle.p_BoBcm_B)


def _speed(now: Snapshot, *, turns: bool) -> float:
    """Return the yaw rate of what turns the drone [rad/s], else its speed [m/s]."""
    return abs(now.w_WB[2]) if turns else math.hypot(*now.v_WB)
