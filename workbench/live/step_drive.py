"""Apply a step of a command, of a setpoint of attitude or rate, or of a load during a flight."""

import dataclasses
import math
from collections.abc import Sequence

from workbench.parameters.parameter_table import flight_table
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import AXIS_NAMES, CommandAxis
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import Load
from workbench.scenario.scenario import Action, AttitudeSetpoint
from workbench.session.hover_attitude import (
    AT_REST_SHARE,
    AT_REST_SPEED,
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
        hover: from which an attitude steps.

    Raises:
        WorkbenchError: if the law has no setpoint that it needs.
    """

    def __init__(self, session: Session, excitation: Excitation) -> None:
        self._session, self._excitation, self._row = session, excitation, excitation.row
        self._size = size = abs(excitation.amplitude)
        self.hover = HoverAttitude()
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

    def begin_round(self) -> None:
        """Let an attitude step from the present one; from level if the drone is not at rest."""
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
