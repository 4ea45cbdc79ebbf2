"""Loops that are not ours: open loops of python-control's, closed, as models that can be cut."""

from dataclasses import dataclass

import control
import numpy as np
import pytest

from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy


@dataclass(frozen=True)
class ClosedLoop:
    """A closed loop of A_cut, b and c: L(z) = -c (zI - A_cut)⁻¹ b."""

    A_cut: np.ndarray
    b: np.ndarray
    c: np.ndarray
    period: float

    @property
    def A(self):
        return self.A_cut + np.outer(self.b, self.c)

    def cut(self, point):
        return self.A_cut, self.b, self.c


def _closed(open_loop) -> ClosedLoop:
    system = control.ss(open_loop)
    assert not system.D.any()
    return ClosedLoop(system.A, system.B[:, 0], -system.C[0], float(system.dt or 0.0))


@pytest.fixture(scope="session")
def closed():
    """Close an open loop, given as transfer function or state space."""
    return _closed


@pytest.fixture(scope="session")
def study():
    return LinearStudy()


@pytest.fixture(scope="session")
def steering(study):
    return study.sampled()


@pytest.fixture(scope="session")
def holding(study):
    return study.sampled(OperatingPoint(hold=True))
