"""A flight in a few numbers."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.control.mode import FlightMode, Reason
from workbench.session.recording import Recording

_TOUCH_DOWN_HEIGHT_M = 0.1
"""Height above the ground below which the touch-down speed is measured [m]."""
_CONTACT_HEIGHT_M = 0.005
_AT_REST_LIMIT = 0.05
"""A drone below this height above the ground [m] and this speed [m/s] is at rest."""


class Failsafe(NamedTuple):
    """A failsafe, or a failure that does not end the flight: its reason, time [s] and mode."""

    reason: str
    time: float
    mode: str

    @property
    def said(self) -> str:
        """All of these as a sentence."""
        return f"{self.reason} at {self.time:.1f} s: {self.mode}"


@dataclass(frozen=True)
class FlightSummary:
    """The main numbers of a flight in SI units, angles in rad.

    Attributes:
        duration: flown time [s].
        distance: length of the path [m].
        max_speed: [m/s].
        max_height: of the base link above the ground [m].
        min_height: of the base link above the ground [m].
        end: position of the base link at the end, in W [m].
        max_tilt: [rad].
        turned_over: when the drone first tilted beyond 90 deg [s]; None if it never did.
        max_yaw_rate: about world z, either way [rad/s].
        max_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        final_mode: the flight mode at the end, in words; "open loop" if there is none.
        battery_used: share of the charge, 0 .. 1; NaN without a battery.
        touch_down_speed: largest sinking speed in the last 0.1 m before the ground [m/s]; None if
            the drone did not come down, or does not stand at the end.
        least_clearance: smallest distance to an obstacle [m], below 0 where they may have touched;
            None in a world without obstacles.
        failsafes: each of them, in order.
        slack_time: how long any cable was slack [s]; None without cables.
    """

    duration: float
    distance: float
    max_speed: float
    max_height: float
    min_height: float
    end: tuple[float, float, float]
    max_tilt: float
    turned_over: float | None
    max_yaw_rate: float
    max_rotor_use: float
    final_mode: str
    battery_used: float
    touch_down_speed: float | None
    least_clearance: float | None
    failsafes: tuple[Failsafe, ...] = ()
    slack_time: float | None = None


def summarise(recording: Recording) -> FlightSummary:
    """Return the summary of a flight."""
    mode = float(recording.mode[-1])
    least = float(recording.clearance.min())
    x, y, z = recording.p_WB[-1].tolist()
    over = np.flatnonzero(recording.tilt > 0.5 * math.pi)
    return FlightSummary(
        duration=float(recording.time[-1] - recording.time[0]),
        distance=float(np.linalg.norm(np.diff(recording.p_WB, axis=0), axis=1).sum()),
        max_speed=float(np.linalg.norm(recording.v_WB, axis=1).max()),
        max_height=float(recording.p_WB[:, 2].max()),
        min_height=float(recording.p_WB[:, 2].min()),
        end=(x, y, z),
        max_tilt=float(recording.tilt.max()),
        turned_over=float(recording.time[over[0]]) if len(over) else None,
        max_yaw_rate=float(np.abs(recording.w_WB[:, 2]).max()),
        max_rotor_use=float(recording.rotor_use.max()),
        final_mode="open loop" if math.isnan(mode) else FlightMode(int(mode)).label,
        battery_used=float(recording.charge[0] - recording.charge[-1]),
        touch_down_speed=_touch_down_speed(recording),
        least_clearance=least if math.isfinite(least) else None,
        failsafes=_failsafes(recording),
        slack_time=recording.slack_time if recording.tensions.size else None,
    )


def _failsafes(recording: Recording) -> tuple[Failsafe, ...]:
    reason = recording.reason.ravel()
    begun = np.flatnonzero(np.diff(reason, prepend=0.0))
    return tuple(
        Failsafe(
            Reason(int(reason[at])).label,
            float(recording.time[at]),
            FlightMode(int(recording.mode[at])).label,
        )
        for at in begun
        if reason[at] != Reason.NONE
    )


def _touch_down_speed(recording: Recording) -> float | None:
    height = recording.p_WB[:, 2] - recording.vehicle.ground_clearance
    v_z = recording.v_WB[:, 2]
    above = np.flatnonzero(height > _TOUCH_DOWN_HEIGHT_M)
    if len(above) == 0 or height[-1] > _AT_REST_LIMIT or abs(v_z[-1]) > _AT_REST_LIMIT:
        return None
    last = above[-1]
    touching = np.flatnonzero(height[last:] <= _CONTACT_HEIGHT_M)
    end = last + (touching[0] if len(touching) else len(height) - last - 1)
    return float(-v_z[last : end + 1].min())
