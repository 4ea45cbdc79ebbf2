"""The shipped drone, and the diagrams made of it."""

import dataclasses

import numpy as np
import pytest

from workbench.control.controller import load_controller
from workbench.diagram.core import make_flight_core
from workbench.gains.gains import flight_gains


@pytest.fixture(scope="session")
def gains(vehicle):
    return flight_gains(vehicle)


@pytest.fixture(scope="session")
def core(description, vehicle, gains):
    return make_flight_core(load_controller(), description, vehicle, gains)


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
