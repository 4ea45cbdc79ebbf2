"""Oracle: the wrench that hover thrusts make, and vehicles whose lean is known."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import allocation_matrix, wrench_matrix
from workbench.plant.thrust_frame import lift_direction, thrust_frame

TILT = math.radians(5.0)


def leaning(vehicle, axes, p_BoBcm_B=(0.0, 0.0, 0.0)):
    """Return a vehicle with other rotor axes, one for each rotor, and centre of mass."""
    rotors = tuple(
        dataclasses.replace(rotor, axis_B=tuple(np.array(axis) / np.linalg.norm(axis)))
        for rotor, axis in zip(vehicle.rotors, axes, strict=True)
    )
    return dataclasses.replace(vehicle, rotors=rotors, p_BoBcm_B=p_BoBcm_B)


def forward(vehicle):
    return leaning(vehicle, [(math.sin(TILT), 0.0, math.cos(TILT))] * 4)


def inward(vehicle, p_BoBcm_B=(0.03, 0.0, 0.0)):
    """Ten degrees towards the centre, and the centre of mass beside it."""
    axes = [(*(-math.tan(2 * TILT) * np.array(r.p_BR[:2]) / 0.25), 1.0) for r in vehicle.rotors]
    return leaning(vehicle, axes, p_BoBcm_B)


def test_upright_rotors_have_the_bodys_own_frame_to_the_bit(dh_vehicle):
    frame = thrust_frame(dh_vehicle)
    assert np.array_equal(frame.R_BT, np.eye(3))
    assert frame.q_BT == [1.0, 0.0, 0.0, 0.0]
    assert frame.rotors == dh_vehicle.rotors
    assert np.array_equal(frame.inertia_T, dh_vehicle.inertia)
    own = allocation_matrix(dh_vehicle.rotors, dh_vehicle.p_BoBcm_B)
    assert np.array_equal(frame.allocation, own)
    assert frame.hover_speeds == pytest.approx(dh_vehicle.hover_speeds, rel=1e-15)
    angles = [0.1, -0.2, 3.0]
    assert frame.roll_pitch_yaw(angles) == angles


def test_a_thrust_curve_with_a_linear_part_counts_everywhere(dh_vehicle):
    """In hover, idling, and in how much thrust a change of speed makes."""
    rotors = tuple(
        dataclasses.replace(rotor, linear_motor_constant=1e-3) for rotor in dh_vehicle.rotors
    )
    frame = thrust_frame(dataclasses.replace(dh_vehicle, rotors=rotors))
    k, most = rotors[0].motor_constant, rotors[0].max_rot_velocity
    speeds = frame.hover_speeds
    assert k * speeds**2 + 1e-3 * speeds == pytest.approx(frame.hover_thrusts, rel=1e-12)
    strong = dataclasses.replace(dh_vehicle, rotors=rotors, mass=10.0 * dh_vehicle.mass)
    idle = k * (0.1 * most) ** 2 + 1e-3 * 0.1 * most
    assert thrust_frame(strong).idle_thrusts == pytest.approx([idle] * 4, rel=1e-12)
    drag = rotors[0].moment_constant * (2.0 * k * speeds[0] + 1e-3)
    assert frame.spin_up_time == pytest.approx(rotors[0].inertia / drag)


def test_rotors_that_lean_against_each_other_lift_upright(dh_vehicle):
    frame = thrust_frame(inward(dh_vehicle, (0.0, 0.0, 0.0)))
    assert np.array_equal(frame.R_BT, np.eye(3))


def test_rotors_that_lean_one_way_lift_that_way(dh_vehicle):
    wanted = [math.sin(TILT), 0.0, math.cos(TILT)]
    assert lift_direction(forward(dh_vehicle)) == pytest.approx(wanted)
    frame = thrust_frame(forward(dh_vehicle))
    assert frame.R_BT[:, 2] == pytest.approx(wanted)
    square = frame.R_BT @ frame.R_BT.T
    assert square == pytest.approx(np.eye(3), abs=1e-15)
    assert RollPitchYaw(RotationMatrix(frame.R_BT)).vector() == pytest.approx([0.0, TILT, 0.0])


@pytest.mark.parametrize("make", [forward, inward], ids=["forward", "inward"])
def test_hover_thrusts_carry_the_weight_along_z_of_the_frame_and_turn_nothing(dh_vehicle, make):
    vehicle = make(dh_vehicle)
    frame = thrust_frame(vehicle)
    assert frame.R_BT[2, 2] < 1.0 - 1e-5
    wrench = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B) @ frame.hover_thrusts
    assert wrench[:3] == pytest.approx(vehicle.mass * GRAVITY * frame.R_BT[:, 2])
    assert wrench[3:] == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("make", [forward, inward], ids=["forward", "inward"])
def test_the_allocation_makes_moments_about_the_frames_axes(dh_vehicle, make):
    vehicle = make(dh_vehicle)
    frame = thrust_frame(vehicle)
    wrench = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B) @ frame.allocation
    assert frame.R_BT.T @ wrench[3:, 1:] == pytest.approx(np.eye(3), abs=1e-12)
    assert (frame.R_BT.T @ wrench[:3])[2] == pytest.approx([1, 0, 0, 0], abs=1e-12)


def test_the_inertia_is_the_same_body_seen_from_the_frame(dh_vehicle):
    vehicle = forward(dh_vehicle)
    frame = thrust_frame(vehicle)
    w_T = np.array([0.3, -0.7, 0.5])
    w_B = frame.R_BT @ w_T
    assert w_T @ frame.inertia_T @ w_T == pytest.approx(w_B @ vehicle.inertia @ w_B)


@pytest.mark.parametrize("angles", [[0.0, 0.0, 0.0], [0.2, -0.3, 2.5], [3.0, 0.1, -1.0]])
def test_the_body_is_turned_so_that_the_frame_has_the_attitude(dh_vehicle, angles):
    frame = thrust_frame(inward(dh_vehicle))
    R_WB = RotationMatrix(RollPitchYaw(np.array(frame.roll_pitch_yaw(angles)))).matrix()
    found = R_WB @ frame.R_BT
    wanted = RotationMatrix(RollPitchYaw(np.array(angles))).matrix()
    assert found == pytest.approx(wanted, abs=1e-12)


def test_with_more_rotors_than_needed_the_least_thrusts_are_taken(dh_vehicle):
    """Six of them, all leaning: no other thrusts without moment lift as much for their size."""
    rng = np.random.default_rng(2)
    rotors = []
    for i in range(6):
        x, y = 0.3 * math.cos(i * math.pi / 3), 0.3 * math.sin(i * math.pi / 3)
        axis = np.array([0.2, 0.1, 1.0]) + rng.uniform(-0.3, 0.3, 3)
        axis /= np.linalg.norm(axis)
        rotors.append(
            dataclasses.replace(dh_vehicle.rotors[i % 2], p_BR=(x, y, 0.0), axis_B=tuple(axis))
        )
    vehicle = dataclasses.replace(dh_vehicle, rotors=tuple(rotors))
    frame = thrust_frame(vehicle)
    assert frame.R_BT[2, 2] < 0.99
    thrusts = frame.hover_thrusts
    matrix = wrench_matrix(rotors, vehicle.p_BoBcm_B)
    lift = matrix[:3] @ thrusts
    assert np.cross(lift, frame.R_BT[:, 2]) == pytest.approx(np.zeros(3), abs=1e-9)
    _, _, rows = np.linalg.svd(matrix[3:])
    best = np.linalg.norm(lift) / np.linalg.norm(thrusts)
    for mix in rng.normal(size=(200, 3)):
        other = mix @ rows[3:]
        assert np.linalg.norm(matrix[:3] @ other) / np.linalg.norm(other) <= best + 1e-9


def test_idling_rotors_never_lift_the_vehicle(dh_vehicle):
    """1 % of the largest thrust (10 % of the speed), but no more than 10 % of that of hover."""
    most = dh_vehicle.rotors[0].max_thrust
    assert thrust_frame(dh_vehicle).idle_thrusts == pytest.approx([0.01 * most] * 4)
    strong = tuple(
        dataclasses.replace(rotor, max_rot_velocity=20_000.0) for rotor in dh_vehicle.rotors
    )
    frame = thrust_frame(dataclasses.replace(dh_vehicle, rotors=strong))
    assert frame.idle_thrusts == pytest.approx(0.1 * frame.hover_thrusts)


def test_a_rotor_that_pushes_forward_stays_at_rest(dh_vehicle):
    pusher = dataclasses.replace(
        dh_vehicle.rotors[0], name="pusher", p_BR=(-0.3, 0.0, 0.0), axis_B=(1.0, 0.0, 0.0)
    )
    frame = thrust_frame(dataclasses.replace(dh_vehicle, rotors=(*dh_vehicle.rotors, pusher)))
    own = thrust_frame(dh_vehicle)
    assert np.array_equal(frame.R_BT, np.eye(3))
    assert frame.hover_thrusts == pytest.approx([*own.hover_thrusts, 0.0])
    assert frame.allocation[4].tolist() == [0.0] * 4
    assert frame.idle_thrusts[4] == 0.0
