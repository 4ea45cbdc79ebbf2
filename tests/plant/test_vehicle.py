"""Oracle: the balance of forces and moments in hover."""

import dataclasses

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.controllers import pd
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import wrench_matrix


def test_gravity_is_one_number():
    assert GRAVITY == pd.GRAVITY == 9.81


def test_a_symmetric_drone_hovers_on_equal_rotors(dh_vehicle):
    centred = dataclasses.replace(dh_vehicle, p_BoBcm_B=(0.0, 0.0, -0.01))
    constant = centred.rotors[0].motor_constant
    each = np.sqrt(centred.mass * GRAVITY / 4.0 / constant)
    assert centred.hover_speeds == pytest.approx([each] * 4)


def test_the_span_is_from_rotor_to_rotor_across(dh_vehicle):
    """Four of them, 0.25 m from the centre."""
    assert dh_vehicle.span == pytest.approx(0.5)


def test_a_drone_with_its_mass_off_the_middle_still_balances(dh_vehicle):
    p_BoBcm_B = (0.05, -0.03, 0.0)
    vehicle = dataclasses.replace(dh_vehicle, p_BoBcm_B=p_BoBcm_B)
    constants = [rotor.motor_constant for rotor in vehicle.rotors]
    thrusts = constants * vehicle.hover_speeds**2
    wrench = wrench_matrix(vehicle.rotors, p_BoBcm_B) @ thrusts
    assert wrench == pytest.approx([0, 0, vehicle.mass * GRAVITY, 0, 0, 0], abs=1e-12)
    assert np.ptp(thrusts) > 1.0


def test_inertia_is_the_rows_as_a_matrix(dh_vehicle):
    assert dh_vehicle.inertia.shape == (3, 3)
    assert dh_vehicle.inertia[0].tolist() == list(dh_vehicle.I_BBcm_B[0])
    assert dh_vehicle.inertia[2].tolist() == list(dh_vehicle.I_BBcm_B[2])


def test_frames_are_found_by_name(dh_vehicle):
    assert dh_vehicle.frame("camera_link").name == "camera_link"


def test_an_unknown_frame_is_refused_with_the_nearest_name(dh_vehicle):
    with pytest.raises(WorkbenchError, match="'camera': did you mean 'camera_link'"):
        dh_vehicle.frame("camera")


def test_the_record_is_frozen(dh_vehicle):
    with pytest.raises(dataclasses.FrozenInstanceError):
        dh_vehicle.mass = 1.0
