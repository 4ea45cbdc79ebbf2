"""Numbers with derivatives: how they are made and read."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient


def constants(values: Iterable[float]) -> np.ndarray:
    """Return numbers as AutoDiff values without derivatives."""
    return np.array([AutoDiffXd(value) for value in values])


def gradient(values: Any, columns: int) -> np.ndarray:
    """Return the derivatives of AutoDiff values, those of plain numbers being 0."""
    found = ExtractGradient(whole(values))
    return found if found.shape[1] else np.zeros((found.shape[0], columns))


def whole(values: Any) -> np.ndarray:
    """Return values as AutoDiff numbers: one cut to its limit has become a plain number."""
    flat = np.array(values, dtype=object).ravel()
    return np.array([v if isinstance(v, AutoDiffXd) else AutoDiffXd(v) for v in flat])
