"""Oracle: the same forces as vectors, with Drake's rotations."""

import dataclasses

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from tests.dynamics.wrench import STILL, wrench_on

PRESSURE = 0.7
P_CM = np.array([0.03, -0.05, 0.1])


@pytest.fixture
def rotors(vehicle):
    """Four rotors that lean, with coefficients of their own."""
    rng = np.random.default_rng(1)
    leaning = []
    for rotor in vehicle.rotors:
        axis = rng.normal(size=3)
        leaning.append(
            dataclasses.replace(
                rotor,
                p_BR=tuple(rng.normal(size=3).tolist()),
                axis_B=tuple((axis / np.linalg.norm(axis)).tolist()),
                motor_constant=0.0,
                inertia=0.0,
                rotor_drag_coefficient=rng.uniform(1e-4, 1e-3),
                rolling_moment_coefficient=rng.uniform(1e-5, 1e-4),
            )
        )
    return leaning


def by_vectors(state, speeds, wind, pressure, p_cm, rotors) -> np.ndarray:
    """Return force and moment about Bo in B: all in W first, then turned."""
    q = state[:4] / np.linalg.norm(state[:4])
    R_WB = RotationMatrix(Quaternion(q)).matrix()
    w_W, v_W = state[7:10], state[10:13]
    arm = R_WB @ p_cm
    way = v_W + np.cross(w_W, arm) - wind
    force = -pressure * np.linalg.norm(way) * way
    moment = np.cross(arm, force)
    for rotor, speed in zip(rotors, speeds, strict=False):
        arm, axis = R_WB @ rotor.p_BR, R_WB @ rotor.axis_B
        way = v_W + np.cross(w_W, arm) - wind
        across = way - np.outer(axis, axis) @ way
        pull = -abs(speed) * rotor.rotor_drag_coefficient * across
        force += pull
        moment += np.cross(arm, pull)
        moment += -abs(speed) * rotor.rolling_moment_coefficient * across
    return np.concatenate([R_WB.T @ force, R_WB.T @ moment])


def drawn(rng) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return state, speeds and wind."""
    return rng.normal(size=13) * 3.0, rng.uniform(0, 1000, 4), rng.normal(size=3) * 8.0


def test_the_wrench_is_that_of_vectors(rotors):
    rng = np.random.default_rng(2)
    for _ in range(200):
        state, speeds, wind = drawn(rng)
        found = wrench_on(rotors, state, speeds, None, None, wind, PRESSURE, P_CM)
        wanted = by_vectors(state, speeds, wind, PRESSURE, P_CM, rotors)
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_five_metres_a_second_against_a_square_decimetre():
    """1.225 / 2 · 0.01 · 25 = 0.153 N at the centre of mass, backwards."""
    state = [1.0, *[0.0] * 9, 5.0, 0.0, 0.0]
    half_drag, center = 0.5 * 1.225 * 0.01, (0.0, 0.0, 0.2)
    wrench = wrench_on([], state, [], half_drag=half_drag, center=center)
    assert wrench == pytest.approx([-0.153125, 0, 0, 0, -0.2 * 0.153125, 0])


@pytest.mark.parametrize("direction", [1, -1])
def test_a_rotor_pulls_and_rolls_against_its_way_whichever_way_it_turns(vehicle, direction):
    """700 rad/s, 2 m/s ahead and 3 up: only what is across its axis counts."""
    rotor = dataclasses.replace(
        vehicle.rotors[0],
        p_BR=(0.0, 0.0, 0.1),
        axis_B=(0.0, 0.0, 1.0),
        direction=direction,
        motor_constant=0.0,
        rotor_drag_coefficient=1e-4,
        rolling_moment_coefficient=1e-6,
    )
    state = [1.0, *[0.0] * 9, 2.0, 0.0, 3.0]
    wrench = wrench_on([rotor], state, [700.0])
    assert wrench == pytest.approx([-0.14, 0, 0, -0.0014, -0.014, 0])


def test_what_moves_with_the_air_feels_nothing(rotors):
    state = [0.5, 0.5, -0.5, 0.5, *[0.0] * 6, 3.0, -4.0, 1.0]
    wind = [3.0, -4.0, 1.0]
    wrench = wrench_on(rotors, state, [700.0] * 4, None, None, wind, PRESSURE, P_CM)
    assert list(wrench) == [0.0] * 6


def test_it_carries_derivatives_even_at_rest(rotors):
    """At rest the body's drag has none, and the rotors' are linear."""
    state = np.zeros(13)
    state[0] = 1.0
    speeds = [700.0] * 4
    every = InitializeAutoDiff(state).ravel().tolist()
    carried = wrench_on(rotors, every, speeds, None, None, STILL, PRESSURE, P_CM.tolist())
    found = np.array([value.derivatives() for value in carried])
    columns = []
    for index in range(13):
        step = np.zeros(13)
        step[index] = 1e-6
        above, below = (
            by_vectors(state + way * step, speeds, np.zeros(3), PRESSURE, P_CM, rotors)
            for way in (1.0, -1.0)
        )
        columns.append((above - below) / 2e-6)
    assert found == pytest.approx(np.array(columns).T, abs=1e-5)
    assert np.abs(found).max() > 0.1
