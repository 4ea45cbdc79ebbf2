"""The shipped drone, which most systems are made for."""

import numpy as np
import pytest

from workbench.parameters import parameters_of
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.resources import find_model
from workbench.systems.cascade import Gains
from workbench.systems.obstacle_brake import WALLS


@pytest.fixture(scope="session")
def description():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="session")
def vehicle(description):
    return make_vehicle(description)


@pytest.fixture(scope="session")
def gains():
    """The values of the parameter table's controller rows."""
    return Gains(**{row.name: row.default for row in parameters_of("controller")})


@pytest.fixture(scope="session")
def random_signals():
    """Return state, acceleration, reference and guidance of a drone in any kind of trouble."""

    def signals(rng: np.random.Generator) -> tuple[list[float], ...]:
        q_WB = rng.normal(size=4)
        state = [*q_WB / np.linalg.norm(q_WB), *rng.uniform(-3, 3, 9)]
        state[6] += 10.0
        reference = [*rng.uniform(-4, 4, 3), rng.normal(), *rng.uniform(0, 9, 3), 0.0]
        reference[7] = float(rng.integers(0, 2))
        weights = rng.integers(0, 2, 3).astype(float)
        guidance = [1.0, 1.0, weights[0], rng.normal(), weights[1], weights[2], *rng.normal(size=3)]
        guidance.append(rng.integers(0, 2) * rng.uniform(0.0, 2.0))
        for _ in range(WALLS):
            n_W = rng.normal(size=3)
            guidance += [*n_W / np.linalg.norm(n_W), rng.uniform(-5, 15)]
        return state, list(rng.normal(size=3)), reference, guidance

    return signals
