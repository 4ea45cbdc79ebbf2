"""A tilt beside its definition: the derivative of the wrench by the angle, in any frame."""

import dataclasses

import numpy as np
import pytest
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.plant.rotors import wrench_matrix
from workbench.plant.tilt import Tilt, TiltedRotor

CENTRE = (0.02, -0.01, 0.03)
"""Of mass [m]."""


@pytest.fixture(scope="module")
def tilt():
    """Return a servo that tilts two rotors about axes of their own, neither through a hub."""
    return Tilt(
        "swash",
        -0.5,
        0.5,
        (
            TiltedRotor(0, (0.1, 0.05, -0.04), (0.6, 0.0, 0.8)),
            TiltedRotor(2, (-0.1, 0.0, 0.02), (0.0, -0.6, 0.8)),
        ),
    )


def turned(rotor, angle, p_BJ, axis):
    """Return a rotor after a turn of its joint."""
    # exp(angle [axis]x) to second order, whose error at 1e-5 is below that of a difference
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + angle * K + 0.5 * angle**2 * K @ K
    place = np.array(p_BJ) + R @ (np.array(rotor.p_BR) - p_BJ)
    return dataclasses.replace(rotor, p_BR=tuple(place), axis_B=tuple(R @ rotor.axis_B))


def test_a_column_is_the_derivative_of_the_wrench_by_the_angle(dh_vehicle, tilt):
    step, slope = 1e-5, np.zeros(6)
    for each in tilt.turns:
        ends = [
            wrench_matrix(
                [turned(dh_vehicle.rotors[each.rotor], a, each.p_BJ, each.axis_B)], CENTRE
            )
            for a in (step, -step)
        ]
        slope += 0.5 * (ends[0] - ends[1]).ravel() / (2.0 * step)
    assert tilt.column(dh_vehicle.rotors, CENTRE) == pytest.approx(slope, abs=1e-8)


def test_a_tilt_in_another_frame_makes_the_same_wrench(dh_vehicle, tilt):
    R = RotationMatrix(RollPitchYaw(0.3, -0.5, 0.8)).matrix()
    rotors = [
        dataclasses.replace(rotor, p_BR=tuple(R @ rotor.p_BR), axis_B=tuple(R @ rotor.axis_B))
        for rotor in dh_vehicle.rotors
    ]
    expected = (tilt.column(dh_vehicle.rotors, CENTRE).reshape(2, 3) @ R.T).ravel()
    assert tilt.turned_by(R).column(rotors, R @ CENTRE) == pytest.approx(expected, abs=1e-12)
