"""By hand, for the shipped drone and for one of plain numbers."""

import dataclasses
import math

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.plant.drag import drag_area, drag_rates
from workbench.plant.loading import load_vehicle


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(find_model("dh_drone"))


@pytest.mark.parametrize(("mass", "area"), [(1.0, 0.01), (8.0, 0.04), (0.027, 0.0009)])
def test_a_body_has_the_face_of_a_cube_of_water(mass, area):
    assert drag_area(mass) == pytest.approx(area, rel=1e-12)


def test_rates_of_the_shipped_drone(vehicle):
    """Four rotors at sqrt(m g / 4 k), 0.25 m from the centre."""
    speed = math.sqrt(1.9 * 9.81 / 4 / 8.54858e-06)
    pull = 8.06428e-05 * speed
    rates = drag_rates(vehicle)
    assert rates.across == pytest.approx(4 * pull / 1.9, rel=1e-4)
    assert rates.squared == pytest.approx(0.5 * 1.225 * 0.0019 ** (2 / 3) / 1.9, rel=1e-9)
    assert rates.yaw == pytest.approx(4 * pull * 0.25**2 / vehicle.inertia[2, 2], rel=1e-3)


def test_rotors_without_a_coefficient_leave_the_body(vehicle):
    bare = [dataclasses.replace(rotor, rotor_drag_coefficient=0.0) for rotor in vehicle.rotors]
    rates = drag_rates(dataclasses.replace(vehicle, rotors=tuple(bare)))
    assert (rates.across, rates.yaw) == (0.0, 0.0)
    assert rates.squared > 0.0


def test_rates_do_not_depend_on_where_a_body_has_its_origin(vehicle):
    aside = np.array([0.05, -0.03, 0.02])
    moved = dataclasses.replace(
        vehicle,
        rotors=tuple(
            dataclasses.replace(rotor, p_BR=tuple(rotor.p_BR + aside)) for rotor in vehicle.rotors
        ),
        p_BoBcm_B=tuple(vehicle.p_BoBcm_B + aside),
    )
    assert drag_rates(moved) == pytest.approx(drag_rates(vehicle), rel=1e-9)
