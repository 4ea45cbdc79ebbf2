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
        notes: element and text of remarks on what is not used where the servo is taken.
    """

    joint: str
    axis: int
    servo: Servo
    file: Path
    element: str
    notes: tuple[tuple[str, str], ...] = ()
