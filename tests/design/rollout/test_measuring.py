"""Oracle: `response_metrics`, which equals python-control's."""

from dataclasses import astuple, fields

import numpy as np
import pytest

from workbench.design.response_metrics import ResponseMetrics, response_metrics
from workbench.design.rollout.engine import compiled_measures

NUMBERS = len(fields(ResponseMetrics))
TIME = np.arange(200) / 128.0


def responses(command: float) -> np.ndarray:
    """Return curves (N, M): smooth and ringing ones, some that are none, and borders."""
    rng = np.random.default_rng(4)
    rate, ring = rng.uniform(2.0, 30.0, (2, 40, 1))
    smooth = 1.0 - np.exp(-rate * TIME) * np.cos(ring * TIME)
    wrong = -0.3 * np.exp(-5.0 * TIME) * np.sin(9.0 * TIME) + 1.0 - np.exp(-3.0 * TIME)
    lost = np.where(TIME < 0.5, TIME, np.nan)
    borders = [wrong, lost, 0.0 * TIME, np.full(200, np.nan), np.ones(200), -TIME, 0.5 * TIME]
    return command * np.vstack([smooth, borders])


@pytest.mark.parametrize("command", [2.0, -0.3])
def test_metrics_are_those_of_one_array_at_a_time(command):
    curves = responses(command)
    numbers = np.empty((len(curves), NUMBERS))
    compiled_measures(TIME, np.ascontiguousarray(curves.T), command, numbers)
    for column, wanted in zip(
        numbers.T, astuple(response_metrics(TIME, curves, command)), strict=True
    ):
        np.testing.assert_array_equal(column, wanted)


def test_it_may_be_handed_more_curves_than_there_are_candidates():
    curves = np.ascontiguousarray(responses(1.0)[:16].T)
    some, whole = np.empty((5, NUMBERS)), np.empty((16, NUMBERS))
    compiled_measures(TIME, curves, 1.0, some)
    compiled_measures(TIME, curves, 1.0, whole)
    np.testing.assert_array_equal(some, whole[:5])
