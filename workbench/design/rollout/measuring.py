"""Metrics of step responses as they compile: `response_metrics`, one after the other."""

import math

import numpy as np

from workbench.design.response_metrics import LOWER, SETTLED, UPPER

NUMBERS = 10
"""As many as `ResponseMetrics` has."""


def measure_steps(time, responses, command, numbers):  # type: ignore[no-untyped-def]
    """Write the metrics of responses; this is what gets compiled.

    Args:
        time: (M) from 0 [s].
        responses: (M, m or more), at rest at 0; NaN from when one is lost on.
        command: what they should come to; not 0.
        numbers: (m, 10) places for the metrics, in the order of `ResponseMetrics`.
    """
    size = len(time)
    level = UPPER * command
    way = np.sign(level)
    for i in range(len(numbers)):
        steady = responses[size - 1, i]
        sign = np.sign(steady)
        begin = end = arrival = -1
        settled = 0
        top, bottom, peak = -math.inf, math.inf, -1.0
        lowest, peak_at = 0.0, 0
        for k in range(size):
            value = responses[k, i]
            if arrival < 0 and value * way >= abs(level):
                arrival = k
            forward = sign * value
            if begin < 0 and sign * (value - LOWER * steady) >= 0.0:
                begin = k
            if end < 0 and sign * (value - UPPER * steady) >= 0.0:
                end = k
            if abs(value / steady - 1.0) >= SETTLED:
                settled = k + 1
            if forward > top:
                top = forward
            if forward < bottom:
                bottom = forward
                lowest = value
            if abs(value) > peak:
                peak = abs(value)
                peak_at = k
        row = numbers[i]
        row[:] = math.nan
        row[4] = row[5] = math.inf
        row[9] = responses[0, i]
        if arrival >= 0:
            row[8] = time[arrival]
        if arrival > 0:
            low, high = responses[arrival - 1, i], responses[arrival, i]
            part = (level - low) / (high - low)
            row[8] = time[arrival - 1] + part * (time[arrival] - time[arrival - 1])
        if not math.isfinite(steady):
            continue
        row[0] = time[max(end, 0)] - time[max(begin, 0)]
        row[1] = time[settled] if settled < size else math.nan
        above = abs(top) - abs(steady)
        row[2] = abs(100.0 * above / steady) if above > 0.0 else 0.0
        row[3] = -100.0 * lowest / steady if sign * lowest < 0.0 else 0.0
        row[4] = peak
        row[5] = time[peak_at]
        row[6] = steady
        row[7] = 100.0 * abs(steady - command) / abs(command)
