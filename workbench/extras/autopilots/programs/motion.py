"""The motion of a drone for the simulator interfaces of autopilots, in their frames.

The workbench uses east, north, up (ENU) and forward, left, up (FLU); PX4 and ArduPilot use north,
east, down (NED) and forward, right, down (FRD).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class AutopilotMotion:
    """The motion of a drone at one time, in NED and FRD, for sensors at its base link.

    Attributes:
        time: since the start [s].
        attitude: of FRD in NED, quaternion w, x, y, z (4).
        gyro: angular velocity in FRD (3) [rad/s].
        force: specific force in FRD (3) [m/s²]; (0, 0, -9.8) at rest and level.
        velocity: in NED (3) [m/s].
        position: in NED, from home (3) [m].
        field: of the earth, in FRD (3) [T].
        pressure: of the air [Pa].
        pressure_altitude: altitude of that pressure in the standard atmosphere, above sea level
            [m].
        place: latitude, longitude [rad], and altitude [m] (3).
    """

    time: float
    attitude: tuple[float, float, float, float]
    gyro: tuple[float, float, float]
    force: tuple[float, float, float]
    velocity: tuple[float, float, float]
    position: tuple[float, float, float]
    field: tuple[float, float, float]
    pressure: float
    pressure_altitude: float
    place: tuple[float, float, float]


class RestartedError(Exception):
    """The autopilot has restarted, so the vehicle is reset."""


class Autopilot(Protocol):
    """The workbench side of the connection to an autopilot.

    Attributes:
        name: of the autopilot.
        armed: whether it reports that its motors may turn.
    """

    name: str
    armed: bool

    @property
    def locked(self) -> bool:
        """Whether it is in lockstep, with its answers as the only clock."""

    def connect(self) -> None:
        """Wait for the autopilot."""

    def exchange(self, motion: AutopilotMotion) -> tuple[float, ...]:
        """Send the motion; return its outputs, 0 .. 1.

        Raises:
            RestartedError: if it has restarted; the next call answers it.
            FlightBrokenError: if it has ended, is silent, or sends invalid data.
        """

    def report(self) -> dict[str, float]:
        """Return statistics of the exchange, by name."""

    def close(self) -> None:
        """Close the sockets."""


def to_ned(vector: Sequence[float]) -> tuple[float, float, float]:
    """Return a vector in ENU (3) in NED."""
    return vector[1], vector[0], -vector[2]


def to_frd(vector: Sequence[float]) -> tuple[float, float, float]:
    """Return a vector in FLU (3) in FRD."""
    return vector[0], -vector[1], -vector[2]


def attitude_ned(q: Sequence[float]) -> tuple[float, float, float, float]:
    """Return the attitude of FRD in NED for that of FLU in ENU, both w, x, y, z (4).

    It is q_NED_ENU q q_FLU_FRD, with (0, 1, 1, 0)/√2 before and (0, 1, 0, 0) after, and the sign
    for which a drone that points north has the identity.
    """
    w, x, y, z = q
    half = math.sqrt(0.5)
    return half * (w + z), half * (x + y), half * (x - y), half * (w - z)
