"""The shipped drone, and the diagrams made of it."""

import dataclasses

import numpy as np
import pytest

from workbench.diagram.core import make_flight_core
from workbench.gains import vehicle_gains
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
def gains(vehicle):
    return vehicle_gains(vehicle)


@pytest.fixture(scope="session")
def core(description, vehicle, gains):
    return make_flight_core(description, vehicle, gains)


@pytest.fixture(scope="session")
def system_names():
    """Return the names of a diagram's systems."""
    return lambda diagram: [system.get_name() for system in diagram.GetSystems()]


@pytest.fixture(scope="session")
def dump():
    """Return a function that makes of a reading what compares to the bit."""

    def dumped(reading):
        values = [getattr(reading, field.name) for field in dataclasses.fields(reading)]
        return [each.tobytes() if isinstance(each, np.ndarray) else repr(each) for each in values]

    return dumped
