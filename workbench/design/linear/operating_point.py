"""The operating point of a linearisation."""

import dataclasses
import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, unknown_name

_POINT_KEYS = {
    "vx": ("velocity", 0),
    "vy": ("velocity", 1),
    "vz": ("velocity", 2),
    "ax": ("acceleration", 0),
    "ay": ("acceleration", 1),
    "az": ("acceleration", 2),
}
_POINT_NAMES = (*_POINT_KEYS, "yaw_rate", "hold")

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class OperatingPoint:
    """An operating point; by default hover.

    Vectors are in the axes of the heading, which coincide with W at the moment, but turn with the
    yaw rate. So a velocity with a yaw rate is a steady turn, and every point without acceleration
    is a steady flight.

    Attributes:
        velocity: of the base link [m/s].
        yaw_rate: about world z [rad/s].
        acceleration: in addition to that of the steady turn [m/s²]; unless 0, the point is an
            instant, not a steady flight.
        hold: whether the position is held, as in hover without a command.
    """

    velocity: Triple = (0.0, 0.0, 0.0)
    yaw_rate: float = 0.0
    acceleration: Triple = (0.0, 0.0, 0.0)
    hold: bool = False

    def __post_init__(self) -> None:
        numbers = (*self.velocity, self.yaw_rate, *self.acceleration)
        if not all(map(math.isfinite, numbers)):
            raise WorkbenchError(f"the operating point has {numbers}: give finite numbers")
        if self.hold and any(numbers):
            raise WorkbenchError("the position is held in hover only: leave hold or the motion out")

    @property
    def label(self) -> str:
        """The point as text for `parse_point`."""
        parts = [
            f"{name}={getattr(self, field)[index]:g}"
            for name, (field, index) in _POINT_KEYS.items()
            if getattr(self, field)[index]
        ]
        if self.yaw_rate:
            parts.append(f"yaw_rate={self.yaw_rate:g}")
        if self.hold:
            parts.append("hold=1")
        return ",".join(parts) or "hover"


HOVER_POINT = OperatingPoint()
HOLDING_POINT = OperatingPoint(hold=True)
"""Hover while a pilot steers, and while a position is held."""


def steady_velocity(text: str) -> Triple:
    """Return the velocity of a straight steady flight from a text, see `parse_point`.

    Raises:
        WorkbenchError: if it is invalid.
    """
    point = parse_point(text)
    if point != OperatingPoint(velocity=point.velocity):
        raise WorkbenchError(
            f"steps begin from a straight steady flight, and {point.label} is not one: give vx, "
            "vy, vz"
        )
    return point.velocity


def parse_point(text: str) -> OperatingPoint:
    """Return the point from a text: `hover`, or such as `vx=5,vz=-1,yaw_rate=0.2,ax=3,hold=1`.

    Raises:
        WorkbenchError: if it is invalid.
    """
    point = OperatingPoint()
    seen: set[str] = set()
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if name in seen:
            raise WorkbenchError(f"the operating point '{text}' has {name} twice: give it once")
        seen.add(name)
        if name == "hover" and not equals:
            continue
        if name not in _POINT_NAMES:
            raise unknown_name("quantity of an operating point", name, ("hover", *_POINT_NAMES))
        try:
            number = float(value)
        except ValueError:
            raise WorkbenchError(
                f"'{part.strip()}' is not part of an operating point: write vx=5,vz=-1"
            ) from None
        if not math.isfinite(number):
            raise WorkbenchError(
                f"'{part.strip()}' is not the value of a steady flight: give a finite number"
            )
        if name in _POINT_KEYS:
            field, index = _POINT_KEYS[name]
            vector = list(getattr(point, field))
            vector[index] = number
            x, y, z = vector
            point = (
                dataclasses.replace(point, velocity=(x, y, z))
                if field == "velocity"
                else dataclasses.replace(point, acceleration=(x, y, z))
            )
        elif name == "hold":
            point = dataclasses.replace(point, hold=number != 0.0)
        else:
            point = dataclasses.replace(point, yaw_rate=number)
    if "hover" in seen and len(seen) > 1:
        raise WorkbenchError(f"'{text}' is hover and more: leave hover or the rest out")
    return point
