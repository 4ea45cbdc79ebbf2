"""Flights of the diagram as motions: what predictions start from, made by other code."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pytest

from workbench.extras.flightdata.predict.motion import LoggedMotion, rotation_matrices
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

STEP = 1 / 128
"""About so long is it between two samples, which are whole control periods apart [s]."""
POINTS = ((0.0, (0.0, 0.0, 1.5)), (0.5, (1.0, 0.0, 1.5)), (2.5, (1.0, 1.0, 2.0)))
"""Where the pilot goes to, and from when on."""


class Simulated(NamedTuple):
    """A flight of the diagram: states (m, 13) at times [s]."""

    motion: LoggedMotion
    states: np.ndarray
    vehicle: Vehicle


@pytest.fixture(scope="session")
def simulate() -> Callable[..., Simulated]:
    """Return a function that flies a scenario from point to point."""

    def fly(
        scenario: Scenario,
        settings: Mapping[str, float] | None = None,
        duration: float = 4.0,
        push: tuple[float, float, float] | None = None,
    ) -> Simulated:
        session = Session(scenario, settings)
        period = session.scenario.rates.control_period
        step = period * round(STEP / period)
        states, points = [], []
        for number in range(int(duration / step)):
            now = number * step
            asked = [point for begin, point in POINTS if begin <= now + 1e-9][-1]
            if not points or asked != points[-1]:
                session.go_to(asked)
            if push and number == round(1.5 / step):
                session.push(push, duration=0.5)
            states.append(session.state().copy())
            points.append(asked)
            session.tick(step)
        rows, vehicle = np.array(states), session.vehicle
        q, p, v = rows[:, 0:4], rows[:, 4:7], rows[:, 10:13]
        nothing = np.full(len(rows), np.nan)
        most = np.array([rotor.max_rot_velocity for rotor in vehicle.rotors])
        motion = LoggedMotion(
            "simulated",
            step,
            q,
            p,
            v,
            rotation_matrices(q).inv().apply(rows[:, 7:10]),
            q,
            p,
            v,
            np.array(points),
            np.repeat(nothing[:, None], 3, axis=1),
            nothing,
            np.repeat((vehicle.hover_speeds / most)[None], len(rows), axis=0),
            nothing,
            np.ones(len(rows), bool),
        )
        return Simulated(motion, rows, vehicle)

    return fly
