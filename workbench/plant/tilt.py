"""Joints with servos that tilt rotors, as a part of the allocation of a vehicle.

At a tilt by a small angle the thrust T n of a rotor on a joint with the axis a through J changes by
T (a x n), and its hub p by a x (p - J). So the wrench is linear in thrusts and, with the thrusts of
hover, in angles: Kamel et al., "The Voliro Omniorientational Hexacopter", IEEE Robotics &
Automation Magazine 2018, has the same columns, for angles of any size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.vectors import float_triple
from workbench.plant.rotors import Rotor


@dataclass(frozen=True)
class TiltedRotor:
    """A rotor on a joint that tilts it.

    Attributes:
        rotor: its index among those of the vehicle.
        p_BJ: a point of the axis in B, with all joints at zero [m].
        axis_B: the axis, times the multiplier of a joint that follows.
    """

    rotor: int
    p_BJ: tuple[float, float, float]
    axis_B: tuple[float, float, float]


@dataclass(frozen=True)
class Tilt:
    """A servo whose angle changes the wrench of rotors.

    Attributes:
        joint: name of its freedom.
        lower: least angle [rad].
        upper: largest angle [rad].
        turns: the rotors that it tilts.
    """

    joint: str
    lower: float
    upper: float
    turns: tuple[TiltedRotor, ...]

    def column(self, rotors: Sequence[Rotor], p_BoBcm_B: Sequence[float]) -> np.ndarray:
        """Return force and moment about the centre of mass per angle and thrust (6) [1, m].

        The thrust is that of all its rotors together, in equal shares.
        """
        wrench = np.zeros(6)
        for each in self.turns:
            rotor, axis = rotors[each.rotor], np.array(each.axis_B)
            n, p = np.array(rotor.axis_B), np.array(rotor.p_BR)
            turned, moved = np.cross(axis, n), np.cross(axis, p - np.array(each.p_BJ))
            moment = np.cross(p - np.array(p_BoBcm_B), turned) + np.cross(moved, n)
            moment -= rotor.direction * rotor.moment_constant * turned
            wrench += np.concatenate([turned, moment]) / len(self.turns)
        return wrench

    def turned_by(self, R: np.ndarray) -> "Tilt":
        """Return it with its axes in another frame; the rows of R are the axes of that."""
        turns = tuple(
            replace(
                each,
                p_BJ=float_triple(R @ each.p_BJ),
                axis_B=float_triple(R @ each.axis_B),
            )
            for each in self.turns
        )
        return replace(self, turns=turns)
