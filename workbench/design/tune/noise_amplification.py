"""The effect of sensor noise on the commands of a loop."""

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from workbench.design.linear.model import LinearModel

RATE_NOISE_INPUTS = ("noise_w_x", "noise_w_y", "noise_w_z")
_MIN_MATRIX_ENTRY = 1e-10
"""Smaller entries of the state matrix are rounding errors."""
_UNIT_CIRCLE_TOLERANCE = 1e-9
"""Distance from the unit circle up to which a pole counts as on it."""
_UNOBSERVABLE_SHARE = 1e-7
"""Share of a mode in the outputs up to which it counts as unobservable."""


def noise_amplification(model: LinearModel) -> float:
    """Return the rms of a rotor's thrust over that of noise on the measured rates [N·s/rad].

    The noise is white, independent between axes, and of the same size on all three. The rotor is
    the most affected one. With P the covariance of the sampled closed loop under noise of unit
    size,

        P = A P A' + B B',   rms² = diag(C P C' + D D').

    Position and heading drift without limit under noise, but no rotor reacts to them while the
    pilot steers. States that do not affect the thrusts are left out. So is a drifting mode without
    effect on them, such as of a heading together with the one in the memory of the law.

    Args:
        model: of the sampled closed loop; for an unstable one the rms is infinite.
    """
    outputs = [signal.name for signal in model.outputs if signal.name.startswith("thrust_")]
    A, B, C = model.A, model.B(RATE_NOISE_INPUTS), model.C(outputs)
    D = model.D(outputs, RATE_NOISE_INPUTS)
    kept = _seen_states(A, C)
    A, B, C = A[np.ix_(kept, kept)], B[kept], C[:, kept]
    A = _without_wandering(A, C)
    if np.abs(np.linalg.eigvals(A)).max(initial=0.0) >= 1.0:
        return float("inf")
    P = solve_discrete_lyapunov(A, B @ B.T, method="bilinear")
    variance = np.einsum("ij,jk,ik->i", C, P, C) + (D**2).sum(axis=1)
    return float(np.sqrt(variance.max()))


def _without_wandering(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return A (m, m) without modes that neither decay nor grow, nor are observable in C (l, m)."""
    values, vectors = np.linalg.eig(A)
    wandering = np.flatnonzero(np.abs(np.abs(values) - 1.0) < _UNIT_CIRCLE_TOLERANCE)
    if not len(wandering):
        return A
    left = np.linalg.inv(vectors)
    for mode in wandering:
        if np.linalg.norm(C @ vectors[:, mode]) < _UNOBSERVABLE_SHARE * np.linalg.norm(C):
            A = A - np.outer(values[mode] * vectors[:, mode], left[mode])
    return np.asarray(A.real)


def _seen_states(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return which states the outputs depend on, at once or later."""
    passes = np.abs(A) > _MIN_MATRIX_ENTRY
    seen = (np.abs(C) > _MIN_MATRIX_ENTRY).any(axis=0)
    for _ in range(len(A)):
        seen = seen | passes[seen].any(axis=0)
    return np.flatnonzero(seen)
