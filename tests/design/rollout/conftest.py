"""The shipped drone, and the engine that flies it."""

import pytest

from workbench.design.rollout.engine import RolloutEngine


@pytest.fixture(scope="session")
def engine(vehicle):
    return RolloutEngine(vehicle)
