r"""The step response of a loop, identified from ordinary flight.

The response y is the setpoint u through the impulse response g of the loop, plus a disturbance:

    y(t) = sum_k g_k u(t - k T) + c_w + e(t),   A(q) e = white

g is found by least squares over all known parts of the flight (a deconvolution in time, free of
leakage from the edges of windows), with

- a constant c_w for each window, for trim and slow disturbances;
- the spectrum of the disturbance: A of order `ORDER` is fitted to the first residuals, and both
  signals are filtered by it (Cochrane and Orcutt's iteration). This reduces the bias of g from
  turbulence, and from a setpoint that an outer loop computes from the response;
- the prior that g is smooth and decays, cov(g_i, g_j) = c a^max(i, j), with c and a of maximum
  likelihood (Pillonetto et al., "Kernel methods in system identification", Automatica 50, 2014, "TC
  kernel");
- a second fit with taps before 0, which no causal loop has: if the log is much likelier with them,
  clocks disagree, or the setpoint follows the response.

The spread is that of `DRAWS` draws of windows (block bootstrap). `StepEstimate.doubts` states what
cannot be trusted, and why.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.logs.flight_record import FlightRecord, Grid

TAPS = 120
"""Number of taps of the impulse response from 0 on."""
EARLY = 24
"""Number of taps before 0 in the second fit."""
ORDER = 6
"""Order of the model of the disturbance."""
SLACK = 2
"""Number of taps before 0 that filters and interpolation may cause."""
DRAWS = 100
LEAST_WINDOWS = 8
"""Smallest number of windows, of the length of the response each, for a spread."""
LEAST_COHERENCE = 0.6
"""Smallest coherence, as a mean over frequency weighted with the power of the setpoint."""
WIDEST = 0.15
"""Largest half width of the spread in the settled part, as a share of the final value."""
SOONER = 30.0
"""Limit of the gain in -2 log p if the response may precede the setpoint."""
LEAST_RISE = 4.0
"""Smallest number of samples of the slower signal within the rise time."""
LEAST_GAIN = 0.2
"""Smallest final value that counts as a response."""
SETTLED = 0.4
"""Last share of the response; its mean is the final value."""


@dataclass(frozen=True)
class Loop:
    """A loop that may have a response in a log, with its setpoint and response.

    Attributes:
        setpoints: signals; the first one in the log is used.
        responses: signals; the first one in the log is used.
        length: of its step response [s].
    """

    setpoints: tuple[str, ...]
    responses: tuple[str, ...]
    length: float


def _loops() -> dict[str, Loop]:
    found = {}
    for axis, angle in zip("xyz", ("roll", "pitch", "yaw"), strict=True):
        found[f"{angle}_rate"] = Loop(
            (f"rate_setpoint.w_{axis}",),
            (f"imu.angular_velocity.{axis}", f"estimate.w_{axis}", f"attitude.w_{axis}"),
            0.6,
        )
        found[angle] = Loop(
            (f"attitude_setpoint.{angle}",),
            (f"estimate.{angle}", f"position_data.{angle}"),
            1.6,
        )
        found[f"v_{axis}"] = Loop(
            (f"setpoint.v_{axis}", f"command_velocity.v_{axis}"),
            (f"velocity_data.v_{axis}", f"estimate.v_{axis}"),
            3.0,
        )
        found[axis] = Loop(
            (f"setpoint.{axis}",), (f"position_data.{axis}", f"estimate.{axis}"), 5.0
        )
    found["yaw_rate"] = Loop(
        (*found["yaw_rate"].setpoints, "command_velocity.yaw_rate"),
        (*found["yaw_rate"].responses, "velocity_data.w_z"),
        0.6,
    )
    return found


LOOPS: Mapping[str, Loop] = _loops()
"""Loops by name."""


@dataclass(frozen=True, eq=False)
class StepEstimate:
    """A step response identified from a flight.

    Attributes:
        name: of the loop.
        setpoint: the signal.
        response: the signal.
        time: from a few samples before the step of the setpoint (n) [s].
        values: response to a step of 1 (n).
        low, high: bounds of 95 % (n).
        coherence: of response and setpoint over frequency, weighted with the power of the setpoint.
        windows: number of complete windows of the length of the response.
        final: settled value.
        rise: time from 10 to 90 % of the final value [s]; NaN if not reached.
        overshoot: as a share of the final value.
        doubts: reasons not to trust it, a sentence each.
    """

    name: str
    setpoint: str
    response: str
    time: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    coherence: float
    windows: int
    final: float
    rise: float
    overshoot: float
    doubts: tuple[str, ...]

    @property
    def trusted(self) -> bool:
        """Whether there are no doubts."""
        return not self.doubts


def find_loop(flight: FlightRecord, name: str) -> tuple[str, str, float]:
    """Return setpoint, response and length [s] of a loop in a log.

    Args:
        flight: the log.
        name: one of `LOOPS`, or SETPOINT:RESPONSE of any two signals.

    Raises:
        WorkbenchError: if the log lacks one of the signals.
    """
    if ":" in name:
        setpoint, _, response = name.partition(":")
        return flight[setpoint].name, flight[response].name, 1.6
    if name not in LOOPS:
        raise unknown_name("loop", name, LOOPS)
    loop = LOOPS[name]
    setpoint = next((each for each in loop.setpoints if each in flight), "")
    response = next((each for each in loop.responses if each in flight), "")
    for found, wanted in ((setpoint, loop.setpoints), (response, loop.responses)):
        if not found:
            raise WorkbenchError(
                f"{flight.source}: has no {' or '.join(wanted)}, so {name} has no step response"
            )
    return setpoint, response, loop.length


def step_response(flight: FlightRecord, name: str, length: float | None = None) -> StepEstimate:
    """Return the step response of a loop, from a whole flight.

    Args:
        flight: the log.
        name: one of `LOOPS`, or SETPOINT:RESPONSE.
        length: of the response; by default that of the loop [s].

    Raises:
        WorkbenchError: if the log lacks one of the signals, or has no complete window of them.
    """
    setpoint, response, usual = find_loop(flight, name)
    span = usual if length is None else length
    if not span > 0.0:
        raise WorkbenchError(f"a step response is longer than 0 s, but it is {span:g} s")
    rate = min(flight[setpoint].rate, flight[response].rate)
    period = max(span / TAPS, 1.0 / rate if rate > 0.0 else 0.0)
    taps = max(round(span / period), 8)
    early = max(round(EARLY / TAPS * taps), SLACK + 2)
    grid = flight.resample([setpoint, response], period, bridge=1.01 * GAP_PERIODS / rate)
    pieces = _pieces(flight, grid, taps + early)
    windows = [window for piece in pieces for window in _windows(piece, taps, early)]
    if len(windows) < 2:
        raise WorkbenchError(
            f"{flight.source}: {setpoint} and {response} are known together for less than "
            f"{2.0 * span:.2g} s without a gap: there is no step response in it"
        )
    coherence = _coherence(pieces, taps)
    fits = _Fits(windows, early)
    taps_found = fits.solve(np.ones(len(windows)))
    draws = np.random.default_rng(0).multinomial(
        len(windows), np.full(len(windows), 1.0 / len(windows)), DRAWS
    )
    steps = np.array([np.cumsum(fits.solve(draw.astype(float))) for draw in draws])
    values = np.cumsum(taps_found)
    low, high = np.percentile(steps, [2.5, 97.5], axis=0)
    low, high = np.minimum(low, values), np.maximum(high, values)
    time = period * (np.arange(len(values)) - SLACK)
    final = float(values[-max(round(SETTLED * taps), 1) :].mean())
    rise, overshoot = _figures(time, values, final)
    doubts = _doubts(
        span,
        len(windows),
        coherence,
        final,
        0.5 * (high - low)[-max(round(SETTLED * taps), 1) :].mean(),
        fits.sooner,
        rise * rate,
        float(np.ptp(np.concatenate([piece[:, 0] for piece in pieces]))),
        float(values[-1] - values[-max(round(0.2 * taps), 2)]),
    )
    return StepEstimate(
        name,
        setpoint,
        response,
        time,
        values,
        low,
        high,
        coherence,
        len(windows),
        final,
        rise,
        overshoot,
        doubts,
    )


GAP_PERIODS = 2.5
"""Number of periods of the slower signal to interpolate across."""


def _pieces(flight: FlightRecord, grid: Grid, least: int) -> list[np.ndarray]:
    """Return setpoint and response (n, 2) of each complete stretch that is long enough.

    A signal faster than the grid is first low-passed. The other one gets the same filter, so that
    their relation stays the same.
    """
    from scipy.signal import butter, sosfiltfilt  # slow to load

    period = float(grid.time[1] - grid.time[0]) if len(grid.time) > 1 else 1.0
    fine = max(flight[name].rate for name in grid.names)
    factor = int(min(fine * period, 64.0))
    if factor > 1:
        fast = flight.resample(
            list(grid.names),
            period / factor,
            GAP_PERIODS / min(flight[name].rate for name in grid.names) * 1.01,
            (float(grid.time[0]), float(grid.time[-1])),
        )
        values, whole = fast.values, fast.whole
    else:
        values, whole = grid.values, grid.whole
    edges = np.flatnonzero(np.diff(np.concatenate([[0], whole.astype(np.int8), [0]])))
    pieces = []
    sections = butter(4, 0.8 / factor, output="sos") if factor > 1 else None
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin < factor * least:
            continue
        piece = values[begin:end]
        if sections is not None:
            piece = sosfiltfilt(sections, piece, axis=0)[::factor]
        pieces.append(piece)
    return pieces


def _windows(piece: np.ndarray, taps: int, early: int) -> list[np.ndarray]:
    """Return windows of a piece with consecutive responses, each with the samples before it."""
    size = taps
    found = []
    for begin in range(taps - 1, len(piece) - early - size + 1, size):
        found.append(piece[begin - taps + 1 : begin + size + early])
    return found


class _Fits:
    """Least squares of windows, each with a weight.

    Attributes:
        sooner: gain in the likelihood of the log, in -2 log p, with noncausal taps.
    """

    def __init__(self, windows: Sequence[np.ndarray], early: int) -> None:
        rows = [_rows(window, early) for window in windows]
        causal = slice(early - SLACK, None)
        first = _ridge([(phi[:, causal], y) for phi, y in rows])
        colour = _colour([y - phi[:, causal] @ first for phi, y in rows])
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
        """Return the taps, from `SLACK` before 0 on."""
        inner = np.tensordot(weights, self._inner, 1) + np.eye(len(self._root))
        return np.asarray(self._root @ np.linalg.solve(inner, weights @ self._turned))


def _rows(window: np.ndarray, early: int) -> tuple[np.ndarray, np.ndarray]:
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


def _colour(residuals: Sequence[np.ndarray]) -> np.ndarray:
    """Return A(q) of the disturbance, 1 first, by the Yule-Walker equations."""
    lags = np.zeros(ORDER + 1)
    for residual in residuals:
        for lag in range(min(ORDER + 1, len(residual))):
            lags[lag] += residual[lag:] @ residual[: len(residual) - lag]
    if lags[0] <= 0.0:
        return np.ones(1)
    index = np.abs(np.subtract.outer(np.arange(ORDER), np.arange(ORDER)))
    table = lags[index] + 1e-6 * lags[0] * np.eye(ORDER)
    return np.concatenate([[1.0], -np.linalg.solve(table, lags[1:])])


def _filtered(values: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """Return A(q) values, where all its inputs are known."""
    size = len(values) - len(colour) + 1
    last = len(colour) - 1
    return np.asarray(sum(c * values[last - i : last - i + size] for i, c in enumerate(colour)))


def _coherence(pieces: Sequence[np.ndarray], taps: int) -> float:
    """Return the coherence of setpoint and response, weighted with the power of the setpoint."""
    from scipy.signal import csd  # slow to load

    size = 2 * taps
    total: list[np.ndarray] = [np.zeros(size // 2 + 1)] * 3
    seen = 0.0
    for piece in pieces:
        if len(piece) < size:
            continue
        u, y = piece.T
        part = [csd(a, b, nperseg=size, detrend="linear")[1] for a, b in ((u, u), (y, y), (u, y))]
        total = [before + len(piece) * now for before, now in zip(total, part, strict=True)]
        seen += len(piece)
    power, other, cross = (np.abs(each[1:]) for each in total)
    if seen == 0.0 or power.sum() <= 1e-20 * float(np.abs(total[1]).sum()):
        return 0.0
    averages = max(2.0 * seen / size - 1.0, 1.0)
    coherent = np.divide(
        cross**2, power * other, out=np.zeros_like(power), where=power * other > 0.0
    )
    # With so few averages even noise has a coherence of 1 / averages.
    unbiased = np.clip((coherent * averages - 1.0) / max(averages - 1.0, 1.0), 0.0, 1.0)
    return float(np.sum(power * unbiased) / power.sum()) if averages > 1.0 else 0.0


def _figures(time: np.ndarray, values: np.ndarray, final: float) -> tuple[float, float]:
    """Return rise time [s] and overshoot, a share."""
    if abs(final) < 1e-9:
        return np.nan, 0.0
    share = values / final
    after = [np.flatnonzero(share >= level) for level in (0.1, 0.9)]
    if not all(len(each) for each in after):
        return np.nan, 0.0
    crossed = []
    for level, each in zip((0.1, 0.9), after, strict=True):
        i = int(each[0])
        if i == 0:
            crossed.append(float(time[0]))
            continue
        part = (level - share[i - 1]) / max(share[i] - share[i - 1], 1e-12)
        crossed.append(float(time[i - 1] + part * (time[i] - time[i - 1])))
    return crossed[1] - crossed[0], max(float(share.max()) - 1.0, 0.0)


def _doubts(
    span: float,
    windows: int,
    coherence: float,
    final: float,
    width: float,
    sooner: float,
    rise_samples: float,
    moved: float,
    drift: float,
) -> tuple[str, ...]:
    """Return reasons not to trust a step response."""
    if moved == 0.0:
        return ("the setpoint never moves",)
    scale = max(abs(final), 1e-9)
    found = [
        (
            windows < LEAST_WINDOWS,
            f"{windows} windows of {span:g} s are complete: take a longer flight",
        ),
        (
            coherence < LEAST_COHERENCE,
            f"the coherence is {coherence:.2f}: the response hardly follows the setpoint, or much "
            "else moves it",
        ),
        (final < LEAST_GAIN, f"it settles at {final:.2f}, but a closed loop settles at 1"),
        (
            width > WIDEST * scale,
            f"the settled part is known to {100.0 * width / scale:.0f} % only: the setpoint moves "
            "too little, or disturbances too much",
        ),
        (
            sooner > SOONER,
            "the response comes before the setpoint: the clocks differ, or the setpoint follows "
            "the response",
        ),
        (
            not rise_samples >= LEAST_RISE,
            "it rises within fewer than 4 samples of the log: log faster",
        ),
        (
            abs(drift) > 0.1 * scale,
            f"it still moves at its end: it does not settle within {span:g} s",
        ),
    ]
    return tuple(said for so, said in found if so)
