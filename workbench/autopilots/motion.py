"""What an autopilot's simulator interface is told of a drone's motion, in its own frames.

The workbench has east, north, up (ENU) and forward, left, up (FLU); PX4 and ArduPilot have north,
east, down (NED) and forward, right, down (FRD).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Motion:
    """A drone at a time, in NED and FRD, as sensors at its base link see it.

    Attributes:
        time: since the start [s].
        attitude: of FRD in NED, quaternion w, x, y, z (4).
        gyro: angular velocity in FRD (3) [rad/s].
        force: specific force in FRD (3) [m/s²]; (0, 0, -9.8) at rest and level.
        velocity: in NED (3) [m/s].
        position: in NED, from home (3) [m].
        field: of the earth, in FRD (3) [T].
        pressure: of the air [Pa].
        pressure_altitude: at which the standard atmosphere has that, above the sea [m].
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
    """The workbench's end of the wire to an autopilot.

    Attributes:
        name: of the autopilot, for people.
        armed: whether it says that its motors may turn.
    """

    name: str
    armed: bool

    @property
    def locked(self) -> bool:
        """Whether it is in lockstep, so that its answers are all the clock that there is."""

    def connect(self) -> None:
        """Wait until it is there."""

    def exchange(self, motion: Motion) -> tuple[float, ...]:
        """Tell it of the motion; return what it asks of its outputs, 0 .. 1.

        Raises:
            RestartedError: if it has restarted; the next call answers it.
            FlightBrokenError: if it is gone, silent, or says what cannot be.
        """

    def report(self) -> dict[str, float]:
        """Return numbers that say how the exchange went, by name."""

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

    It is q_NED_ENU q q_FLU_FRD, with (0, 1, 1, 0)/√2 before and (0, 1, 0, 0) behind, and the sign
    that makes a drone that looks north the identity.
    """
    w, x, y, z = q
    half = math.sqrt(0.5)
    return half * (w + z), half * (x + y), half * (x - y), half * (w - z)
