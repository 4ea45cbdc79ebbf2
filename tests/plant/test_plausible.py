"""Slips of a unit, each made once with the shipped drone."""

import dataclasses

import numpy as np
import pytest

from workbench.plant.plausible import doubts


def with_rotors(vehicle, **changes):
    rotors = tuple(dataclasses.replace(rotor, **changes) for rotor in vehicle.rotors)
    return dataclasses.replace(vehicle, rotors=rotors)


def test_the_shipped_drone_is_a_drone(dh_vehicle):
    assert doubts(dh_vehicle) == []


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda v: dataclasses.replace(v, mass=0.0019), "masses in kg"),
        (lambda v: with_rotors(v, max_rot_velocity=11000.0), "not RPM"),
        (
            lambda v: dataclasses.replace(
                v,
                rotors=tuple(
                    dataclasses.replace(r, p_BR=tuple(1000.0 * np.array(r.p_BR))) for r in v.rotors
                ),
            ),
            "are lengths in m",
        ),
        (
            lambda v: dataclasses.replace(
                v, I_BBcm_B=tuple(tuple(1000.0 * x for x in row) for row in v.I_BBcm_B)
            ),
            "is it in kg m²",
        ),
        (lambda v: dataclasses.replace(v, p_BoBcm_B=(0.16, 0.0, 0.0)), "the centre of mass"),
    ],
)
def test_a_slip_of_a_unit_is_doubted(dh_vehicle, spoil, said):
    assert any(said in doubt for doubt in doubts(spoil(dh_vehicle)))
