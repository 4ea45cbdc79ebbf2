"""A step by the linear model and in flight, from curves that are known."""

import numpy as np
import pytest

from workbench.design.judge.step_pair import StepPair
from workbench.design.step_metrics import step_metrics


def test_the_difference_is_a_share_of_the_amplitude_in_either_direction(case):
    time = np.linspace(0.0, 5.0, 641)
    rise = 1.0 - np.exp(-2.0 * time)
    off = 0.03 * np.sin(2.0 * time)
    for amplitude in (2.0, -0.5):
        linear, flown = amplitude * rise, amplitude * (rise + off)
        metrics = step_metrics(time, linear, amplitude)
        pair = StepPair("x", amplitude, time, linear, flown, metrics, metrics)
        with case(amplitude):
            assert pair.difference == pytest.approx(0.03, rel=1e-3)
