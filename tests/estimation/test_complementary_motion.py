"""The fixed-gain filter of place and velocity on exact samples of a motion in closed form."""

import numpy as np
import pytest

from workbench.estimation.complementary import LAST, initial, update
from workbench.estimation.samples import GPS, SAMPLES, Mounting
from workbench.estimation.settings import ComplementarySettings
from workbench.plant.gravity import GRAVITY

PERIOD = 1 / 128
EVERY = 13
"""Updates between two samples of the GPS."""


def test_an_acceleration_does_not_lag_behind_samples_of_the_gps():
    """Each sample is older than the present by up to 0.1 s, in which 4 m/s^2 make 0.4 m/s."""
    a = np.array([4.0, -2.0, 1.0])
    settings = np.array(ComplementarySettings(complementary_kp=0.0, complementary_ki=0.0))
    memory = initial([1.0, *[0.0] * 12], (0.0, 0.0, 0.0))
    for step in range(1, 257):
        time = step * PERIOD
        z = np.zeros(SAMPLES)
        z[3:6] = a + [0.0, 0.0, GRAVITY]
        if step % EVERY == 0:
            z[GPS : GPS + 8] = 1.0, 0.0, *(0.5 * a * time**2), *(a * time)
        update(memory, z, settings, Mounting().packed(), PERIOD)
        assert memory[7:10] == pytest.approx(a * time, abs=1e-9)
        assert memory[4:7] == pytest.approx(0.5 * a * time**2, abs=1e-9)
    assert memory[LAST] == 1.0
