"""A servo as a part of a description declares it."""

from pathlib import Path
from typing import NamedTuple

from workbench.plant.servo import Servo


class DeclaredServo(NamedTuple):
    """A servo for a joint by name.

    Attributes:
        joint: its name, which may lack scopes.
        axis: which of the joint's freedoms.
        servo: its numbers, with limits of its own only.
        file: that declares it.
        element: for messages.
    """

    joint: str
    axis: int
    servo: Servo
    file: Path
    element: str
