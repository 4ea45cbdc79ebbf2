"""Fit the impulse response of a loop to windows of a log."""

from collections.abc import Sequence

import numpy as np

DISTURBANCE_ORDER = 6
"""Order of the model of the disturbance."""
FILTER_SLACK_TAPS = 2
"""Number of taps before 0 that filters and interpolation may cause."""


class ResponseFits:
    """Least squares of windows, each with a weight.

    Attributes:
        sooner: gain in the likelihood of the log, in -2 log p, with noncausal taps.
    """

    def __init__(self, windows: Sequence[np.ndarray], early: int) -> None:
        rows = [_regression_rows(window, early) for window in windows]
        causal = slice(early - FILTER_SLACK_TAPS, None)
        first = _ridge([(phi[:, causal], y) for phi, y in rows])
        colour = _disturbance_model([y - phi[:, causal] @ first for phi, y in rows])
        filtered = [(_filtered(phi, colour), _filtered(y, colour)) for phi, y in rows]
        squares = np.array([phi.T @ phi for phi, _ in filtered])
        products = np.array([phi.T @ y for phi, y in filtered])
        power = float(sum(y @ y for _, y in filtered))
        count = sum(len(y) for _, y in filtered)
        cost, self._root = _likeliest(
            squares[:, causal, causal].sum(axis=0), products[:, causal].sum(axis=0), power, count
        )
        shifted, _ = _likeliest(squares.sum(axis=0), products.sum(axis=0), power, count)
        self.sooner = cost - shifted
        # In the coordinates of the prior the ridge is 1, and each draw is a sum and one solution.
        root = self._root
        self._inner = np.array([root.T @ square[causal, causal] @ root for square in squares])
        self._turned = products[:, causal] @ root

    def solve(self, weights: np.ndarray) -> np.ndarray:
        """Return the taps, from `FILTER_SLACK_TAPS` before 0 on."""
        inner = np.tensordot(weights, self._inner, 1) + np.eye(len(self._root))
        return np.asarray(self._root @ np.linalg.solve(inner, weights @ self._turned))


def _regression_rows(window: np.ndarray, early: int) -> tuple[np.ndarray, np.ndarray]:
    """Return regressors (n, early + taps) and response (n) of a window, without their means."""
    taps = (len(window) - early + 1) // 2
    u, y = window[:, 0], window[taps - 1 : len(window) - early, 1]
    lagged = np.lib.stride_tricks.sliding_window_view(u, taps + early)[:, ::-1]
    lagged = lagged[: len(y)]  # column 0 is the newest, early samples ahead
    return lagged - lagged.mean(axis=0), y - y.mean()


def _ridge(rows: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return a first solution, with a small penalty on the taps."""
    square = np.sum([phi.T @ phi for phi, _ in rows], axis=0)
    product = np.sum([phi.T @ y for phi, y in rows], axis=0)
    ridge = 1e-3 * np.trace(square) / len(square) + 1e-12
    return np.asarray(np.linalg.solve(square + ridge * np.eye(len(square)), product))


def _likeliest(
    square: np.ndarray, product: np.ndarray, power: float, count: int
) -> tuple[float, np.ndarray]:
    """Return -2 log p of the likeliest prior, and a root of its covariance over the noise's."""
    size = len(square)
    lag = np.arange(size)
    scale = max(float(np.trace(square)) / size, 1e-12)
    best, found = np.inf, np.eye(size)
    for decay in np.exp(-1.0 / (size * np.array([0.03, 0.06, 0.12, 0.25, 0.5]))):
        kernel = decay ** np.maximum(lag[:, None], lag[None, :])
        root = np.linalg.cholesky(kernel + 1e-9 * np.eye(size))
        values, vectors = np.linalg.eigh(root.T @ square @ root)
        turned = vectors.T @ (root.T @ product)
        for strength in np.logspace(-2.0, 5.0, 15) / scale:
            grown = 1.0 + strength * np.maximum(values, 0.0)
            rest = max(power - strength * float(np.sum(turned**2 / grown)), 1e-12 * power)
            cost = count * np.log(rest / count + 1e-300) + float(np.sum(np.log(grown)))
            if cost < best:
                best, found = cost, root * np.sqrt(strength)
    return float(best), found


def _disturbance_model(residuals: Sequence[np.ndarray]) -> np.ndarray:
    """Return A(q) of the disturbance, 1 first, by the Yule-Walker equations."""
    lags = np.zeros(DISTURBANCE_ORDER + 1)
    for residual in residuals:
        for lag in range(min(DISTURBANCE_ORDER + 1, len(residual))):
            lags[lag] += residual[lag:] @ residual[: len(residual) - lag]
    if lags[0] <= 0.0:
        return np.ones(1)
    index = np.abs(np.subtract.outer(np.arange(DISTURBANCE_ORDER), np.arange(DISTURBANCE_ORDER)))
    table = lags[index] + 1e-6 * lags[0] * np.eye(DISTURBANCE_ORDER)
    return np.concatenate([[1.0], -np.linalg.solve(table, lags[1:])])


def _filtered(values: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """Return A(q) values, where all its inputs are known."""
    size = len(values) - len(colour) + 1
    last = len(colour) - 1
    return np.asarray(sum(c * values[last - i : last - i + size] for i, c in enumerate(colour)))
