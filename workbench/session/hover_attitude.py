"""The attitude of a hover, from which setpoints of attitude step: in wind it is tilted."""

import math
from dataclasses import dataclass

from workbench.plant.gravity import GRAVITY
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.session.session import Session

AT_REST_SPEED = 0.05
"""Speed below which a drone counts as at rest [m/s] or [rad/s] …"""
AT_REST_SHARE = 0.01
"""… and before a step of a command or a setpoint, if what it changes is below this share of the
step: half of what its numbers allow, see `step_metrics` …"""
AT_REST_TIME_S = 1.0
"""… an attitude within this time."""
LEVEL_SHARE = 2.0 * AT_REST_SHARE
"""A hover counts as level if its angle is below this share of a step."""
TREMBLE_RAD = 0.005
"""Tilt from that of rest, and turn within `AT_REST_TIME_S`, of a drone that hovers on an estimate.

Sensors make it tremble, more than the shares of a small step allow."""


@dataclass(frozen=True)
class HoverAttitude:
    """An angle of a hover, both 0 if it is level.

    Attributes:
        angle: that is flown [rad].
        setpoint: by which the law keeps it [rad]; 0 for a vehicle whose rotors lift while it is
            tilted, as laws know it.
    """

    angle: float = 0.0
    setpoint: float = 0.0


def least_level_angle(session: Session, size: float) -> float:
    """Return the angle [rad] below which a hover counts as level before a step.

    Args:
        session: the flight.
        size: of the step [rad] or [rad/s], positive.
    """
    return max(LEVEL_SHARE * size, _tremble(session))


def attitude_unrest(session: Session, size: float) -> float:
    """Return the motion over the largest one at rest before a step; below 1 it is at rest.

    In wind a drone is at rest with a tilt, and may turn slowly about the vertical.

    Args:
        session: the flight.
        size: of the step [rad] or [rad/s], positive.
    """
    now = session.snapshot()
    turned = AT_REST_TIME_S * math.hypot(*now.w_WB[:2])
    tilted = math.hypot(*now.vdot_WB[:2]) / GRAVITY  # from that of rest
    speed = max(math.hypot(*now.v_WB), abs(now.w_WB[2])) / AT_REST_SPEED
    return max(speed, max(turned, tilted) / max(AT_REST_SHARE * size, _tremble(session)))


def hover_attitude(session: Session, axis: AttitudeAxis, size: float) -> HoverAttitude:
    """Return the attitude of a drone at rest about an axis, from which its setpoint is to step.

    Args:
        session: the flight, whose attitude has no setpoint but that of the loops outside.
        axis: of the step; a rate is 0 in any hover.
        size: of the step [rad], positive.
    """
    angle, level = session.snapshot().roll_pitch_yaw[axis.place], least_level_angle(session, size)
    if axis.is_rate or abs(angle) <= level:
        return HoverAttitude()
    place = session.controller.point_names.index(axis.point)
    setpoint = axis.from_point(float(session.loop_signals()[place]), session.controller)
    return HoverAttitude(angle, setpoint if abs(setpoint) > level else 0.0)


def _tremble(session: Session) -> float:
    return TREMBLE_RAD if session.scenario.is_estimated else 0.0
