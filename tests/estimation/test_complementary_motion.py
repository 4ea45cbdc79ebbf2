"""The fixed-gain filter of place and velocity on exact samples of a motion in closed form."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.estimation.complementary import LAST_SAMPLES_INDEX, initial_complementary, update
from workbench.estimation.samples import BAROMETER, GPS, SAMPLE_ARRAY_SIZE, Mounting
from workbench.estimation.settings import ComplementarySettings
from workbench.plant.gravity import GRAVITY

PERIOD = 1 / 128
EVERY = 13
"""Updates between two samples of the GPS."""


def test_an_acceleration_does_not_lag_behind_samples_of_the_gps():
    """Each sample is older than the present by up to 0.1 s, in which 4 m/s^2 make 0.4 m/s."""
    a = np.array([4.0, -2.0, 1.0])
    settings = np.array(ComplementarySettings(complementary_kp=0.0, complementary_ki=0.0))
    memory = initial_complementary([1.0, *[0.0] * 12], (0.0, 0.0, 0.0))
    for step in range(1, 257):
        time = step * PERIOD
        z = np.zeros(SAMPLE_ARRAY_SIZE)
        z[3:6] = a + [0.0, 0.0, GRAVITY]
        if step % EVERY == 0:
            z[GPS : GPS + 8] = 1.0, 0.0, *(0.5 * a * time**2), *(a * time)
        update(memory, z, settings, Mounting().packed(), PERIOD)
        assert memory[7:10] == pytest.approx(a * time, abs=1e-9)
        assert memory[4:7] == pytest.approx(0.5 * a * time**2, abs=1e-9)
    assert memory[LAST_SAMPLES_INDEX] == 1.0


def test_a_late_sample_of_the_gps_is_carried_to_the_present():
    """At 5 m/s a fix of 0.12 s ago is 0.6 m behind, and the estimate stays where the drone is."""
    v, age = np.array([3.0, -4.0, 0.5]), 0.12
    memory = initial_complementary([1.0, *[0.0] * 9, *v], (0.0, 0.0, 0.0))
    settings = np.array(ComplementarySettings(complementary_kp=0.0, complementary_ki=0.0))
    for step in range(1, 257):
        time = step * PERIOD
        z = np.zeros(SAMPLE_ARRAY_SIZE)
        z[5] = GRAVITY
        if step % EVERY == 0:
            z[GPS : GPS + 8] = 1.0, age, *(v * (time - age)), *v
        update(memory, z, settings, Mounting().packed(), PERIOD)
        assert memory[4:7] == pytest.approx(v * time, abs=1e-9)
        assert memory[7:10] == pytest.approx(v, abs=1e-9)


def test_a_climb_does_not_lag_behind_samples_of_the_barometer():
    """At 4 m/s a height of 0.1 s ago is 0.4 m too low."""
    memory = initial_complementary([1.0, *[0.0] * 11, 4.0], (0.0, 0.0, 0.0))
    settings = np.array(ComplementarySettings(complementary_kp=0.0, complementary_ki=0.0))
    for step in range(1, 257):
        z = np.zeros(SAMPLE_ARRAY_SIZE)
        z[5] = GRAVITY
        if step % EVERY == 0:
            z[BAROMETER : BAROMETER + 2] = 1.0, 4.0 * step * PERIOD
        update(memory, z, settings, Mounting().packed(), PERIOD)
        assert memory[6] == pytest.approx(4.0 * step * PERIOD, abs=1e-9)
        assert memory[9] == pytest.approx(4.0, abs=1e-9)


def test_the_last_sample_of_the_gps_counts_for_a_second_and_no_longer():
    """One fix 1 m and 1 m/s beside the estimate; 128 updates a second, and it is of the second."""
    memory = initial_complementary([1.0, *[0.0] * 12], (0.0, 0.0, 0.0))
    z, speeds = np.zeros(SAMPLE_ARRAY_SIZE), [0.0]
    z[5] = GRAVITY
    for step in range(1, 257):
        z[GPS : GPS + 8] = (1.0, 0.0, 1.0, 0, 0, 1.0, 0, 0) if step == 2 else np.zeros(8)
        update(memory, z, np.array(ComplementarySettings()), Mounting().packed(), PERIOD)
        speeds.append(memory[7])
    changes = np.flatnonzero(np.diff(speeds)) + 1
    assert changes.tolist() == list(range(2, 2 + 128 + 1))


def test_only_a_specific_force_near_that_of_rest_tells_where_up_is(case):
    """From half to one and a half g it turns the attitude back; in free fall it tells nothing."""
    off = Rotation.from_rotvec([0.3, 0.0, 0.0])
    settings = np.array(ComplementarySettings(complementary_ki=0.0))
    for share, tells in ((0.0, False), (0.45, False), (0.55, True), (1.45, True), (1.55, False)):
        with case(share):
            memory = initial_complementary(
                [*off.as_quat(scalar_first=True), *[0.0] * 9], (0.0, 0.0, 0.0)
            )
            z = np.zeros(SAMPLE_ARRAY_SIZE)
            z[5] = share * GRAVITY  # along the true up: the true attitude is level
            update(memory, z, settings, Mounting().packed(), PERIOD)
            turned = Rotation.from_quat(memory[:4], scalar_first=True).as_rotvec()
            back = settings[0] * PERIOD * np.sin(0.3) if tells else 0.0
            assert turned == pytest.approx([0.3 - back, 0.0, 0.0], abs=1e-9)
