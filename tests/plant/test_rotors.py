"""Oracles: moments worked out by hand, and numpy's least-squares solution of smallest norm."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.rotors import Rotor, allocation_matrix, wrench_matrix


def rotor(p_BR, direction=1, axis_B=(0.0, 0.0, 1.0), moment_constant=0.02) -> Rotor:
    return Rotor(
        name="r",
        joint="r",
        link="r",
        p_BR=p_BR,
        axis_B=axis_B,
        direction=direction,
        motor_constant=2e-5,
        moment_constant=moment_constant,
        time_constant_up=0.01,
        time_constant_down=0.02,
        max_rot_velocity=1000.0,
    )


def ring(count: int, directions=(1, -1)) -> list[Rotor]:
    """Rotors evenly on a circle of 0.3 m."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return [
        rotor((0.3 * np.cos(a), 0.3 * np.sin(a), 0.0), directions[i % len(directions)])
        for i, a in enumerate(angles)
    ]


def test_largest_thrust_is_at_the_largest_speed():
    assert rotor((0.0, 0.0, 0.0)).max_thrust == pytest.approx(20.0)  # 2e-5 * 1000^2


def test_wrench_of_one_newton_by_hand():
    """At (1, 2, 3) with the centre of mass at (0, 0, 1) the arm is (1, 2, 2)."""
    up = rotor((1.0, 2.0, 3.0), direction=1)
    ahead = rotor((1.0, 2.0, 3.0), direction=-1, axis_B=(1.0, 0.0, 0.0))
    matrix = wrench_matrix([up, ahead], (0.0, 0.0, 1.0))
    assert matrix.shape == (6, 2)
    # arm x z = (2, -1, 0), and counter-clockwise blades drag the body clockwise
    assert matrix[:, 0] == pytest.approx([0, 0, 1, 2, -1, -0.02])
    # arm x x = (0, 2, -2), and clockwise blades drag the body counter-clockwise
    assert matrix[:, 1] == pytest.approx([1, 0, 0, 0.02, 2, -2])


@pytest.mark.parametrize("count", [4, 6, 8])
def test_allocation_makes_the_wrench_with_the_smallest_thrusts(count):
    rotors = ring(count)
    p_BoBcm_B = (0.02, -0.01, 0.03)
    allocation = allocation_matrix(rotors, p_BoBcm_B)
    rows = wrench_matrix(rotors, p_BoBcm_B)[2:]
    wrenches = np.random.default_rng(1).normal(size=(4, 20))
    smallest = np.linalg.lstsq(rows, wrenches)[0]
    assert allocation @ wrenches == pytest.approx(smallest, abs=1e-9)
    assert rows @ allocation == pytest.approx(np.eye(4), abs=1e-12)


@pytest.mark.parametrize(
    ("rotors", "rank"),
    [
        (ring(4, directions=(1,)), 3),  # drag all one way: yaw is thrust over again
        (ring(3, directions=(1, -1, 1)), 3),  # three numbers cannot make four
        ([rotor((x, 0.0, 0.0), d) for x, d in ((-2, 1), (-1, -1), (1, 1), (2, -1))], 3),  # a row
        ([rotor((0.0, 0.0, z), d) for z, d in ((0, 1), (1, -1), (2, 1), (3, -1))], 2),  # a mast
    ],
)
def test_rotors_that_cannot_control_are_refused_with_their_rank(rotors, rank):
    with pytest.raises(WorkbenchError, match=rf"{len(rotors)} rotors .*rank {rank} of 4"):
        allocation_matrix(rotors, (0.0, 0.0, 0.0))


def test_small_rotors_with_little_drag_are_not_taken_for_a_fault():
    """A 30 g drone: arms of 3 cm and a drag of 2 mm."""
    rotors = [
        rotor((0.03 * x, 0.03 * y, 0.0), x * y, moment_constant=0.002)
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    rows = wrench_matrix(rotors, (0.0, 0.0, 0.0))[2:]
    allocation = allocation_matrix(rotors, (0.0, 0.0, 0.0))
    assert rows @ allocation == pytest.approx(np.eye(4), abs=1e-12)


@pytest.mark.parametrize("axis_B", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
def test_rotors_that_would_have_to_push_down_are_refused(axis_B):
    rotors = [rotor(r.p_BR, r.direction, axis_B) for r in ring(4)]
    beside = (1.0, 0.0, 0.0) if axis_B[2] > 0 else (0.0, 0.0, 0.0)
    with pytest.raises(WorkbenchError, match="(push downwards|pushes upwards)"):
        allocation_matrix(rotors, beside)
