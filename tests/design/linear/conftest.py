"""Studies of the shipped drone, and of one of which all is stated that may be."""

from pathlib import Path

import pytest

from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, VehicleConfig

ORACLES = Path(__file__).resolve().parents[2] / "oracles"


@pytest.fixture(scope="session")
def study():
    return LinearStudy()


@pytest.fixture(scope="session")
def effects_study():
    """With inflow, ground effect, a thrust curve and a battery that sags."""
    rotors = str(ORACLES / "effects.rotors.yaml")
    config = VehicleConfig(str(ORACLES / "uneven_quad.urdf"), rotors=rotors)
    return LinearStudy(Scenario(vehicle=config))
