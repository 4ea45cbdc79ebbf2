"""What a prediction starts from, on motions in closed form: nothing of it is of later."""

from pathlib import Path

import numpy as np
import pytest
from scipy import linalg
from scipy.spatial.transform import Rotation

from workbench.control.controller_file import load_controller
from workbench.extras.flightdata.predict import driven, flown, known, prediction
from workbench.extras.flightdata.predict.motion import LoggedMotion, rotation_matrices
from workbench.extras.flightdata.predict.past import PAST_AVERAGE_S, Past
from workbench.extras.flightdata.predict.prediction import (
    CONSTANT_METHOD,
    FADING_RATES_METHOD,
    GIVEN_ATTITUDE_METHOD,
    LATE_SETPOINT_METHOD,
    RATE_DECAY_S,
    SETPOINT_LAG_S,
    Predictor,
)
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import VehicleConfig

DRONES = Path(__file__).parents[3] / "drones"
PERIOD, COUNT = 0.01, 500
TIME = PERIOD * np.arange(COUNT)


@pytest.fixture(scope="module")
def vehicle():
    return configured_vehicle(VehicleConfig(model="dh_drone"))


def motion(seed=1, **changed) -> LoggedMotion:
    """Return a motion in the air of waves of all axes, but for some of its arrays."""
    random = np.random.default_rng(seed)

    def waves(count, size):
        rates, phases = random.uniform(1.0, 4.0, count), random.uniform(0.0, 6.0, count)
        return size * np.sin(TIME[:, None] * rates + phases)

    q, q_known = (Rotation.from_rotvec(waves(3, 0.2)).as_quat(scalar_first=True) for _ in range(2))
    made = LoggedMotion(
        name="made up",
        period=PERIOD,
        q=q,
        p=waves(3, 1.0) + [0.0, 0.0, 5.0],
        v=waves(3, 2.0),
        w=waves(3, 1.0),
        q_known=q_known,
        p_known=waves(3, 1.0),
        v_known=waves(3, 2.0),
        setpoint=waves(3, 1.0),
        attitude_setpoint=waves(3, 0.2),
        thrust_setpoint=0.5 + waves(1, 0.1)[:, 0],
        commands=0.5 + waves(4, 0.1),
        voltage=15.0 + waves(1, 0.5)[:, 0],
        measured=np.ones(COUNT, bool),
    )
    return made._replace(**changed)


def test_the_ground_is_where_a_drone_stood_and_else_no_higher_than_zero():
    """A log that begins and ends in the air says of the ground only that it was not above it."""
    flown = motion()
    lowest = flown.p[:, 2].min()
    assert lowest > 1.0 and flown.ground == 0.0
    below = flown._replace(p=flown.p - [0.0, 0.0, 9.0])
    assert below.ground == lowest - 9.0
    stood = flown.commands.copy()
    stood[:5] = 0.0
    assert flown._replace(commands=stood).ground == lowest


def test_the_air_is_above_0_3_m_and_0_2_s_away_from_it_at_both_ends():
    """A climb and a descent at the same speed, with motors that stand before and after."""
    ends = np.minimum(TIME, TIME[::-1])
    climb = 2.0 / ends.max()
    place = np.stack([*np.zeros((2, COUNT)), 1.0 + climb * ends], axis=1)
    turning = np.where(ends > 2.0 * PERIOD, 0.5, 0.0)[:, None] * np.ones(4)
    first, last = motion(p=place, commands=turning).airborne
    assert first * PERIOD == pytest.approx(0.3 / climb + 0.2, abs=1.01 * PERIOD)
    assert last == COUNT - 1 - first


def past_of(vehicle, flight, listen) -> Past:
    """Return the past of a flight of PX4's law, which has a memory."""
    px4 = load_controller("px4")
    gains = dict(flight_gains(vehicle, controller=px4))
    model = flown.make_compiled_model(vehicle, px4, gains, px4.period)
    return Past(flight, vehicle, px4, gains, model, listen)


def summed(measured, references, voltages, told, places, first, model):
    """Return as memory after each update the sum of all that was heard until then."""
    heard = np.cumsum(measured.sum(axis=1) + references.sum(axis=1) + voltages)
    return np.repeat(heard[:, None], len(first), axis=1)


def numbered(measured, *others):
    """Return as memory after each update its number, from 0."""
    return np.repeat(np.arange(float(len(measured)))[:, None], len(others[4]), axis=1)


def test_a_start_is_the_same_whatever_follows(vehicle):
    at, before, other = 250, motion(1), motion(2)
    later = {
        name: np.where(np.arange(COUNT).reshape(-1, *[1] * (mine.ndim - 1)) > at, its, mine)
        for name, mine, its in zip(LoggedMotion._fields, before, other, strict=True)
        if isinstance(mine, np.ndarray)
    }
    starts = [
        past_of(vehicle, each, summed).start(np.array([at, at - 1]))
        for each in (before, before._replace(**later))
    ]
    for name, one, two in zip(starts[0]._fields, *starts, strict=True):
        np.testing.assert_array_equal(one, two, err_msg=name)


def test_without_a_past_thrust_is_taken_as_described_and_nothing_pushes(vehicle):
    """In its first 0.7 s a log has too little to go by; then the thrust has a measured share."""
    before = round(PAST_AVERAGE_S / PERIOD)
    start = past_of(vehicle, motion(), summed).start(np.array([1, before, before + 1, 300]))
    assert (start.shares[:2] == 1.0).all() and not start.pushes[:2].any()
    assert (start.shares[2:] != 1.0).all() and start.pushes[2:, 0, 3:5].all()


def test_the_memory_at_a_start_is_that_of_the_last_update_before_it(vehicle):
    """The law updates first when its rotors turn, here at 1 s, and then each of its periods."""
    commands = np.where(TIME[:, None] < 1.0, 0.0, np.full((1, 4), 0.5))
    past = past_of(vehicle, motion(commands=commands), numbered)
    samples = np.array([150, 233, 400])
    start = past.start(samples)
    updates = np.floor((TIME[samples] - 1.0) / load_controller("px4").period + 1e-9)
    np.testing.assert_allclose(start.counts, updates, atol=1.0)
    np.testing.assert_array_equal(start.memory[:, 0], start.counts - 1.0)


def test_a_flight_computer_takes_the_start_for_what_it_knew(vehicle):
    """Of attitudes that are off by a constant turn for 3 s, and by one about level axes since."""
    constant, since = np.array([0.02, -0.015, 0.03]), np.array([0.01, 0.02, 0.0])
    at, true = 400, motion(3)
    off = np.tile(constant, (COUNT, 1))
    off[: at - 299] = -0.2, 0.3, 0.1  # what was before is forgotten
    turn = rotation_matrices(true.q)
    told = turn * Rotation.from_rotvec(off)
    told = Rotation.concatenate([told[:at], Rotation.from_rotvec(since) * told[at], told[at + 1 :]])
    flight = true._replace(q_known=told.as_quat(scalar_first=True))
    start = past_of(vehicle, flight, numbered).start(np.array([at]))
    taken = known.state_with_error(tuple(start.states[0]), start.errors[0])
    left = told[at].inv() * Rotation.from_quat(taken[:4], scalar_first=True)
    assert left.magnitude() < 0.02 * np.linalg.norm(since)
    assert taken[4:7] == pytest.approx(flight.p_known[at], abs=1e-12)
    assert taken[10:13] == pytest.approx(flight.v_known[at], abs=1e-12)
    np.testing.assert_allclose(start.states[0, 7:10], turn[at].apply(flight.w[at]), atol=1e-12)


def test_inner_integrals_hold_the_moment_of_the_air():
    """A Crazyflie's rotors are dragged above its centre of mass: forwards, that lifts its nose.

    Each rotor gives half of what the law asks for about an axis, in 65535 of its largest thrust;
    the firmware's pitch is positive nose up.
    """
    drone = configured_vehicle(VehicleConfig(model=str(DRONES / "nanobench.urdf")))
    law = load_controller("crazyflie")
    gains = dict(flight_gains(drone, controller=law))
    level, v = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1)), np.array([1.5, -0.8, 0.0])
    flight = motion(q=level, v=np.tile(v, (COUNT, 1)))
    model = flown.make_compiled_model(drone, law, gains, law.period)
    memory = Past(flight, drone, law, gains, model, numbered).start(np.array([300])).memory[0]
    names = [state.name for state in law.memory]
    rotors, speeds = drone.rotors, drone.hover_speeds
    pull = [each.rotor_drag_coefficient * w for each, w in zip(rotors, speeds, strict=True)]
    hubs = np.array([each.p_BR for each in rotors]) - drone.p_BoBcm_B
    moment = sum(np.cross(hub, -k * v) for hub, k in zip(hubs, pull, strict=True))
    for axis, arm, sign, gain in (
        (0, 1, 1.0, "pid_rate_roll_ki"),
        (1, 0, -1.0, "pid_rate_pitch_ki"),
    ):
        integral = memory[names.index(f"i_rate_{'xyz'[axis]}")]
        thrust = 0.5 * integral * gains[gain] * gains["thrust_max"] / 65535.0
        held = sign * thrust * np.abs(hubs[:, arm]).sum()
        assert abs(moment[axis]) > 1e-6
        assert held == pytest.approx(-moment[axis], rel=0.02)


def test_a_push_acts_in_the_axes_that_it_is_stated_in(vehicle):
    """Of a drone on its side: forces in W and B that are the same, and a moment in B."""
    pd = load_controller("pd")
    model = flown.make_compiled_model(
        vehicle, pd, dict(flight_gains(vehicle, controller=pd)), 1 / 128
    )
    turn = Rotation.from_euler("ZYX", [0.7, -0.3, 1.2])
    state = np.array([[*turn.as_quat(scalar_first=True), 0, 0, 10.0, *[0.0] * 6]])
    ones = np.ones((1, 4))
    start = flown.FlightStarts(
        states=state,
        speeds=vehicle.hover_speeds[None],
        memory=np.zeros((1, 0)),
        counts=np.zeros(1),
        errors=np.zeros((1, known.ESTIMATE_ERROR_SIZE)),
        voltages=np.ones(1),
        shares=ones,
        pushes=np.zeros((1, 1, driven.PUSH_SIZE)),
    )

    def ended(push):
        course = flown.FlightCourses(np.zeros((1, 1, 8)), np.ones((1, 1)), push[None, None])
        states = flown.compiled_driven(pd).fly(model, start, course, known.Observer())
        return states[0, 1, 7:13]

    still, push = ended(np.zeros(driven.PUSH_SIZE)), np.array([3.0, -2.0, 1.0])
    for place, moved in ((slice(0, 3), push), (slice(3, 6), turn.apply(push))):
        pushed = np.zeros(driven.PUSH_SIZE)
        pushed[place] = push
        change = (ended(pushed) - still)[3:]
        np.testing.assert_allclose(change, moved / vehicle.mass / 128, atol=0.02 * np.ptp(change))
    twisted = np.zeros(driven.PUSH_SIZE)
    twisted[6:9] = 0.02, -0.03, 0.01
    change = turn.inv().apply((ended(twisted) - still)[:3])
    expected = np.linalg.solve(vehicle.inertia, twisted[6:9]) / 128
    np.testing.assert_allclose(change, expected, atol=0.02 * np.ptp(expected))


def test_the_voltage_is_over_that_which_the_law_takes_for_full(vehicle):
    px4 = load_controller("px4")
    gains = {**flight_gains(vehicle, controller=px4), "vbat": 16.0}
    flight = motion()
    model = flown.make_compiled_model(vehicle, px4, dict(gains), px4.period)
    past = Past(flight, vehicle, px4, gains, model, numbered)
    samples = np.array([10, 300])
    np.testing.assert_allclose(past.start(samples).voltages, flight.voltage[samples] / 16.0)


def test_an_estimate_takes_drag_for_tilt_as_its_equations_say():
    """de/dt = eta + d v - L e and deta/dt = -W e, beside the exponential of their matrix."""
    gain, tilt, drag = observer = known.Observer(7.0, 10.0, 0.4)
    v, error, dt = (3.0, -2.0, 1.0), np.zeros(known.ESTIMATE_ERROR_SIZE), 1e-4
    error[3:8] = 0.2, 0.1, -0.3, 0.5, -0.4
    begun, count = error.copy(), 4000
    for _ in range(count):
        known.step_error(error, v, observer, dt)
    A = np.array([[-gain, 1.0, drag], [-tilt, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for axis in (0, 1):
        after = linalg.expm(A * dt * count) @ [begun[3 + axis], begun[6 + axis], v[axis]]
        assert [error[3 + axis], error[6 + axis]] == pytest.approx(after[:2], abs=1e-3)
    assert error[5] == pytest.approx(-0.3 * np.exp(-gain * dt * count), rel=1e-3)


@pytest.fixture
def predictor(vehicle, monkeypatch):
    """Return a predictor whose flights stay where they begin."""

    def fly(model, start, course, observer, keep):
        return np.tile(start.states[:, None], (1, course.references.shape[1] // keep + 1, 1))

    monkeypatch.setattr(
        prediction, "compiled_driven", lambda controller: flown.DrivenFunctions(fly, numbered)
    )
    pd = load_controller("pd")
    return Predictor(vehicle, pd, dict(flight_gains(vehicle, controller=pd)), 1 / 128)


def test_a_flight_is_in_the_air_from_above_its_start_to_its_landing():
    """0.3 m above the ground from 1 to 4 s, less 0.2 s at either end; a gap is one in the air."""
    p = np.where((TIME >= 1.0) & (TIME < 4.0), 1.0, 0.2)[:, None] * [0.0, 0.0, 1.0]
    measured = (TIME >= 0.9) & ((TIME < 2.0) | (TIME >= 2.3)) & ((TIME < 3.0) | (TIME >= 3.1))
    flight = motion(p=p, commands=np.zeros((COUNT, 4)), measured=measured)
    assert flight.airborne == (120, 379)
    assert flight.longest_part(0.5) == (120, 379)
    assert flight.longest_part(0.2) == (230, 379) and flight.longest_part(0.05) == (120, 199)
    ends = motion(p=p, commands=np.zeros((COUNT, 4)), measured=(TIME >= 1.22) & (TIME < 3.5))
    assert ends.longest_part(0.5) == (120, 379) and ends.longest_part(0.2) == (120, 349)
    assert motion(p=0.2 + 0.0 * p, commands=np.zeros((COUNT, 4))).airborne == (0, 0)
    assert motion(p=p).airborne == (0, COUNT - 1)  # its rotors turn from the begin on


def test_rotors_that_idle_do_not_fly_and_a_log_may_begin_in_flight(case):
    """Armed at 10 % before 1 s and after 4 s, as logs of autopilots begin; a landing at its end."""
    up = (TIME >= 1.0) & (TIME < 4.0)
    p = np.where(up, 1.0, 0.2)[:, None] * [0.0, 0.0, 1.0]
    commands = np.repeat(np.where(up, 0.5, 0.1)[:, None], 4, axis=1)
    whole = motion(p=p, commands=commands)
    arrays = {name: each for name, each in whole._asdict().items() if np.ndim(each)}
    for begin, end, expected in (
        (0, COUNT, (120, 379)),
        (200, COUNT, (0, 179)),
        (0, 300, (120, 279)),
        (200, 300, (0, 99)),
    ):
        with case(begin, end):
            part = {name: each[begin:end] for name, each in arrays.items()}
            assert whole._replace(**part).airborne == expected


def test_of_two_flights_in_a_log_the_longer_one_counts(case):
    """Between them the drone stands with its rotors at rest; a hop with turning rotors is none."""
    for landing, take_off, idle, expected in (
        (2.0, 2.5, 0.0, (270, 429)),
        (3.5, 4.0, 0.0, (120, 329)),
        (2.0, 2.5, 0.3, (120, 429)),
    ):
        with case(landing, idle):
            stands = np.clip(TIME, landing, take_off - 0.5 * PERIOD) == TIME
            ground = stands | (TIME < 1.0) | (TIME >= 4.5)
            turning = np.where(ground, 0.0, 0.5)
            turning[stands] = idle
            flight = motion(
                p=np.where(ground, 0.2, 1.0)[:, None] * [0.0, 0.0, 1.0],
                commands=np.repeat(turning[:, None], 4, axis=1),
            )
            assert flight.airborne == expected


def test_no_prediction_goes_over_a_gap(predictor):
    """Windows of 0.5 s from 1 s on; from 2.00 to 2.19 s, and at 4.5 s, nothing was measured."""
    measured = (np.arange(COUNT) < 200) | (np.arange(COUNT) >= 220)
    measured[450] = False
    found = predictor.predict(motion(measured=measured), horizon=0.5, every=0.05)
    begins = np.arange(100, COUNT - 1 - 50, 5)
    expected = [k for k in begins if measured[k : k + 51].all()]
    assert np.rint(found.starts / PERIOD).astype(int).tolist() == expected
    assert {145, 150, 215, 220, 395, 400} & set(expected) == {145, 220, 395}


def test_a_law_flies_to_what_was_asked_at_the_time_of_each_update(vehicle):
    """Setpoints rise at 1, 2 and 3 m/s, so that each of them tells its time."""
    speed = np.array([1.0, 2.0, 3.0])
    past = past_of(vehicle, motion(setpoint=TIME[:, None] * speed), numbered)
    period = load_controller("px4").period
    found = past.references(np.array([150, 201]), 0.1)
    assert found.shape == (2, round(0.1 / period), 8)
    times = TIME[[150, 201], None] + period * np.arange(found.shape[1])
    np.testing.assert_allclose(found[:, :, 4:7], times[:, :, None] * speed, atol=1e-9)


def test_each_simple_method_is_exact_where_it_is_true(predictor, case):
    """Setpoints of `SETPOINT_LAG_S` before; a steady flight; rates that fade, about the axis up."""

    def errors(method, **changed):
        found = predictor.predict(motion(**changed), horizon=0.5)
        return next(each for each in found.errors if each.method == method)

    def path(time):
        return np.column_stack([np.sin(1.3 * time), np.cos(0.9 * time), 2.0 + 0.1 * time])

    with case(LATE_SETPOINT_METHOD):
        assert (
            errors(
                LATE_SETPOINT_METHOD, p=path(TIME - SETPOINT_LAG_S), setpoint=path(TIME)
            ).position.max()
            < 1e-9
        )
    level, speed = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1)), np.array([1.0, -0.5, 0.1])
    steady = {
        "p": TIME[:, None] * speed,
        "v": np.tile(speed, (COUNT, 1)),
        "q": level,
        "q_known": level,
        "w": np.zeros((COUNT, 3)),
        "commands": np.full((COUNT, 4), 0.5),
    }
    for method in (CONSTANT_METHOD, GIVEN_ATTITUDE_METHOD, FADING_RATES_METHOD):
        with case(method):
            found = errors(method, **steady)
            assert max(found.position.max(), found.velocity.max()) < 1e-9
            assert found.attitude.max() < 1e-9
    true = motion()
    with case(GIVEN_ATTITUDE_METHOD):
        assert errors(GIVEN_ATTITUDE_METHOD, q_known=true.q).attitude.max() < 1e-6
    fades = 2.0 * np.exp((1.0 - TIME) / RATE_DECAY_S)  # 2 rad/s at the first start
    turned = Rotation.from_rotvec(np.outer(-RATE_DECAY_S * fades, [0.0, 0.0, 1.0]))
    with case(FADING_RATES_METHOD):
        rates = np.outer(fades, [0.0, 0.0, 1.0])
        found = errors(FADING_RATES_METHOD, q=turned.as_quat(scalar_first=True), w=rates)
        assert found.attitude.max() < 1e-6
