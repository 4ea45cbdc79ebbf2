"""The shipped drone, and the engine that flies it."""

import pytest

from workbench.design.rollout.engine import RolloutEngine
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.resources import find_model


@pytest.fixture(scope="session")
def description():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="session")
def vehicle(description):
    return make_vehicle(description)


@pytest.fixture(scope="session")
def engine(vehicle):
    return RolloutEngine(vehicle)
