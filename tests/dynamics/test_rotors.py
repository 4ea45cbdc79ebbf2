"""Oracles: Drake's `Propeller`, closed forms, and conservation of angular momentum."""

import dataclasses

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
from pydrake.math import RigidTransform
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.multibody.tree import BodyIndex
from scipy.integrate import solve_ivp

from tests.dynamics.wrench import wrench_on
from workbench.dynamics.rigid_body import (
    body_acceleration,
    into_body,
    quaternion_rate,
    rigid_body,
    rotation,
)
from workbench.dynamics.rotor_response import split_error
from workbench.dynamics.rotors import (
    compensated_share,
    loaded_voltage,
    power_share,
    speed_slope,
    static_thrust,
    within_speed_limits,
)

MOTOR_CONSTANT = 8.54858e-06
MOMENT_CONSTANT = 0.016
ARM = 0.25
ROTOR_HEIGHT = 0.014 / 2 + 0.026 + 0.006
TURNS = (-1, 1, -1, 1)
HIGH = 10.0
UP, DOWN = 0.0125, 0.025
BLEND = 3.0
"""Speed difference over which the two time constants blend [rad/s]."""
NEAR = BLEND / 3
"""The most that goes by the other time constant: with x = e / BLEND, x (1 - (x² / (x² + 1))^1.5)
is at most 0.66, at 1.25, and that takes half of it."""


def state_of(height=HIGH, climb=0.0, w_B=(0.0, 0.0, 0.0), q=(1.0, 0.0, 0.0, 0.0)) -> list[float]:
    return [*q, 0.0, 0.0, height, *w_B, 0.0, 0.0, climb]


def bare(rotors):
    return [dataclasses.replace(rotor, rotor_drag_coefficient=0.0) for rotor in rotors]


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
        found = wrench_on(bare(vehicle.rotors), state_of(), speeds)
        assert found == pytest.approx([*force, *torque], rel=1e-9, abs=1e-9)


def test_a_tilted_rotor_pushes_along_its_axis_and_drags_about_it(vehicle):
    """One newton of a counter-clockwise rotor at (0.3, 0, 0.1), tilted to the left."""
    axis, arm = np.array([0.0, 0.6, 0.8]), np.array([0.3, 0.0, 0.1])
    rotor = dataclasses.replace(
        vehicle.rotors[0], p_BR=tuple(arm), axis_B=tuple(axis), direction=1, moment_constant=0.05
    )
    found = wrench_on([rotor], state_of(), [rotor.motor_constant**-0.5])
    torque = np.cross(arm, axis) - 0.05 * axis
    assert found == pytest.approx([*axis, *torque], abs=1e-12)


def test_a_weak_rotor_gives_its_share_and_one_that_has_stopped_all_while_it_runs_down(vehicle):
    rotors, speeds = vehicle.rotors, [700.0] * 4
    whole = [wrench_on([rotor], state_of(), [700.0]) for rotor in rotors]
    found = wrench_on(rotors, state_of(), speeds, shares=[1.0, 0.25, 0.0, 1e-3])
    assert found == pytest.approx(whole[0] + 0.25 * whole[1] + whole[2] + 1e-3 * whole[3])


def test_a_climb_costs_thrust_and_a_descent_gives_it(vehicle):
    """k w v along the axis, whose moment is about the hub's arm; drag torque is as at rest."""
    (rotor,) = bare(vehicle.rotors[:1])
    slow = dataclasses.replace(rotor, inflow_coefficient=2e-4)
    for climb in (5.0, -3.0):
        lost = 2e-4 * 700.0 * climb
        x, y, _ = rotor.p_BR
        one, other = (wrench_on([r], state_of(climb=climb), [700.0]) for r in (slow, rotor))
        assert one - other == pytest.approx([0, 0, -lost, -y * lost, x * lost, 0], abs=1e-12)


def test_near_the_ground_a_rotor_lifts_more(vehicle):
    """By c (r / 4h)², h being the hub's height, 4/15 at most, and not where it points down."""
    (plain,) = bare(vehicle.rotors[:1])
    rotor = dataclasses.replace(plain, ground_effect_coefficient=11.4, propeller_radius=0.12)
    thrust = rotor.motor_constant * 700.0**2

    def lift(height, speed=700.0, q=(1.0, 0.0, 0.0, 0.0)):
        return wrench_on([rotor], state_of(height, q=q), [speed])[2]

    for height in (0.05, 0.1, 0.3, 1.0, 20.0):
        hub = height + rotor.p_BR[2]
        share = min(11.4 * (0.12 / (4.0 * hub)) ** 2, 4.0 / 15.0)
        assert lift(height) == pytest.approx(thrust * (1.0 + share), rel=1e-12)
    assert lift(0.05) == pytest.approx(thrust * 19.0 / 15.0)
    assert lift(0.0, speed=0.0) == 0.0
    assert lift(0.3, q=(0.0, 1.0, 0.0, 0.0)) == pytest.approx(thrust, rel=1e-12)


def test_thrust_with_a_linear_part_is_that_of_the_curve(vehicle):
    """2e-3 w besides k w², and drag torque follows it."""
    (rotor,) = bare(vehicle.rotors[:1])
    curved = dataclasses.replace(rotor, linear_motor_constant=2e-3)
    thrust = rotor.motor_constant * 700.0**2 + 2e-3 * 700.0
    found = wrench_on([curved], state_of(), [700.0])
    assert found[2] == pytest.approx(thrust, rel=1e-12)
    turning = -rotor.direction * rotor.moment_constant
    assert found[5] == pytest.approx(turning * thrust, rel=1e-12)
    fastest = wrench_on([curved], state_of(), [curved.max_rot_velocity])
    assert curved.max_thrust == pytest.approx(fastest[2])


def test_a_rotor_that_spins_up_turns_the_body_the_other_way(vehicle):
    """J dw/dt about its axis, against its turning; and J w across for a body that turns."""
    rotor = dataclasses.replace(
        vehicle.rotors[0], axis_B=(0.0, 0.0, 1.0), direction=1, motor_constant=1e-30, inertia=2e-4
    )
    still = state_of()
    assert wrench_on([rotor], still, [500.0], [3000.0])[3:] == pytest.approx([0, 0, -0.6])
    clockwise = dataclasses.replace(rotor, direction=-1)
    assert wrench_on([clockwise], still, [500.0], [3000.0])[3:] == pytest.approx([0, 0, 0.6])
    # -w x h = -(2, 0, 0) x (0, 0, 0.1)
    (turning,) = bare([rotor])
    found = wrench_on([turning], state_of(w_B=(2.0, 0.0, 0.0)), [500.0])
    assert found[3:] == pytest.approx([0, 0.2, 0], abs=1e-12)


def test_body_and_rotors_keep_their_angular_momentum(vehicle):
    """Without thrust and drag, whatever the rotors are commanded: 5 s, tumbling, axes that lean.

    Spin-up torque and gyroscopic moment are what makes it so, each with its size and its sign.
    """
    rng = np.random.default_rng(3)
    axes = rng.normal(size=(4, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    rotors = [
        dataclasses.replace(rotor, axis_B=tuple(axis), motor_constant=1e-30, inertia=6.5e-5)
        for rotor, axis in zip(bare(vehicle.rotors), axes.tolist(), strict=True)
    ]
    body = rigid_body(vehicle.mass, vehicle.inertia, (0.01, -0.02, 0.03))
    turns = [rotor.direction * rotor.inertia for rotor in rotors]

    def rates(_, x, commands):
        state, speeds = x[:13], x[13:]
        slopes = [speed_slope(*each) for each in zip(rotors, commands, speeds, strict=True)]
        wrench = wrench_on(rotors, state, speeds, slopes)
        R_WB = rotation(state[:4])
        six = body_acceleration(R_WB, into_body(R_WB, state[7:10]), wrench[:3], wrench[3:], *body)
        return [*quaternion_rate(state[:4], state[7:10]), *state[10:13], *six, *slopes]

    def momentum(x):
        R_WB = np.array(rotation(x[:4])).reshape(3, 3)
        return R_WB @ (vehicle.inertia @ R_WB.T @ x[7:10] + (turns * x[13:]) @ axes)

    x = np.array([*state_of(w_B=(9.0, -5.0, 7.0)), *rng.uniform(100.0, 1000.0, 4)])
    before, kept = momentum(x), []
    for _ in range(50):
        commands = rng.uniform(100.0, 1000.0, 4)
        x = solve_ivp(rates, (0.0, 0.1), x, args=(commands,), rtol=1e-8, atol=1e-8).y[:, -1]
        kept.append(x[13:])
        np.testing.assert_allclose(momentum(x), before, atol=1e-4 * np.linalg.norm(before))
    assert np.ptp(kept, axis=0).min() > 500.0


def test_a_load_carries_derivatives(vehicle):
    """Against central differences, of all that changes it."""
    rng = np.random.default_rng(8)
    rotors = [
        dataclasses.replace(
            rotor,
            inertia=6.5e-5,
            rolling_moment_coefficient=2e-6,
            inflow_coefficient=2e-4,
            ground_effect_coefficient=11.4,
            propeller_radius=0.12,
        )
        for rotor in vehicle.rotors
    ]
    q = rng.normal(size=4)
    q[3] = 3.0  # upright
    at = np.concatenate(
        [q, [0.0, 0.0, 0.4], rng.normal(size=6), rng.uniform(300, 900, 4), [900, -800, 70, 0]]
    )

    def loaded(values):
        state, speeds, slopes = np.split(values, [13, 17])
        found = wrench_on(rotors, list(state), list(speeds), list(slopes), None, (1, -2, 0.5), 0.02)
        return list(found)

    carried = ExtractGradient(np.array(loaded(InitializeAutoDiff(at).ravel())))
    columns = []
    for index in range(len(at)):
        change = np.zeros(len(at))
        change[index] = 1e-5 * max(1.0, abs(at[index]))
        above, below = (np.array(loaded(at + way * change)) for way in (1.0, -1.0))
        columns.append((above - below) / (2.0 * change[index]))
    assert carried == pytest.approx(np.array(columns).T, rel=1e-6, abs=1e-6)


def test_voltage_falls_with_power_and_never_below_nothing(vehicle):
    """Power goes with thrust to the 3/2: 0.95 without load, less 0.02 at that of hover."""
    speeds = vehicle.hover_speeds
    hover = [static_thrust(r, 1.0, w) for r, w in zip(vehicle.rotors, speeds, strict=True)]
    power = sum(thrust**1.5 for thrust in hover)
    for share in (0.0, 1.0, 4.0):
        now = sum(power_share(share * thrust) for thrust in hover)
        assert loaded_voltage(0.95, 0.02 / power, now) == pytest.approx(0.95 - 0.02 * share**1.5)
    assert loaded_voltage(0.95, 0.02 / power, 50.0 * power) == 0.0


def test_sag_is_compensated_as_far_as_it_is_known(case):
    """With the share c of what is known of the voltage s, w becomes s w / (1 + c (s_known - 1))."""
    for share, known in ((0.0, 0.7), (0.6, 0.8), (1.0, 0.8), (1.0, 0.9)):
        with case(share, known):
            found = compensated_share(0.75, 0.8, share, known)
            assert found == pytest.approx(1.0 + share * (known - 0.05 - 1.0))
    assert compensated_share(0.01, 0.01, 1.0, 0.01) == 0.1


@pytest.fixture
def rotor(vehicle):
    return dataclasses.replace(
        vehicle.rotors[0], time_constant_up=UP, time_constant_down=DOWN, max_rot_velocity=1100.0
    )


@pytest.mark.parametrize("error", [-1e4, -5.0, -1e-3, 0.0, 1e-3, 0.7, 300.0])
def test_the_two_parts_of_an_error_are_its_sides_but_for_the_blend(error):
    up, down = split_error(error)
    assert up + down == pytest.approx(error, abs=1e-9)
    other = min(NEAR, BLEND**2 / max(1.3 * abs(error), 1e-9))  # it fades
    assert up == pytest.approx(max(error, 0.0), abs=other)
    assert down == pytest.approx(min(error, 0.0), abs=other)


def test_at_no_error_both_parts_have_half_the_slope():
    """So that a linear model of hover has the mean of the two rates."""
    up, down = split_error(AutoDiffXd(0.0, [1.0]))
    assert (up.value(), down.value()) == (0.0, 0.0)
    assert up.derivatives()[0] == pytest.approx(0.5)
    assert down.derivatives()[0] == pytest.approx(0.5)


@pytest.mark.parametrize(("begin", "end"), [(300.0, 900.0), (900.0, 300.0), (0.0, 1100.0)])
def test_a_rotor_follows_the_closed_form_of_its_lag(rotor, begin, end):
    """But for the little that goes by the other time constant."""
    times = np.arange(1, 160) / 1024
    found = solve_ivp(
        lambda _, w: [speed_slope(rotor, end, w[0])],
        (0.0, times[-1]),
        [begin],
        t_eval=times,
        rtol=1e-9,
        atol=1e-9,
    )
    constant = UP if end > begin else DOWN
    plain = end + (begin - end) * np.exp(-times / constant)
    np.testing.assert_allclose(found.y[0], plain, atol=NEAR)


def test_a_steady_speed_stays(rotor):
    assert [speed_slope(rotor, speed, speed) for speed in (0.0, 10.0, 1100.0)] == [0.0] * 3


def test_a_command_is_cut_to_what_the_rotor_can_do(rotor):
    assert [within_speed_limits(u, rotor) for u in (-5.0, 0.0, 700.0, 1100.0, 9e9)] == [
        0,
        0,
        700,
        1100,
        1100,
    ]
