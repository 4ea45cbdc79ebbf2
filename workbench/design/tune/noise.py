"""How much of the rate measurement's noise the rotors are made to follow."""

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from workbench.design.linear.model import LinearModel

NOISE = ("noise_w_x", "noise_w_y", "noise_w_z")
_NO_PATH = 1e-10
"""A smaller entry of the state matrix is rounding."""


def noise_amplification(model: LinearModel) -> float:
    """Return the rms of a rotor's thrust over that of noise on the measured rates [N·s/rad].

    The noise is white: independent from one control period to the next, and from axis to axis,
    of one size on all three. The rotor is the one that follows most. With P the covariance of the
    sampled closed loop under noise of unit size,

        P = A P A' + B B',   rms² = diag(C P C' + D D').

    Position and heading wander off under noise without end, but no rotor answers to them while
    the pilot steers; states that the thrusts do not depend on are left out.

    Args:
        model: of the sampled closed loop; an unstable one has no rms: infinite.
    """
    outputs = [signal.name for signal in model.outputs if signal.name.startswith("thrust_")]
    A, B, C = model.A, model.B(NOISE), model.C(outputs)
    D = model.D(outputs, NOISE)
    kept = _seen_states(A, C)
    A, B, C = A[np.ix_(kept, kept)], B[kept], C[:, kept]
    if np.abs(np.linalg.eigvals(A)).max(initial=0.0) >= 1.0:
        return float("inf")
    P = solve_discrete_lyapunov(A, B @ B.T, method="bilinear")
    variance = np.einsum("ij,jk,ik->i", C, P, C) + (D**2).sum(axis=1)
    return float(np.sqrt(variance.max()))


def _seen_states(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Return which states the outputs depend on, at once or later."""
    passes = np.abs(A) > _NO_PATH
    seen = (np.abs(C) > _NO_PATH).any(axis=0)
    for _ in range(len(A)):
        seen = seen | passes[seen].any(axis=0)
    return np.flatnonzero(seen)
