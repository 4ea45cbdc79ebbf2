"""A minimal realisation: what inputs cannot move and outputs do not show is left out."""

from typing import Any

import numpy as np

TOLERANCE = 1e-7
"""Share of what comes out of a step that has to be new, to count as a direction."""


def minimal_realisation(system: Any) -> Any:
    """Return a `control.StateSpace` of least order with the same transfer functions.

    Its states are combinations of the old ones and lose their names. It is the Kalman
    decomposition by orthogonal bases of the reachable, then of the observable directions
    (Rosenbrock's staircase); python-control's own needs slycot.

    Args:
        system: a `control.StateSpace`.
    """
    import control

    A, B, C = system.A, system.B, system.C
    reach = reachable(A, _unit(B))
    A, B, C = reach.T @ A @ reach, reach.T @ B, C @ reach
    seen = reachable(A.T, _unit(C.T))
    A, B, C = seen.T @ A @ seen, seen.T @ B, C @ seen
    names = {"inputs": system.input_labels, "outputs": system.output_labels, "name": system.name}
    return control.ss(A, B, C, system.D, system.dt, **names)


def reachable(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of what inputs can reach: the span of B, A B, A² B, ..."""
    basis = np.zeros((A.shape[0], 0))
    new = B
    while basis.shape[1] < A.shape[0]:
        whole = np.linalg.norm(new, axis=0).max()
        for _ in range(2):  # twice is enough, against rounding
            new = new - basis @ (basis.T @ new)
        left, sizes, _ = np.linalg.svd(new, full_matrices=False)
        left = left[:, sizes > TOLERANCE * whole]
        if left.shape[1] == 0:
            break
        basis = np.hstack([basis, left])
        new = A @ left
    return basis


def _unit(columns: np.ndarray) -> np.ndarray:
    """Return columns of length 1, or 0."""
    sizes = np.linalg.norm(columns, axis=0)
    return columns / np.where(sizes > 0.0, sizes, 1.0)
