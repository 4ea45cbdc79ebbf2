"""The autoregressive filter that whitens errors of prediction."""

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate, oaconvolve


class Whitening(NamedTuple):
    """Autoregressive filters (c, order + 1), and the deviations of what they leave (c)."""

    coefficients: np.ndarray
    deviations: np.ndarray

    @property
    def cost(self) -> float:
        """Logarithm of the likelihood that is lost by a row."""
        return float(np.log(self.deviations).sum())


def whitening(rest: list[np.ndarray], order: int) -> Whitening:
    """Return the filters, by Yule and Walker's equations over all pieces.

    Args:
        rest: rows (K, c) of each piece.
        order: of the filters.
    """
    filters, deviations = [], []
    many = sum(len(each) for each in rest)
    for channel in range(rest[0].shape[1]):
        # an offset is the model's to explain: a filter that took it in would take it out
        mean = sum(float(each[:, channel].sum()) for each in rest) / many
        lags = np.zeros(order + 1)
        for each in rest:
            x = each[:, channel] - mean
            lags += correlate(x, x, "full", "fft")[len(x) - 1 : len(x) + order]
        lags[0] = lags[0] * (1.0 + 1e-9) + 1e-30
        made = solve_toeplitz(lags[:-1], lags[1:])
        filters.append(np.concatenate(([1.0], -made)))
        deviations.append(math.sqrt(max(lags[0] - made @ lags[1:], 1e-30) / many))
    return Whitening(np.array(filters), np.array(deviations))


def whiten(rows: np.ndarray, filters: Whitening) -> np.ndarray:
    """Return rows (K, c) through the filters, over their deviations, without those that begin."""
    order = filters.coefficients.shape[1] - 1
    through = oaconvolve(rows, filters.coefficients.T, mode="full", axes=0)
    return through[order : len(rows)] / filters.deviations
