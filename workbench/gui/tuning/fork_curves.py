"""What can be compared of the branches of a fork."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.design.branches import FlownBranch
from workbench.scenario.axes import find_axis


@dataclass(frozen=True)
class Quantity:
    """Something that a branch has over time.

    Attributes:
        label: in words.
        values: of a branch, along an axis, in SI.
        unit_of: SI unit along an axis.
    """

    label: str
    values: Callable[[FlownBranch, str], np.ndarray]
    unit_of: Callable[[str], str]


def way(flown: FlownBranch, axis: str) -> np.ndarray:
    """Return the way flown along an axis since the fork [m]; in all, for yaw."""
    place = find_axis(axis).place
    moved = flown.position - flown.position[:1]
    return np.linalg.norm(moved, axis=1) if place is None else moved[:, place]


QUANTITIES = (
    Quantity("velocity", FlownBranch.response, lambda axis: find_axis(axis).unit),
    Quantity("way flown", way, lambda axis: "m"),
    Quantity("tilt", lambda flown, axis: flown.tilt, lambda axis: "rad"),
    Quantity("rotor use", lambda flown, axis: flown.rotor_use, lambda axis: "1"),
)
