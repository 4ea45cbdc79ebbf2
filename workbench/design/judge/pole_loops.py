"""The loop that each pole of the closed loop belongs to."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.design.judge.loop_response import places_of_effect
from workbench.design.judge.modes import joints_of_modes, natural_poles
from workbench.design.linear.model import LinearModel

FAST_POLE_RADIUS = 0.05
"""A smaller sampled pole is left out: it decays within two samples, and rounding moves it."""
MIN_POLE_SHIFT = 0.01
"""A pole that no loop's gain moves by this share of its size belongs to none: to filters, rotors or
delays."""


class LocatedPoles(NamedTuple):
    """The poles of a closed loop, without those that decay at once.

    Attributes:
        values: in continuous terms (k) [1/s].
        loops: whose gain moves each of them most (k), "" for a pole that no loop moves.
        joints: that move most in each of them (k), "" where none has a large part.
    """

    values: np.ndarray
    loops: tuple[str, ...]
    joints: tuple[str, ...]


def located_poles(model: LinearModel, joints: Sequence[str] = ()) -> LocatedPoles:
    """Return a closed loop's poles, the loop whose gain moves each of them most, and its joint.

    The shift is that by a small factor at the loop's error, from the pole's right and left
    eigenvector: dz = (w b)(c v) / (w v), with b and c of the cut. Of an outer and an inner loop
    with a common pole, it is the one that moves it more.

    Args:
        model: sampled; poles on the negative real axis of z appear at half the sampling rate.
        joints: names of the states of joints, positions first, see `Vehicle.small_joint_signals`.
    """
    kept = places_of_effect(model)
    z, right = np.linalg.eig(np.asarray(model.A, dtype=float)[np.ix_(kept, kept)])
    left = np.linalg.pinv(right)
    names = [loop.name for loop in model.loops]
    shifts = np.zeros((len(names) + 1, len(z)))
    for row, loop in enumerate(model.loops, start=1):
        _, b, c = model.cut(loop.error)
        shifts[row] = np.abs((left @ b[kept]) * (c[kept] @ right))
    seen = np.abs(z) > FAST_POLE_RADIUS
    poles = natural_poles(z[seen], model.period)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = shifts[:, seen] / np.abs(z[seen]) / model.period / np.abs(poles)
    shares[0] = MIN_POLE_SHIFT  # of no loop
    loops = tuple(["", *names][place] for place in np.nan_to_num(shares).argmax(axis=0))
    states = [model.state_names[place] for place in kept]
    moving = np.array(joints_of_modes(right, left, states, joints))[seen]
    return LocatedPoles(poles, loops, tuple(moving.tolist()))
