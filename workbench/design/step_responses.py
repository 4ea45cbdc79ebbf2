"""Find the steps of a command in a flight, and the response to each."""

from dataclasses import dataclass

import numpy as np

from workbench.design.step_metrics import StepMetrics, step_metrics

MIN_CONSTANT_COMMAND_S = 0.3
"""Time that a command must be constant before and after its edge [s]."""
MIN_COMMAND_CHANGE = 1e-3
"""Smallest change of a command that counts as an edge, in its unit."""
MIN_RESPONSE_SAMPLES = 8
"""Smallest number of samples of a response."""


@dataclass(frozen=True, eq=False)
class LoggedStep:
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
) -> list[LoggedStep]:
    """Return the steps of a command that is constant before and after its edge, in order.

    A command that changes at every sample, such as a ramp or a stick, has no steps.

    Args:
        command: times (m) [s] and values.
        flown: times (n) [s] and values of the commanded quantity.
    """
    time, values = command
    edges = 1 + np.flatnonzero(np.abs(np.diff(values)) > MIN_COMMAND_CHANGE)
    bounds = np.concatenate([time[:1], time[edges], time[-1:]])
    found = []
    for index, edge in enumerate(edges):
        before, begin, end = bounds[index : index + 3]
        if begin - before < MIN_CONSTANT_COMMAND_S or end - begin < MIN_CONSTANT_COMMAND_S:
            continue
        start = float(values[edge - 1])
        amplitude = float(values[edge]) - start
        until = end if index + 1 < len(edges) else np.inf
        part = (flown[0] >= begin) & (flown[0] < until) & np.isfinite(flown[1])
        since = flown[0][part] - begin
        if len(since) < MIN_RESPONSE_SAMPLES:
            continue
        response = np.asarray(flown[1][part], dtype=float) - start
        metrics = step_metrics(since, response, amplitude)
        found.append(LoggedStep(float(begin), amplitude, since, response, metrics))
    return found
