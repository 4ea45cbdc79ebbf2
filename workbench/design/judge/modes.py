"""Poles of the closed loop in the terms of python-control's `damp`."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.judge.loop_response import INTEGRATOR, closed_poles
from workbench.design.linear.model import LinearModel

GONE = 1e-9
"""Largest size of a sampled pole that decays completely within a sample."""


@dataclass(frozen=True)
class Mode:
    """A pole, or a pair of them; for a sampled loop s = ln(z) / period.

    Attributes:
        real: real part [1/s], negative if it decays.
        imaginary: imaginary part, 0 or that of the upper pole of a pair [rad/s].
        frequency: natural frequency [rad/s].
        damping: ratio; 1 for a real pole that decays, negative for one that grows.
        time_constant: of the decay [s], negative if it grows.
    """

    real: float
    imaginary: float
    frequency: float
    damping: float
    time_constant: float

    def gone_after(self, period: float) -> bool:
        """Whether it decays within a time [s], to a twentieth."""
        return self.real * period < -3.0


def modes(model: LinearModel) -> tuple[Mode, ...]:
    """Return the modes of the closed loop, the slowest first.

    Integrators outside of all loops (position and heading while a pilot steers) and poles at z = 0
    are left out.
    """
    return modes_of(closed_poles(model), model.period)


def modes_of(poles: np.ndarray, period: float) -> tuple[Mode, ...]:
    """Return the modes of poles (k), the slowest first, without integrators and poles at z = 0.

    Args:
        poles: z for a sampled system, s [1/s] for a continuous one.
        period: between samples [s], 0 for continuous time.
    """
    upper = natural_poles(poles[poles.imag >= 0.0], period)
    upper = upper[np.abs(upper) > INTEGRATOR]
    return tuple(_mode(pole) for pole in sorted(upper, key=lambda pole: (abs(pole), pole.imag)))


def natural_poles(poles: np.ndarray, period: float) -> np.ndarray:
    """Return poles in continuous time [1/s], without those that decay within a sample."""
    if not period:
        return poles
    found: np.ndarray = np.log(poles[np.abs(poles) > GONE].astype(complex)) / period
    return found


def least_damping(found: tuple[Mode, ...]) -> float:
    """Return the smallest damping ratio of all modes, 1 if there are none."""
    return min((mode.damping for mode in found), default=1.0)


def _mode(pole: complex) -> Mode:
    size, real = abs(pole), float(pole.real)
    return Mode(
        real=real,
        imaginary=max(float(pole.imag), 0.0),
        frequency=float(size),
        damping=float(-real / size) if size else math.nan,
        time_constant=-1.0 / real if real else math.inf,
    )
