"""Estimates after touch-downs: shocks of contact must not tilt them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.scenario.scenario import Action, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session

SETTLED = 3.0
"""Time after the last contact from which on the estimate is judged [s]."""
HEIGHT = 0.9
"""Of the hover before [m]."""
NEES = 15.0
"""Largest mean of a normalised squared error of three angles: their mean is 3, and one in a
thousand is above 16.3 if it is constant over a second."""


def bounced(seed: int) -> tuple[float, float]:
    """Return the mean NEES of the attitude, and its largest error [rad], after a bounce."""
    rng = np.random.default_rng(seed)
    sink, drift = rng.uniform(0.4, 1.5), rng.uniform(-1.0, 1.0)
    down = 1.2 * HEIGHT / sink + 0.3
    script = [
        Action(at=1.0, velocity=[drift, 0.0, -sink]),
        Action(at=1.0 + down, velocity=[0.0, 0.0, 0.6]),
        Action(at=3.0 + down, velocity=[0.0, 0.0, 0.0]),
    ]
    session = Session(
        Scenario(
            duration=1.5 + down + SETTLED + 1.0,
            start=ScenarioStart(position=[0.0, 0.0, HEIGHT]),
            script=script,
            estimator="ekf",
            sensors=SensorsConfig(seed=seed),
        ),
        {"max_climb_rate": 3.0},
    )
    session.run()
    flown = session._flown()
    time, signals = flown.time, flown.signals
    state, known = signals["state"], signals["estimate"]
    touches = time[state[:, 6] < session.vehicle.ground_clearance + 0.005]
    assert len(touches)
    after = time > touches[-1] + SETTLED
    assert after.sum() > 60
    true, found = (Rotation.from_quat(each[after][:, [1, 2, 3, 0]]) for each in (state, known))
    error = (true * found.inv()).as_rotvec()
    shares = (error / signals["deviations"][after][:, 0:3]) ** 2
    return float(shares.sum(axis=1).mean()), float(np.abs(error).max())


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 20))]
)
def test_an_estimate_is_consistent_three_seconds_after_a_bounce(seed):
    nees, error = bounced(seed)
    assert nees < NEES
    assert np.degrees(error) < 0.3
