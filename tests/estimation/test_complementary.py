"""The complementary filter beside the closed forms of its equations."""

import numpy as np
import pytest
from scipy import linalg, signal
from scipy.spatial.transform import Rotation

from workbench.estimation import complementary
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, SAMPLE_ARRAY_SIZE, Mounting
from workbench.estimation.settings import ComplementarySettings

G = np.array([0.0, 0.0, 9.81])
DT = 1 / 1024
FIELD = np.array([0.0, 2e-5, -4e-5])
LEVEL = [1.0, 0.0, 0.0, 0.0]
WITHOUT_KI = ComplementarySettings(complementary_ki=0.0)


def still(R=None, bias=(0.0, 0.0, 0.0)):
    """Return the samples of an IMU that hangs still at an attitude."""
    z = np.zeros(SAMPLE_ARRAY_SIZE)
    z[0:3] = bias
    z[3:6] = G if R is None else R.inv().apply(G)
    return z


def memory_at(q):
    return complementary.initial_complementary([*q, *[0.0] * 9], (0.0, 0.0, 0.0))


def run(kit, memory, z, settings, duration, mounting=None):
    """Return what the memory was after each update."""
    places, numbers = (mounting or Mounting()).packed(), np.array(settings)
    found = []
    for _ in range(round(duration / DT)):
        kit.complementary(memory, z, numbers, places, DT)
        found.append(memory.copy())
    return np.array(found)


def turned(memories, R):
    """Return the rotation vectors, in B, by which estimates are off an attitude (N, 3)."""
    return (R.inv() * Rotation.from_quat(memories[:, :4], scalar_first=True)).as_rotvec()


def test_a_wrong_attitude_comes_back_as_the_closed_form_says(case, kit):
    # theta' = -kp sin(theta), so tan(theta / 2) falls as exp(-kp t)
    R = Rotation.from_rotvec([0.3, -0.2, 0.5])
    up, level = R.inv().apply([0, 0, 1.0]), R.inv().apply([1.0, 0, 0])
    t = DT * np.arange(1, 4097)
    for name, axis, hears in (("tilt", level, False), ("heading", up, True)):
        z = still(R)
        z[MAGNETOMETER] = hears
        z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = R.inv().apply(FIELD)
        for angle in (0.05, -1.5):
            with case(name, angle):
                off = R * Rotation.from_rotvec(angle * axis)
                memory = memory_at(off.as_quat(scalar_first=True))
                found = turned(run(kit, memory, z, WITHOUT_KI, 4.0), R) @ axis
                expected = 2 * np.arctan(np.tan(angle / 2) * np.exp(-0.5 * t))
                assert found == pytest.approx(expected, abs=4e-4 * abs(angle))


def test_a_bias_of_the_gyro_is_found_as_by_a_linear_filter_of_second_order(kit):
    # theta' = beta + kp e, beta' = ki e, of what is left of the bias; and e = -theta but that a
    # tilt about y moves the steep field's heading, by its dip of 2
    kp, ki, bias = 1.0, 0.5, np.array([1e-3, -2e-3, 5e-4])
    turning = np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, -2.0, -1.0]])
    A = np.block([[kp * turning, np.eye(3)], [ki * turning, np.zeros((3, 3))]])
    z = still(bias=bias)
    z[MAGNETOMETER], z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = 1.0, FIELD
    settings = ComplementarySettings(complementary_kp=kp, complementary_ki=ki)
    found = run(kit, memory_at(LEVEL), z, settings, 30.0)
    rows = np.arange(511, len(found), 512)
    start = np.concatenate([np.zeros(3), bias])
    expected = np.array([linalg.expm(A * DT * (row + 1)) @ start for row in rows])
    angles, left = turned(found[rows], Rotation.identity()), bias - found[rows, 10:13]
    assert np.hstack([angles, left]) == pytest.approx(expected, abs=4e-6)
    assert np.abs(left[-1]).max() < 5e-6


def test_height_and_place_follow_their_sensors_as_linear_filters(case, kit):
    """Steps of 1 m, beside scipy's response of the continuous equations."""
    T_p, T_v, T_h = 1.5, 0.5, 1.0
    settings = ComplementarySettings(
        complementary_position_time=T_p,
        complementary_velocity_time=T_v,
        complementary_height_time=T_h,
    )
    for name, sensor, where, row, time, friction in (
        ("height", BAROMETER, BAROMETER + 1, 6, T_h, 0.0),
        ("place", GPS, GPS + 3, 5, T_p, 1 / T_v),
    ):
        with case(name):
            z = still()
            z[sensor], z[where] = 1.0, 1.0
            found = run(kit, memory_at(LEVEL), z, settings, 6.0)
            A = [[-2 / time, 1.0], [-1 / time**2, -friction]]
            B = [[2 / time], [1 / time**2]]
            t = DT * np.arange(len(found) + 1)
            _, expected = signal.step((A, B, np.eye(2), np.zeros((2, 1))), T=t)
            assert found[:, [row, row + 3]] == pytest.approx(expected[1:], abs=2e-3)


def test_a_wrong_dip_of_the_field_does_not_tilt_it(kit):
    steep = Mounting(m_W=(0.0, 2e-5, 4e-5))
    z = still()
    z[MAGNETOMETER], z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = 1.0, FIELD
    found = run(kit, memory_at(LEVEL), z, ComplementarySettings(), 5.0, steep)
    assert np.abs(turned(found, Rotation.identity())).max() < 1e-12


def test_at_rest_it_stays_wherever_sensors_are_mounted(kit):
    R = Rotation.from_rotvec([0.4, 0.1, -0.9])
    mounting = Mounting((0.1, 0.0, 0.2), (-0.2, 0.1, 0.3), (0.3, 0.2, -0.1), m_W=FIELD)
    base = np.array([4.0, -2.0, 7.0])
    state = [*R.as_quat(scalar_first=True), *base, *[0.0] * 6]
    memory = complementary.initial_complementary(state, mounting.p_BI)
    imu = base + R.apply(mounting.p_BI)
    assert memory[4:7] == pytest.approx(imu)
    z = still(R)
    z[GPS : GPS + 5] = [1.0, 0.1, *(base + R.apply(mounting.p_BG))]
    z[BAROMETER : BAROMETER + 2] = 1.0, (base + R.apply(mounting.p_BP))[2]
    z[MAGNETOMETER : MAGNETOMETER + 4] = [1.0, *R.inv().apply(FIELD)]
    found = run(kit, memory, z, ComplementarySettings(), 2.0, mounting)
    assert np.abs(found[:, 4:7] - imu).max() < 1e-9
    assert np.abs(found[:, 7:13]).max() < 1e-9
    assert np.abs(turned(found, R)).max() < 1e-9


def test_compiled_it_gives_what_it_gives_in_python(kit):
    rng = np.random.default_rng(6)
    settings = np.array(ComplementarySettings())
    mounting = Mounting((0.1, 0.0, 0.2), (-0.2, 0.1, 0.3), (0.3, 0.2, -0.1), m_W=FIELD).packed()
    compiled, interpreted = memory_at(LEVEL), memory_at(LEVEL)
    for _ in range(300):
        z = still() + 0.3 * rng.normal(size=SAMPLE_ARRAY_SIZE)
        z[[GPS, BAROMETER, MAGNETOMETER]] = rng.random(3) < 0.3
        kit.complementary(compiled, z, settings, mounting, 8 * DT)
        complementary.update(interpreted, z, settings, mounting, 8 * DT)
    assert compiled == pytest.approx(interpreted, rel=1e-12, abs=1e-12)
