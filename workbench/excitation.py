"""Commands that make a drone answer: steps, doublets, square waves and chirps."""

from dataclasses import dataclass
from enum import Enum


class Shape(Enum):
    """How a command goes over time."""

    STEP = "step"
    """The amplitude for a period, then nothing for a period."""
    DOUBLET = "doublet"
    """The amplitude for half a period, its opposite for the other half, then nothing for one."""
    SQUARE = "square wave"
    """The amplitude and its opposite in turns, half a period each."""
    CHIRP = "chirp"
    """A sine whose frequency rises from 0.1 Hz tenfold and more, within a period."""


@dataclass(frozen=True)
class Excitation:
    """A command along one axis, on top of nothing: the other axes are held at rest.

    Attributes:
        axis: x, y, z (velocity in W) or yaw (rate).
        shape: over time.
        amplitude: [m/s] or [rad/s].
        period: [s].
        repeats: whether it begins again when it is over, until it is stopped.
    """

    axis: str
    shape: Shape
    amplitude: float
    period: float
    repeats: bool = False
