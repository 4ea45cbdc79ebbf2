"""Poles of the closed loop in the terms of python-control's `damp`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from workbench.design.judge.loop_response import (
    MAX_INTEGRATOR_RATE,
    closed_poles,
    effective_system,
)
from workbench.design.linear.model import LinearModel

MIN_POLE_RADIUS = 1e-9
"""Largest size of a sampled pole that decays completely within a sample."""
MIN_JOINT_SHARE = 1.0 / 3.0
"""Participation of joints, of that of all states, from which on a mode has a joint's name."""


@dataclass(frozen=True)
class Mode:
    """A pole, or a pair of them; for a sampled loop s = ln(z) / period.

    Attributes:
        real: real part [1/s], negative if it decays.
        imaginary: imaginary part, 0 or that of the upper pole of a pair [rad/s].
        frequency: natural frequency [rad/s].
        damping: ratio; 1 for a real pole that decays, negative for one that grows.
        time_constant: of the decay [s], negative if it grows.
        joint: that moves most in it, "" if joints have no large part.
    """

    real: float
    imaginary: float
    frequency: float
    damping: float
    time_constant: float
    joint: str = ""

    def gone_after(self, period: float) -> bool:
        """Whether it decays within a time [s], to a twentieth."""
        return self.real * period < -3.0


def modes(model: LinearModel, joints: Sequence[str] = ()) -> tuple[Mode, ...]:
    """Return the modes of the closed loop, the slowest first.

    Integrators outside of all loops (position and heading while a pilot steers) and poles at z = 0
    are left out.

    Args:
        model: the closed loop.
        joints: names of the states of joints, positions first, see `Vehicle.small_joint_signals`.
    """
    if not joints:
        return modes_of(closed_poles(model), model.period)
    A, names = effective_system(model)
    poles, found = named_poles(A, names, joints)
    return modes_of(poles, model.period, found)


def modes_of(poles: np.ndarray, period: float, joints: Sequence[str] = ()) -> tuple[Mode, ...]:
    """Return the modes of poles (k), the slowest first, without integrators and poles at z = 0.

    Args:
        poles: z for a sampled system, s [1/s] for a continuous one.
        period: between samples [s], 0 for continuous time.
        joints: a name for each pole, see `Mode.joint`; none for poles without.
    """
    lasting = poles.imag >= 0.0
    if period:
        lasting &= np.abs(poles) > MIN_POLE_RADIUS
    names = compress(joints or [""] * len(poles), lasting)
    natural = natural_poles(poles[lasting], period)
    found = [
        _pole_mode(pole, joint)
        for pole, joint in zip(natural, names, strict=True)
        if abs(pole) > MAX_INTEGRATOR_RATE
    ]
    return tuple(sorted(found, key=lambda mode: (mode.frequency, mode.imaginary)))


def named_poles(
    A: np.ndarray, states: Sequence[str], joints: Sequence[str]
) -> tuple[np.ndarray, list[str]]:
    """Return the eigenvalues of a system (k), and the joint that moves most in each mode.

    Args:
        A: (k, k).
        states: their names (k).
        joints: names of the states of joints, all positions, then all velocities (2 j).
    """
    poles, right = np.linalg.eig(A)
    return poles, joints_of_modes(right, np.linalg.pinv(right), states, joints)


def joints_of_modes(
    right: np.ndarray, left: np.ndarray, states: Sequence[str], joints: Sequence[str]
) -> list[str]:
    """Return the joint that moves most in each mode, "" where joints have no large part (k).

    The participation of a state in a mode is the product of its parts in the right and the left
    eigenvector (Perez-Arriaga, Verghese and Schweppe, "Selective Modal Analysis", IEEE Transactions
    on Power Apparatus and Systems, 1982); it does not depend on units. That of a joint is of its
    positions and velocities. Where several move alike, as four legs, their parts count together.

    Args:
        right: right eigenvectors, columns (k, k).
        left: left eigenvectors, rows (k, k).
        states: names of the states (k).
        joints: names of the states of joints, all positions, then all velocities (2 j).
    """
    if not joints:
        return [""] * right.shape[1]
    shares = np.abs(left.T * right)
    shares /= np.maximum(shares.sum(axis=0), 1e-300)
    half = len(joints) // 2
    names = [position.rpartition("_")[0] for position in joints[:half]] * 2
    sums = {name: np.zeros(right.shape[1]) for name in names}
    for name, state in zip(names, joints, strict=True):
        if state in states:
            sums[name] += shares[states.index(state)]
    table = np.array(list(sums.values()))
    large = table.sum(axis=0) > MIN_JOINT_SHARE
    best = np.array(list(sums))[table.argmax(axis=0)]
    return [str(name) if has else "" for name, has in zip(best, large, strict=True)]


def natural_poles(poles: np.ndarray, period: float) -> np.ndarray:
    """Return poles in continuous time [1/s], without those that decay within a sample."""
    if not period:
        return poles
    found: np.ndarray = np.log(poles[np.abs(poles) > MIN_POLE_RADIUS].astype(complex)) / period
    return found


def least_damping(found: tuple[Mode, ...]) -> float:
    """Return the smallest damping ratio of all modes, 1 if there are none."""
    return min((mode.damping for mode in found), default=1.0)


def _pole_mode(pole: complex, joint: str) -> Mode:
    size, real = abs(pole), float(pole.real)
    return Mode(
        real=real,
        imaginary=max(float(pole.imag), 0.0),
        frequency=float(size),
        damping=float(-real / size) if size else math.nan,
        time_constant=-1.0 / real if real else math.inf,
        joint=joint,
    )
