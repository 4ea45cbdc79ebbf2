r"""The step response of a loop, identified from ordinary flight.

The response y is the setpoint u through the impulse response g of the loop, plus a disturbance:

    y(t) = sum_k g_k u(t - k T) + c_w + e(t),   A(q) e = white

g is found by least squares over all known parts of the flight (a deconvolution in time, free of
leakage from the edges of windows), with

- a constant c_w for each window, for trim and slow disturbances;
- the spectrum of the disturbance: A of order `DISTURBANCE_ORDER` is fitted to the first residuals,
and both
  signals are filtered by it (Cochrane and Orcutt's iteration). This reduces the bias of g from
  turbulence, and from a setpoint that an outer loop computes from the response;
- the prior that g is smooth and decays, cov(g_i, g_j) = c a^max(i, j), with c and a of maximum
  likelihood (Pillonetto et al., "Kernel methods in system identification", Automatica 50, 2014, "TC
  kernel");
- a second fit with taps before 0, which no causal loop has: if the log is much likelier with them,
  clocks disagree, or the setpoint follows the response.

The spread is that of `BOOTSTRAP_DRAWS` draws of windows (block bootstrap). `StepEstimate.doubts`
states what cannot be trusted, and why.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, Grid
from workbench.design.response_metrics import crossing_time
from workbench.design.step_metrics import RISE_SHARES
from workbench.logs.logged_loop import find_logged_loop
from workbench.logs.response_fit import FILTER_SLACK_TAPS, ResponseFits

RESPONSE_TAPS = 120
"""Number of taps of the impulse response from 0 on."""
EARLY_TAPS = 24
"""Number of taps before 0 in the second fit."""
BOOTSTRAP_DRAWS = 100
MIN_SPREAD_WINDOWS = 8
"""Smallest number of windows, of the length of the response each, for a spread."""
MIN_MEAN_COHERENCE = 0.6
"""Smallest coherence, as a mean over frequency weighted with the power of the setpoint."""
MAX_SPREAD_SHARE = 0.15
"""Largest half width of the spread in the settled part, as a share of the final value."""
MAX_ACAUSAL_FIT_GAIN = 30.0
"""Limit of the gain in -2 log p if the response may precede the setpoint."""
MIN_RISE_SAMPLES = 4.0
"""Smallest number of samples of the slower signal within the rise time."""
MIN_FINAL_VALUE = 0.2
"""Smallest final value that counts as a response."""
SETTLED_TAIL_SHARE = 0.4
"""Last share of the response; its mean is the final value."""


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


def identify_step_response(flight: Flight, name: str, length: float | None = None) -> StepEstimate:
    """Return the step response of a loop, from a whole flight.

    Args:
        flight: the log.
        name: one of `LOGGED_LOOPS`, or SETPOINT:RESPONSE.
        length: of the response; by default that of the loop [s].

    Raises:
        WorkbenchError: if the log lacks one of the signals, or has no complete window of them.
    """
    setpoint, response, usual = find_logged_loop(flight, name)
    span = usual if length is None else length
    if not span > 0.0:
        raise WorkbenchError(f"a step response is longer than 0 s, but it is {span:g} s")
    rate = min(flight[setpoint].rate, flight[response].rate)
    period = max(span / RESPONSE_TAPS, 1.0 / rate if rate > 0.0 else 0.0)
    taps = max(round(span / period), 8)
    early = max(round(EARLY_TAPS / RESPONSE_TAPS * taps), FILTER_SLACK_TAPS + 2)
    grid = flight.resample(
        [setpoint, response], period, bridge=1.01 * MAX_INTERPOLATED_PERIODS / rate
    )
    pieces = _pieces(flight, grid, taps + early)
    windows = [window for piece in pieces for window in _windows(piece, taps, early)]
    if len(windows) < 2:
        raise WorkbenchError(
            f"{flight.source}: {setpoint} and {response} are known together for less than "
            f"{2.0 * span:.2g} s without a gap: there is no step response in it"
        )
    coherence = _coherence(pieces, taps)
    fits = ResponseFits(windows, early)
    taps_found = fits.solve(np.ones(len(windows)))
    draws = np.random.default_rng(0).multinomial(
        len(windows), np.full(len(windows), 1.0 / len(windows)), BOOTSTRAP_DRAWS
    )
    steps = np.array([np.cumsum(fits.solve(draw.astype(float))) for draw in draws])
    values = np.cumsum(taps_found)
    low, high = np.percentile(steps, [2.5, 97.5], axis=0)
    low, high = np.minimum(low, values), np.maximum(high, values)
    time = period * (np.arange(len(values)) - FILTER_SLACK_TAPS)
    final = float(values[-max(round(SETTLED_TAIL_SHARE * taps), 1) :].mean())
    rise, overshoot = np.nan, 0.0
    if abs(final) >= 1e-9:
        begin, end = (crossing_time(time, values, share * final) for share in RISE_SHARES)
        rise, overshoot = end - begin, max(float((values / final).max()) - 1.0, 0.0)
    doubts = _doubts(
        span,
        len(windows),
        coherence,
        final,
        0.5 * (high - low)[-max(round(SETTLED_TAIL_SHARE * taps), 1) :].mean(),
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


MAX_INTERPOLATED_PERIODS = 2.5
"""Number of periods of the slower signal to interpolate across."""


def _pieces(flight: Flight, grid: Grid, least: int) -> list[np.ndarray]:
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
            MAX_INTERPOLATED_PERIODS / min(flight[name].rate for name in grid.names) * 1.01,
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
            windows < MIN_SPREAD_WINDOWS,
            f"{windows} windows of {span:g} s are complete: take a longer flight",
        ),
        (
            coherence < MIN_MEAN_COHERENCE,
            f"the coherence is {coherence:.2f}: the response hardly follows the setpoint, or much "
            "else moves it",
        ),
        (final < MIN_FINAL_VALUE, f"it settles at {final:.2f}, but a closed loop settles at 1"),
        (
            width > MAX_SPREAD_SHARE * scale,
            f"the settled part is known to {100.0 * width / scale:.0f} % only: the setpoint moves "
            "too little, or disturbances too much",
        ),
        (
            sooner > MAX_ACAUSAL_FIT_GAIN,
            "the response comes before the setpoint: the clocks differ, or the setpoint follows "
            "the response",
        ),
        (
            not rise_samples >= MIN_RISE_SAMPLES,
            "it rises within fewer than 4 samples of the log: log faster",
        ),
        (
            abs(drift) > 0.1 * scale,
            f"it still moves at its end: it does not settle within {span:g} s",
        ),
    ]
    return tuple(said for so, said in found if so)
