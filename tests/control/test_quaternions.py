"""The arithmetic of control laws with quaternions beside pydrake's rotations."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis, Quaternion

from workbench.control.quaternions import (
    canonical,
    inverse,
    normalized,
    product,
    rotated,
    shortest_turn,
    small_turn,
    tilt_vector,
    upright,
)

Z = (0.0, 0.0, 1.0)


@pytest.fixture
def pairs():
    """Return pairs of unit vectors: drawn ones, equal ones, and opposite ones."""
    draw = np.random.default_rng(8).normal(size=(20, 2, 3))
    drawn = draw / np.linalg.norm(draw, axis=2, keepdims=True)
    axes = [*np.eye(3), *-np.eye(3)]
    found = [*drawn, *((each, each) for each in axes), *((each, -each) for each in axes[2::3])]
    return [(tuple(map(float, a)), tuple(map(float, b))) for a, b in found]


def test_the_shortest_turn_leads_from_one_vector_to_the_other_by_the_angle_between(pairs, case):
    for a, b in pairs:
        with case(a, b):
            turn = shortest_turn(a, b)
            assert np.linalg.norm(turn) == pytest.approx(1.0)
            assert rotated(turn, a) == pytest.approx(b, abs=1e-9)
            angle = AngleAxis(Quaternion(np.array(turn))).angle()
            between = np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))
            assert min(angle, 2.0 * np.pi - angle) == pytest.approx(between, abs=1e-7)


def test_a_tilt_vector_turns_z_to_a_vector_also_where_it_is_almost_z(pairs, case):
    near = [(1e-9, 2e-9, 1.0), (0.0, 3e-8, 1.0), (-2e-7, 1e-8, 1.0)]
    for n in [*(a for a, _ in pairs if a[2] > -0.99), *near]:
        x, y, angle = tilt_vector(n)
        with case(n):
            size = float(np.hypot(x, y))
            turn = AngleAxis(size, np.array([x, y, 0.0]) / size) if size else AngleAxis()
            assert turn.rotation() @ Z == pytest.approx(n, abs=1e-12)
            assert angle == pytest.approx(size, abs=1e-7)


def test_products_inverses_and_axes_are_those_of_rotations():
    draw = np.random.default_rng(9)
    for p, q in draw.normal(size=(10, 2, 4)):
        p, q = normalized(tuple(p)), normalized(tuple(q))
        P, Q = Quaternion(np.array(p)).rotation(), Quaternion(np.array(q)).rotation()
        assert Quaternion(np.array(product(p, q))).rotation() == pytest.approx(P @ Q, abs=1e-12)
        assert product(p, inverse(p)) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-12)
        assert upright(p) == pytest.approx(P[:, 2], abs=1e-12)
        same = canonical(p)
        assert same[0] >= 0.0 and abs(np.dot(same, p)) == pytest.approx(1.0)
    for turn in draw.uniform(-0.5, 0.5, (10, 3)):
        angle = float(np.linalg.norm(turn))
        expected = AngleAxis(angle, turn / angle).quaternion().wxyz()
        assert small_turn(*turn.tolist()) == pytest.approx(expected, abs=1e-9)
