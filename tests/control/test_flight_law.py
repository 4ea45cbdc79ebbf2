"""Oracle: the functions that the law is made of, each tested in its own file, put in a row here."""

import dataclasses
import math

import numpy as np
import pytest
import scipy.signal
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from tests.dynamics.wrench import wrench_on
from workbench.control.controller_file import load_controller
from workbench.control.flight_law import (
    UNFILTERED_COMPUTER,
    allocate,
    commanded_wrench,
    flight_law,
    full_speed,
)
from workbench.control.flight_state import mass_velocity, still_air_drag, thrust_attitude
from workbench.control.guidance import (
    LIFT_FIELD,
    MOTORS_FIELD,
    Guidance,
    LawSetpoint,
    MeasuredMotion,
)
from workbench.control.law_constants import known_body, law_constants
from workbench.control.law_signals import FILTER_STATE_COUNT, quantized_speed, smoothed_setpoint
from workbench.control.mixer import mix
from workbench.estimation.filters import lowpass
from workbench.plant.drag import drag_area, drag_rates
from workbench.plant.gravity import AIR_DENSITY
from workbench.plant.rotors import wrench_matrix
from workbench.systems.acceleration_estimate import sampled_estimate

LAW = load_controller()
PERIOD = 1 / 128
STRAIGHT, NO_WRENCH = [0.0] * 3, [0.0] * 4


def commands(signals, gains, constants) -> list[float]:
    found = [0.0] * 4
    state, acceleration, reference, guide = signals
    wrench = (0.0, 0.0, 0.0, 0.0)
    if guide[LIFT_FIELD] > 0.0:
        setpoint, memory = LawSetpoint(reference, guide, STRAIGHT), LAW.initial_memory
        law = flight_law(LAW).wrench
        wrench, _ = law(
            state, acceleration, 1.0, setpoint, gains, memory, NO_WRENCH, PERIOD, constants, None
        )
    allocate(wrench, guide[LIFT_FIELD], guide[MOTORS_FIELD], constants, found)
    return found


def commands_in_a_row(vehicle, signals, gains) -> list[float]:
    state, acceleration, reference, guide = signals
    rates = drag_rates(vehicle)
    drag = still_air_drag(state[:4], state[10:13], rates)
    measured = MeasuredMotion(
        state[4:7], state[10:13], acceleration, state[:4], state[7:10], drag, NO_WRENCH
    )
    setpoint = LawSetpoint(reference, guide, STRAIGHT)
    six = vehicle.inertia[np.triu_indices(3)].tolist()
    known = known_body(law_constants(vehicle))
    body = known._replace(mass=vehicle.mass, inertia=six, yaw_drag=rates.yaw)
    asked, _ = LAW.update(measured, setpoint, gains, body, (), PERIOD, None)
    most = [rotor.motor_constant * rotor.max_rot_velocity**2 for rotor in vehicle.rotors]
    least = [0.01 * thrust for thrust in most]  # a tenth of the speed
    thrusts = [0.0] * 4
    mix(*asked, law_constants(vehicle).allocation, least, most, thrusts)
    return [(f / r.motor_constant) ** 0.5 for f, r in zip(thrusts, vehicle.rotors, strict=True)]


def test_commands_are_law_mixer_and_root_in_a_row(vehicle, gains, random_signals):
    rng = np.random.default_rng(8)
    constants = law_constants(vehicle)
    for _ in range(300):
        signals = random_signals(rng)
        wanted = commands_in_a_row(vehicle, signals, gains)
        assert commands(signals, gains, constants) == pytest.approx(wanted, rel=1e-12)


def test_the_law_inverts_a_thrust_curve_with_a_linear_part(vehicle, gains, random_signals):
    """It asks for the same thrusts as of rotors without, by speeds that make them."""
    rng = np.random.default_rng(9)
    rotors = []
    for rotor in vehicle.rotors:
        # as strong at most
        linear = 0.2 * rotor.motor_constant * rotor.max_rot_velocity
        square = 0.8 * rotor.motor_constant
        rotors.append(
            dataclasses.replace(rotor, motor_constant=square, linear_motor_constant=linear)
        )
    curved = dataclasses.replace(vehicle, rotors=tuple(rotors))
    constants, plain = law_constants(curved), law_constants(vehicle)
    assert constants.max_thrusts == pytest.approx(plain.max_thrusts, rel=1e-12)
    constants = constants._replace(idle_thrusts=plain.idle_thrusts, drag=plain.drag)
    for _ in range(50):
        signals = random_signals(rng)
        speeds = np.array(commands(signals, gains, constants))
        made = rotors[0].motor_constant * speeds**2 + rotors[0].linear_motor_constant * speeds
        plainly = np.array(commands(signals, gains, plain))
        wanted = vehicle.rotors[0].motor_constant * plainly**2
        assert made == pytest.approx(wanted, rel=1e-9)
        made_moment, wanted_moment = (
            commanded_wrench(each, known)[3]
            for each, known in ((speeds, constants), (plainly, plain))
        )
        assert made_moment == pytest.approx(wanted_moment)


def test_hovering_in_place_takes_the_hover_speeds(vehicle, gains):
    state = [1.0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0]
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 3.0)
    found = commands((state, [0.0] * 3, [0.0] * 8, hold), gains, law_constants(vehicle))
    assert found == pytest.approx(vehicle.hover_speeds)


@pytest.mark.parametrize(("motors", "lift", "share"), [(0.0, 1.0, 0.0), (0, 0, 0), (1.0, 0.0, 0.1)])
def test_without_motors_rotors_stop_and_without_lift_they_idle(
    vehicle, gains, random_signals, motors, lift, share
):
    state, acceleration, reference, guide = random_signals(np.random.default_rng(9))
    guide = [motors, lift, *guide[2:]]
    signals = (state, acceleration, reference, guide)
    found = commands(signals, gains, law_constants(vehicle))
    assert found == pytest.approx([share * rotor.max_rot_velocity for rotor in vehicle.rotors])


def updated(signals, gains, constants, filtered) -> tuple[np.ndarray, np.ndarray]:
    """Return commands, and what the stages before the law then remember."""
    state, _, reference, guide = signals
    found = np.zeros(4)
    after, _ = flight_law(LAW).update(
        state,
        1.0,
        LawSetpoint(reference, guide, STRAIGHT),
        gains,
        constants,
        None,
        sampled_estimate(PERIOD),
        UNFILTERED_COMPUTER,
        filtered,
        LAW.initial_memory,
        found,
    )
    return found, np.array(after)


def test_an_update_estimates_and_commands(vehicle, gains, random_signals):
    rng = np.random.default_rng(10)
    constants = law_constants(vehicle)
    share, rate = sampled_estimate(PERIOD)
    for _ in range(200):
        state, _, reference, guide = random_signals(rng)
        v_WB, remembered = np.array(state[10:13]), rng.normal(size=FILTER_STATE_COUNT)
        filtered = remembered[:3]
        acceleration = rate * (v_WB - filtered)
        signals = (state, acceleration, reference, guide)
        asked = commands_in_a_row(vehicle, signals, gains)
        found, after = updated(signals, gains, constants, remembered)
        assert found == pytest.approx(asked, rel=1e-12)
        wanted = [*filtered + share * (v_WB - filtered), *acceleration, *reference[:4]]
        assert after == pytest.approx(wanted, abs=1e-12)


def test_commands_of_a_resolution_are_the_nearest_ones(vehicle, gains, random_signals):
    rng = np.random.default_rng(13)
    constants = law_constants(vehicle)
    most = [full_speed(constants, i) for i in range(4)]
    assert most == pytest.approx([rotor.max_rot_velocity for rotor in vehicle.rotors])
    step = vehicle.rotors[0].max_rot_velocity / 50.0
    for _ in range(50):
        exact, _ = updated(
            random_signals(rng), gains, constants, rng.normal(size=FILTER_STATE_COUNT)
        )
        found = [quantized_speed(*each, 50.0) for each in zip(exact, most, strict=True)]
        assert found == pytest.approx(step * np.round(exact / step), abs=1e-9)


def test_a_setpoints_lowpass_is_butterworths_on_each_of_its_four_numbers():
    rng = np.random.default_rng(14)
    asked, states = rng.normal(size=(60, 4)), (0.0, 0.0, 0.0, 0.0)
    found = []
    for numbers in asked:
        setpoint = LawSetpoint((*numbers, 7.0, 8.0, 9.0, 1.0), NO_WRENCH, STRAIGHT)
        smooth, states = smoothed_setpoint(lowpass(5.0, 1.0, PERIOD), states, setpoint)
        found.append(smooth.reference[:4])
        assert smooth.reference[4:] == (7.0, 8.0, 9.0, 1.0)
    wanted = scipy.signal.lfilter(*scipy.signal.butter(1, 5.0, fs=1.0 / PERIOD), asked, axis=0)
    np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.fixture(scope="module")
def odd_vehicle(vehicle):
    """The centre of mass far off, and all rotors leaning forward by a tenth of a radian."""
    lean = (math.sin(0.1), 0.0, math.cos(0.1))
    rotors = tuple(dataclasses.replace(rotor, axis_B=lean) for rotor in vehicle.rotors)
    return dataclasses.replace(vehicle, rotors=rotors, p_BoBcm_B=(0.02, -0.01, 0.2))


def test_velocity_is_that_of_the_centre_of_mass(odd_vehicle, random_signals):
    rng = np.random.default_rng(13)
    lever = law_constants(odd_vehicle).p_BoBcm_B
    assert lever == [0.02, -0.01, 0.2]
    for _ in range(50):
        state = random_signals(rng)[0]
        scaled = [1.3 * q for q in state[:4]] + state[4:]
        R_WB = RotationMatrix(Quaternion(np.array(state[:4])))
        wanted = state[10:13] + np.cross(state[7:10], R_WB @ np.array(lever))
        assert mass_velocity(scaled, lever) == pytest.approx(wanted)


def test_attitude_is_that_of_the_frame_in_which_rotors_lift(odd_vehicle, random_signals):
    rng = np.random.default_rng(14)
    q_BT = law_constants(odd_vehicle).q_BT
    R_BT = RotationMatrix.MakeYRotation(0.1)
    for _ in range(50):
        q_WB = random_signals(rng)[0][:4]
        found = RotationMatrix(Quaternion(np.array(thrust_attitude(q_WB, q_BT))))
        R_WB = RotationMatrix(Quaternion(np.array(q_WB)))
        assert found.matrix() == pytest.approx((R_WB @ R_BT).matrix())


def test_a_centre_of_mass_within_a_millimetre_counts_as_the_origin(vehicle):
    assert 1e-4 < vehicle.p_BoBcm_B[2] < 1e-3
    assert law_constants(vehicle).p_BoBcm_B == [0.0, 0.0, 0.0]


def test_an_odd_vehicle_hovers_leaning_back_on_the_weight_alone(odd_vehicle, gains):
    q_WB = [math.cos(0.05), 0.0, -math.sin(0.05), 0.0]
    state = [*q_WB, 1, 2, 3, 0, 0, 0, 0, 0, 0]
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 3.0)
    constants = law_constants(odd_vehicle)
    speeds = np.array(commands((state, [0.0] * 3, [0.0] * 8, hold), gains, constants))
    thrusts = constants.motor_constants * speeds**2
    assert thrusts.sum() == pytest.approx(odd_vehicle.mass * 9.81)
    wrench = wrench_matrix(odd_vehicle.rotors, odd_vehicle.p_BoBcm_B) @ thrusts
    assert wrench[3:] == pytest.approx(np.zeros(3), abs=1e-9)


def drag_wrench(state, speeds, half_drag, rotors):
    """Return the wrench of drag alone in still air."""
    bare = [dataclasses.replace(rotor, motor_constant=0.0) for rotor in rotors]
    return wrench_on(bare, state, speeds, half_drag=half_drag)


def test_the_drag_that_the_law_expects_is_the_one_that_acts(vehicle):
    """On the drone as it hovers, in still air: what it expects takes away what acts."""
    rng = np.random.default_rng(30)
    centred = [dataclasses.replace(r, p_BR=(*r.p_BR[:2], 0.0)) for r in vehicle.rotors]
    pressure = 0.5 * AIR_DENSITY * drag_area(vehicle.mass)
    for _ in range(50):
        q, v_WB = rng.normal(size=4), rng.normal(size=3) * 4.0
        state = [*q, *[0.0] * 6, *v_WB]
        speeds = vehicle.hover_speeds
        wrench = drag_wrench(state, speeds, pressure, centred)
        R_WB = RotationMatrix(Quaternion(q / np.linalg.norm(q))).matrix()
        expected = still_air_drag(q, v_WB, drag_rates(vehicle))
        assert expected == pytest.approx(-R_WB @ wrench[:3] / vehicle.mass, rel=1e-3, abs=1e-3)


def test_the_yaw_drag_that_the_law_expects_is_the_one_that_acts(vehicle):
    state = [1.0, *[0.0] * 8, 0.4, 0.0, 0.0, 0.0]
    wrench = drag_wrench(state, vehicle.hover_speeds, 0.0, vehicle.rotors)
    expected = drag_rates(vehicle).yaw * 0.4
    assert wrench[5] / vehicle.inertia[2, 2] == pytest.approx(-expected, rel=1e-3)
