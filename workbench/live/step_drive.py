"""Apply a step of a command, of a setpoint of attitude or rate, or of a load during a flight."""

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

from workbench.parameters.parameter_table import flight_table
from workbench.plant.gravity import GRAVITY
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import AXIS_NAMES, CommandAxis
from workbench.scenario.excitation import Excitation
from workbench.scenario.loads import Load
from workbench.scenario.scenario import Action, AttitudeSetpoint
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

MAX_STRAY, MAX_STRAY_TIME_S = 0.5, 0.5
"""Allowed drift between rounds without a rest: this distance, plus this time at the amplitude [m]
or [rad], [s]."""
AT_REST_SPEED = 0.05
"""Speed below which a drone counts as at rest [m/s] or [rad/s] …"""
AT_REST_SHARE = 0.01
"""… and before a step of a command or a setpoint, if what it changes is below this share of the
step: half of what its numbers allow, see `step_metrics` …"""
AT_REST_TIME_S = 1.0
"""… an attitude within this time."""
LOADED_YAW_RATE_RAD_S = 0.5
"""Largest yaw rate during the return from a load [rad/s]."""


class StepDrive(ABC):
    """Turns the value of an excitation into an action of a flight.

    Attributes:
        limit: largest allowed amplitude.
        stray: allowed drift between rounds without a rest [m] or [rad].
        turn_rate: largest yaw rate during the return [rad/s].
    """

    limit: float
    stray, turn_rate = MAX_STRAY, LOADED_YAW_RATE_RAD_S

    @abstractmethod
    def unrest(self) -> float:
        """Return the motion over the largest one at rest; below 1 the drone is at rest."""

    @abstractmethod
    def action(self, value: float, duration: float) -> Action:
        """Return the action of a value for at most a time [s]; the drone holds otherwise."""

    @abstractmethod
    def left_behind(self, value: float) -> Action | None:
        """Return the action that ends what a value still does when someone else takes control."""

    def home(self, p_WB: Sequence[float]) -> Action:
        """Return the action that sends the drone back to a place in W [m]."""
        return Action(go_to=list(p_WB))


class SetpointDrive(StepDrive):
    """Commands the value along an axis.

    Args:
        session: the flown session.
        axis: axis of the command.
        amplitude: amplitude of the excitation [m/s] or [rad/s].
    """

    def __init__(self, session: Session, axis: CommandAxis, amplitude: float) -> None:
        self._session, self._axis = session, axis
        self.limit = session.get(axis.limit)
        self.stray = MAX_STRAY + MAX_STRAY_TIME_S * abs(amplitude)
        self._rest_speed = min(AT_REST_SPEED, AT_REST_SHARE * abs(amplitude))
        self.turn_rate = abs(amplitude)

    def unrest(self) -> float:
        now = self._session.snapshot()
        return _speed(now, turns=self._axis.turns) / self._rest_speed

    def action(self, value: float, duration: float) -> Action:
        numbers = [value if axis == self._axis.name else 0.0 for axis in AXIS_NAMES]
        return Action(velocity=numbers[:3], yaw_rate=numbers[3])

    def left_behind(self, value: float) -> Action | None:
        asked = self._session.snapshot().reference[AXIS_NAMES.index(self._axis.name)]
        return self.action(0.0, 0.0) if value and asked == value else None


class AttitudeDrive(StepDrive):
    """Gives the value as a setpoint of attitude or rate; 0 ends it.

    Args:
        session: the flown session.
        axis: axis of the setpoint.
        excitation: that it flies.

    Raises:
        WorkbenchError: if the law has no such setpoint.
    """

    def __init__(self, session: Session, axis: AttitudeAxis, excitation: Excitation) -> None:
        axis.check(session.controller)
        self._session, self._axis = session, axis
        self._rest_size = AT_REST_SHARE * abs(excitation.amplitude)
        self.limit = session.get(axis.limit) / axis.largest_tilt(1.0, excitation.longest_level)

    def unrest(self) -> float:
        now = self._session.snapshot()  # in wind a drone is at rest with a tilt
        turned = AT_REST_TIME_S * math.hypot(*now.w_WB)
        tilted = math.hypot(*now.vdot_WB[:2]) / GRAVITY  # from that of rest
        return max(_speed(now, turns=False) / AT_REST_SPEED, max(turned, tilted) / self._rest_size)

    def action(self, value: float, duration: float) -> Action:
        setpoint = self._axis.action(value) if value else Action(setpoint=AttitudeSetpoint())
        return dataclasses.replace(setpoint, velocity=[0.0] * 3, yaw_rate=0.0)

    def left_behind(self, value: float) -> Action | None:
        return Action(setpoint=AttitudeSetpoint()) if value else None

    def home(self, p_WB: Sequence[float]) -> Action:
        return dataclasses.replace(super().home(p_WB), setpoint=AttitudeSetpoint())


class LoadDrive(StepDrive):
    """Pushes by the value, or blows, while the drone holds.

    Args:
        session: the flown session.
        load: the acting load.
    """

    def __init__(self, session: Session, load: Load) -> None:
        self._session, self._load = session, load
        self.limit = flight_table().find(load.limit).maximum

    def unrest(self) -> float:
        return _speed(self._session.snapshot(), turns=self._load.turns) / AT_REST_SPEED

    def action(self, value: float, duration: float) -> Action:
        load = self._load_with(value, duration)
        return dataclasses.replace(load, velocity=[0.0] * 3, yaw_rate=0.0)

    def left_behind(self, value: float) -> Action | None:
        return self._load_with(0.0, 0.0) if value else None

    def _load_with(self, value: float, duration: float) -> Action:
        least = flight_table().find("push_duration").minimum
        centre = self._session.vehicle.p_BoBcm_B
        return self._load.action(value, max(duration, least), centre)


def _speed(now: Snapshot, *, turns: bool) -> float:
    """Return the yaw rate of what turns the drone [rad/s], else its speed [m/s]."""
    return abs(now.w_WB[2]) if turns else math.hypot(*now.v_WB)


def make_drive(session: Session, excitation: Excitation) -> StepDrive:
    """Return the drive that turns values of an excitation into actions.

    Raises:
        WorkbenchError: if the law has no setpoint that it needs.
    """
    row = excitation.row
    if isinstance(row, Load):
        return LoadDrive(session, row)
    if isinstance(row, AttitudeAxis):
        return AttitudeDrive(session, row, excitation)
    return SetpointDrive(session, row, excitation.amplitude)
