"""A problem whose answers are known in closed form: a second-order system."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest

from workbench.design.tune.case import NOMINAL_CASE, Robustness
from workbench.design.tune.requirement import requirements
from workbench.design.tune.wish import merged_wishes, parse_wish


@dataclass(frozen=True)
class SecondOrder:
    """A step of w² / (s² + 2 z w s + w²), searched over ln w and ln z.

    Peak rotor use stands for the effort, w² over 100.
    """

    requirements: tuple
    looked: list = dataclasses.field(default_factory=list)

    low = np.log([0.1, 0.05])
    high = np.log([100.0, 5.0])
    matters = np.array([True, True])

    def demanding(self, requirements):
        return dataclasses.replace(self, requirements=tuple(requirements))

    def values(self, points):
        self.looked.extend(points)
        rows = []
        for point in points:
            w, z = np.exp(point)
            damped = math.sqrt(max(1e-9, 1.0 - z * z))
            overshoot = 100.0 * math.exp(-math.pi * z / damped) if z < 1.0 else 0.0
            numbers = {
                "rise_time": (1.0 - 0.4167 * z + 2.917 * z * z) / w,
                "overshoot": overshoot,
                "peak_rotor_use": w * w / 100.0,
            }
            rows.append([numbers[required.wish.metric.name] for required in self.requirements])
        return np.array(rows)


@pytest.fixture
def second_order():
    """Return the problem of wishes, as texts."""

    def make(*texts):
        wishes = merged_wishes([wish for text in texts for wish in parse_wish(text)])
        return SecondOrder(requirements(wishes, [NOMINAL_CASE], Robustness()))

    return make
