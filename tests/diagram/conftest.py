"""The shipped drone, and the diagrams made of it."""

import dataclasses

import numpy as np
import pytest

from workbench.diagram.core import make_flight_core
from workbench.setup import make_setup


@pytest.fixture(scope="session")
def setup(description, vehicle):
    return make_setup(description=description, vehicle=vehicle)


@pytest.fixture(scope="session")
def core(setup):
    return make_flight_core(setup)


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
