"""Find the steps of a command in a flight, and the response to each."""

from dataclasses import dataclass

import numpy as np

from workbench.design.response_metrics import StepMetrics, step_metrics

SHORTEST = 0.3
"""Time that a command must be constant before and after its edge [s]."""
LEAST = 1e-3
"""Smallest change of a command that counts as an edge, in its unit."""
FEWEST = 8
"""Smallest number of samples of a response."""


@dataclass(frozen=True, eq=False)
class StepResponse:
    """A step of the command and the response to it.

    Attributes:
        begin: when the command changed [s].
        amplitude: by how much.
        time: from the edge on (n) [s].
        response: (n), relative to the command before the edge.
        metrics: python-control's numbers.
    """

    begin: float
    amplitude: float
    time: np.ndarray
    response: np.ndarray
    metrics: StepMetrics


def step_responses(
    command: tuple[np.ndarray, np.ndarray], flown: tuple[np.ndarray, np.ndarray]
) -> list[StepResponse]:
    """Return the steps of a command that is constant before and after its edge, in order.

    A command that changes at every sample, such as a ramp or a stick, has no steps.

    Args:
        command: times (m) [s] and values.
        flown: times (n) [s] and values of the commanded quantity.
    """
    time, values = command
    edges = 1 + np.flatnonzero(np.abs(np.diff(values)) > LEAST)
    bounds = np.concatenate([time[:1], time[edges], time[-1:]])
    found = []
    for index, edge in enumerate(edges):
        before, begin, end = bounds[index : index + 3]
        if begin - before < SHORTEST or end - begin < SHORTEST:
            continue
        start = float(values[edge - 1])
        amplitude = float(values[edge]) - start
        until = end if index + 1 < len(edges) else np.inf
        part = (flown[0] >= begin) & (flown[0] < until) & np.isfinite(flown[1])
        since = flown[0][part] - begin
        if len(since) < FEWEST:
            continue
        response = np.asarray(flown[1][part], dtype=float) - start
        metrics = step_metrics(since, response, amplitude)
        found.append(StepResponse(float(begin), amplitude, since, response, metrics))
    return found
