"""Oracles: Drake's `Propeller`, conservation of angular momentum, and Drake's rigid body."""

import dataclasses

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.multibody.tree import BodyIndex

from workbench.dynamics.rigid_body import rigid_body, rotation
from workbench.dynamics.rotor_response import step_rotor
from workbench.dynamics.vehicle_step import (
    FULL,
    LAG,
    ROW,
    rotor_rows,
    step_vehicle,
    vehicle_wrench,
)

MOTOR_CONSTANT = 8.54858e-06
MOMENT_CONSTANT = 0.016
ARM = 0.25
ROTOR_HEIGHT = 0.014 / 2 + 0.026 + 0.006
TURNS = (-1, 1, -1, 1)
STEP = 1 / 1024
NONE = [0.0] * 3
AT_REST = [1.0, *[0.0] * 12]


def wrench_of(rotors, speeds, w_B=NONE, slopes=None, shares=None) -> np.ndarray:
    """Return force and moment about the origin in still air of a body that is nowhere going."""
    bare = [dataclasses.replace(rotor, rotor_drag_coefficient=0.0) for rotor in rotors]
    found = vehicle_wrench(
        rotation([1.0, 0.0, 0.0, 0.0]),
        w_B,
        NONE,
        10.0,
        speeds,
        slopes or [0.0] * len(rotors),
        shares or [1.0] * len(rotors),
        NONE,
        0.0,
        NONE,
        rotor_rows(bare, STEP),
    )
    return np.array(found)


def step_in_still_air(state, last, speeds, commands, body, rows, supply=FULL):
    """Return state, acceleration and rotor speeds after a physics step of a quadrotor."""
    after = np.zeros(4)
    found, acceleration = step_vehicle(
        state,
        last,
        speeds,
        commands,
        [1.0] * 4,
        NONE,
        [0.0] * 6,
        0.0,
        supply,
        body,
        rows,
        STEP,
        np.zeros(4),
        np.zeros(4),
        after,
    )
    return np.array(found), np.array(acceleration), after


def by_hand(base_index):
    """Four rotors at odd multiples of 45 degrees, commanded by squared speeds."""
    infos = []
    for number, turn in enumerate(TURNS, start=1):
        angle = (2 * number - 1) * np.pi / 4
        p_BR = [ARM * np.cos(angle), ARM * np.sin(angle), ROTOR_HEIGHT]
        moment_ratio = -turn * MOTOR_CONSTANT * MOMENT_CONSTANT
        infos.append(PropellerInfo(base_index, RigidTransform(p_BR), MOTOR_CONSTANT, moment_ratio))
    return Propeller(infos)


def test_thrusts_are_those_of_a_propeller_set_up_by_hand(vehicle):
    twin = by_hand(BodyIndex(1))
    context = twin.CreateDefaultContext()
    twin.get_body_poses_input_port().FixValue(context, [RigidTransform()] * 2)
    rng = np.random.default_rng(6)
    for _ in range(50):
        speeds = rng.uniform(0, 1100, 4)
        twin.get_command_input_port().FixValue(context, speeds**2)
        applied = twin.get_spatial_forces_output_port().Eval(context)
        torque, force = np.split(sum(F.F_Bq_W.Shift(-F.p_BoBq_B).get_coeffs() for F in applied), 2)
        found = wrench_of(vehicle.rotors, speeds)
        assert found == pytest.approx([*force, *torque], rel=1e-9, abs=1e-9)


def test_a_tilted_rotor_pushes_along_its_axis_and_drags_about_it(vehicle):
    """One newton of a counter-clockwise rotor at (0.3, 0, 0.1), tilted to the left."""
    axis, arm = np.array([0.0, 0.6, 0.8]), np.array([0.3, 0.0, 0.1])
    rotor = dataclasses.replace(
        vehicle.rotors[0], p_BR=tuple(arm), axis_B=tuple(axis), direction=1, moment_constant=0.05
    )
    found = wrench_of([rotor], [rotor.motor_constant**-0.5])
    torque = np.cross(arm, axis) - 0.05 * axis
    assert found == pytest.approx([*axis, *torque], abs=1e-12)


def test_a_weak_rotor_gives_its_share_and_one_that_has_stopped_all_while_it_runs_down(vehicle):
    speeds = [700.0] * 4
    whole = [wrench_of([rotor], [700.0]) for rotor in vehicle.rotors]
    found = wrench_of(vehicle.rotors, speeds, shares=[1.0, 0.25, 0.0, 1e-3])
    assert found == pytest.approx(whole[0] + 0.25 * whole[1] + whole[2] + 1e-3 * whole[3])


def level(rotor, height=10.0, climb=0.0, R_WB=None, speed=700.0) -> np.ndarray:
    """Return force and moment about the origin of a rotor of a body that climbs, in B."""
    return np.array(
        vehicle_wrench(
            R_WB or rotation([1.0, 0.0, 0.0, 0.0]),
            NONE,
            [0.0, 0.0, climb],
            height,
            [speed],
            [0.0],
            [1.0],
            NONE,
            0.0,
            NONE,
            rotor_rows([rotor], STEP),
        )
    )


def test_a_climb_costs_thrust_and_a_descent_gives_it(vehicle):
    """k w v along the axis, whose moment is about the hub's arm; drag torque is as at rest."""
    rotor = dataclasses.replace(vehicle.rotors[0], rotor_drag_coefficient=0.0)
    slow = dataclasses.replace(rotor, inflow_coefficient=2e-4)
    for climb in (5.0, -3.0):
        lost = 2e-4 * 700.0 * climb
        x, y, _ = rotor.p_BR
        change = level(slow, climb=climb) - level(rotor, climb=climb)
        assert change == pytest.approx([0, 0, -lost, -y * lost, x * lost, 0], abs=1e-12)


def test_near_the_ground_a_rotor_lifts_more(vehicle):
    """By c (r / 4h)², h being the hub's height, 4/15 at most, and not where it points down."""
    rotor = dataclasses.replace(
        vehicle.rotors[0],
        ground_effect_coefficient=11.4,
        propeller_radius=0.12,
        rotor_drag_coefficient=0.0,
    )
    thrust = rotor.motor_constant * 700.0**2
    for height in (0.05, 0.1, 0.3, 1.0, 20.0):
        hub = height + rotor.p_BR[2]
        share = min(11.4 * (0.12 / (4.0 * hub)) ** 2, 4.0 / 15.0)
        assert level(rotor, height)[2] == pytest.approx(thrust * (1.0 + share), rel=1e-12)
    assert level(rotor, 0.05)[2] == pytest.approx(thrust * 19.0 / 15.0)
    assert level(rotor, 0.0, speed=0.0)[2] == 0.0
    upside_down = rotation([0.0, 1.0, 0.0, 0.0])
    assert level(rotor, 0.3, R_WB=upside_down)[2] == pytest.approx(thrust, rel=1e-12)


def test_thrust_with_a_linear_part_is_that_of_the_curve(vehicle):
    """2e-3 w besides k w², and drag torque follows it."""
    rotor = vehicle.rotors[0]
    curved = dataclasses.replace(rotor, linear_motor_constant=2e-3)
    thrust = rotor.motor_constant * 700.0**2 + 2e-3 * 700.0
    found = level(curved)
    assert found[2] == pytest.approx(thrust, rel=1e-12)
    turning = -rotor.direction * rotor.moment_constant
    assert found[5] == pytest.approx(turning * thrust, rel=1e-12)
    assert curved.max_thrust == pytest.approx(level(curved, speed=curved.max_rot_velocity)[2])


def test_a_weak_battery_lets_rotors_reach_less(vehicle):
    """Command and limit times the voltage: 0.95 without load, less 0.02 at four rotors' power."""
    rows = rotor_rows(vehicle.rotors, STEP)
    body = rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B).packed()
    for command in (500.0, 5000.0):
        speeds = np.full(4, 400.0)
        share = np.nan
        for _ in range(1024):
            power = sum((r.motor_constant * 400.0**2) ** 1.5 for r in vehicle.rotors)
            now = sum((r.motor_constant * speeds[0] ** 2) ** 1.5 for r in vehicle.rotors)
            share = 0.95 - 0.02 * now / power
            supply = (0.95, 0.02 / power, 0.0, 0.95)
            *_, speeds = step_in_still_air(
                AT_REST, [0.0] * 6, speeds, [command] * 4, body, rows, supply
            )
        most = min(command, vehicle.rotors[0].max_rot_velocity)
        assert speeds == pytest.approx([share * most] * 4, abs=1e-6)


def test_sag_is_compensated_as_far_as_it_is_known(vehicle):
    """With the share c of what is known of the voltage s, w becomes s w / (1 + c (s_known - 1))."""
    rows = rotor_rows(vehicle.rotors, STEP)
    body = rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B).packed()
    for share, rest in ((0.0, 0.7), (0.6, 0.8), (1.0, 0.8), (1.0, 0.9)):
        speeds = np.full(4, 400.0)
        for _ in range(1024):
            supply = (0.8, 0.0, share, rest)
            *_, speeds = step_in_still_air(
                AT_REST, [0.0] * 6, speeds, [400.0] * 4, body, rows, supply
            )
        assert speeds == pytest.approx([0.8 * 400.0 / (1.0 + share * (rest - 1.0))] * 4, abs=1e-6)


def test_body_and_rotors_keep_their_angular_momentum(vehicle):
    """Without thrust and drag, whatever the rotors are commanded: 5 s, tumbling, axes that lean.

    Spin-up torque and gyroscopic moment are what makes it so, each with its size and its sign: with
    one of them missing, or the other way round, it is lost within a tenth of a second.
    """
    rng = np.random.default_rng(3)
    rotors = []
    for rotor in vehicle.rotors:
        axis = rng.normal(size=3)
        rotors.append(
            dataclasses.replace(
                rotor,
                axis_B=tuple((axis / np.linalg.norm(axis)).tolist()),
                motor_constant=1e-30,
                rotor_drag_coefficient=0.0,
                inertia=6.5e-5,
            )
        )
    body = rigid_body(vehicle.mass, vehicle.inertia, (0.01, -0.02, 0.03))
    rows, packed = rotor_rows(rotors, STEP), body.packed()
    state = np.array([1.0, *[0.0] * 6, 9.0, -5.0, 7.0, *[0.0] * 3])
    last, speeds = np.zeros(6), rng.uniform(100.0, 1000.0, 4)
    speeds_kept = []

    def momentum() -> np.ndarray:
        R_WB = RotationMatrix(Quaternion(state[:4] / np.linalg.norm(state[:4]))).matrix()
        h_B = vehicle.inertia @ R_WB.T @ state[7:10]
        for rotor, speed in zip(rotors, speeds, strict=True):
            h_B = h_B + rotor.direction * rotor.inertia * speed * np.array(rotor.axis_B)
        return R_WB @ h_B

    before = momentum()
    commands = speeds
    for number in range(5 * 1024):
        if number % 50 == 0:
            commands = rng.uniform(100.0, 1000.0, 4)
        state, last, speeds = step_in_still_air(state, last, speeds, commands, packed, rows)
        speeds_kept.append(speeds)
    assert np.ptp(speeds_kept, axis=0).min() > 500.0
    # what is left is the step's: a change of command within it is of first order in its length
    assert np.linalg.norm(momentum() - before) < 2e-3 * np.linalg.norm(before)


def test_a_rotor_that_spins_up_turns_the_body_the_other_way(vehicle):
    """J dw/dt about its axis, against its turning; and J w across for a body that turns."""
    rotor = dataclasses.replace(
        vehicle.rotors[0], axis_B=(0.0, 0.0, 1.0), direction=1, motor_constant=1e-30, inertia=2e-4
    )
    assert wrench_of([rotor], [500.0], slopes=[3000.0])[3:] == pytest.approx([0, 0, -0.6])
    clockwise = dataclasses.replace(rotor, direction=-1)
    assert wrench_of([clockwise], [500.0], slopes=[3000.0])[3:] == pytest.approx([0, 0, 0.6])
    # -w x h = -(2, 0, 0) x (0, 0, 0.1)
    assert wrench_of([rotor], [500.0], [2.0, 0, 0])[3:] == pytest.approx([0, 0.2, 0], abs=1e-12)


def test_a_step_carries_derivatives(vehicle):
    """Against central differences, of all that moves it."""
    rng = np.random.default_rng(8)
    body = rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B).packed().tolist()
    rotors = [dataclasses.replace(rotor, inertia=6.5e-5) for rotor in vehicle.rotors]
    rows = rotor_rows(rotors, STEP).tolist()
    q = rng.normal(size=4)
    sizes = np.cumsum([13, 6, 4])
    at = np.concatenate(
        [q / np.linalg.norm(q), rng.normal(size=15), rng.uniform(300, 900, 4), [500, 600, 700, 800]]
    )

    def stepped(values) -> list:
        state, last, speeds, commands = np.split(values, sizes)
        after = [0.0] * 4
        found, acceleration = step_vehicle(
            state.tolist(),
            last.tolist(),
            speeds.tolist(),
            commands.tolist(),
            [1.0] * 4,
            [1.0, -2.0, 0.5],
            [0.1] * 6,
            0.02,
            FULL,
            body,
            rows,
            STEP,
            [0.0] * 4,
            [0.0] * 4,
            after,
        )
        return [*found, *acceleration, *after]

    carried = ExtractGradient(np.array(stepped(InitializeAutoDiff(at).ravel())))
    columns = []
    for index in range(len(at)):
        change = np.zeros(len(at))
        change[index] = 1e-5 * max(1.0, abs(at[index]))
        above, below = (np.array(stepped(at + way * change)) for way in (1.0, -1.0))
        columns.append((above - below) / (2.0 * change[index]))
    assert carried == pytest.approx(np.array(columns).T, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("command", [0.0, 5000.0, -300.0])
def test_a_rotor_keeps_within_its_limits(vehicle, command):
    rows = rotor_rows(vehicle.rotors, STEP)
    body = rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B).packed()
    speeds = np.full(4, 600.0)
    for _ in range(1024):
        *_, speeds = step_in_still_air(AT_REST, [0.0] * 6, speeds, [command] * 4, body, rows)
    limit = vehicle.rotors[0].max_rot_velocity
    assert speeds == pytest.approx([min(max(command, 0.0), limit)] * 4, abs=1e-6)
    assert step_rotor(limit, limit, rows[0][LAG:ROW])[2] == pytest.approx(limit)
