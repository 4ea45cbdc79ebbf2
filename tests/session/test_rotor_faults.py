"""Rotors that are weakened or stopped in flight.

Oracles: hover again, equations of equilibrium written otherwise, and the run-down of a rotor.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

from workbench.common.errors import WorkbenchError
from workbench.plant.rotors import wrench_matrix
from workbench.scenario.scenario import Action, Scenario, Start, VehicleConfig
from workbench.session.session import Session

DRONES = Path(__file__).parents[1] / "drones"
HEIGHT = 10.0
AT = 2.0
"""When rotors stop [s]."""


def in_the_air(name: str, settings=None, script=()) -> Session:
    """Return a flight hovering in still air; a name without a file is a shipped model."""
    path = DRONES / f"{name}.urdf.xacro"
    config = VehicleConfig(model=str(path) if path.is_file() else name)
    start = Start(position=[0.0, 0.0, HEIGHT])
    return Session(Scenario(vehicle=config, start=start, script=list(script)), settings)


@pytest.fixture(scope="module")
def sessions():
    return {name: in_the_air(name) for name in ("hexacopter", "octocopter", "coaxial_x8")}


def flown_without(session: Session, *numbers: int, duration: float):
    session.reset()
    session.tick(AT)
    for number in numbers:
        session.set(f"rotor_{number}", 0.0)
    session.tick(duration)
    return session.recording()


@pytest.mark.slow
def test_without_any_one_rotor_it_still_hovers(case, sessions):
    """The octocopter's and the X8's other rotors are these turned and mirrored."""
    for name, number in [
        *[("hexacopter", number) for number in range(1, 7)],
        *[("octocopter", number) for number in (1, 2)],
        *[("coaxial_x8", number) for number in (1, 2, 5)],
    ]:
        with case(name, number):
            duration = 15.0 if number == 1 else 5.0  # one of each, long enough for a slow drift
            flight = flown_without(sessions[name], number, duration=duration)
            assert flight.time[-1] == AT + duration
            assert np.abs(flight.p_WB - [0.0, 0.0, HEIGHT]).max() < 0.02
            assert np.degrees(flight.tilt.max()) < 1.0
            assert np.abs(flight.w_WB[:, 2]).max() < 0.01
            assert flight.thrusts[-1, number - 1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_a_hexacopter_hovers_on_four_equal_rotors(sessions):
    flight = flown_without(sessions["hexacopter"], 2, duration=5.0)
    quarter = flight.vehicle.mass * 9.81 / 4.0
    wanted = [quarter, 0.0, quarter, quarter, 0.0, quarter]
    assert flight.thrusts[-1] == pytest.approx(wanted, abs=0.01)


def test_a_stopped_rotor_runs_down_with_its_time_constant(sessions):
    flight = flown_without(sessions["octocopter"], 3, duration=0.2)
    rotor = flight.vehicle.rotors[2]
    after = flight.time > AT
    lags = (flight.time[after] - AT) / rotor.time_constant_down
    speeds = flight.vehicle.hover_speeds[2] * np.exp(-lags)
    assert flight.rotor_speeds[after, 2] == pytest.approx(speeds, abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("v_x", "v_y"), [(3.0, 0.0), (0.0, -3.0)])
def test_a_hexacopter_without_a_rotor_can_be_flown(v_x, v_y):
    script = [
        Action(at=0.5, set={"rotor_1": 0.0}),
        Action(at=1.0, velocity=[v_x, v_y, 0.0]),
        Action(at=5.0, velocity=[0.0, 0.0, 0.0]),
    ]
    session = in_the_air("hexacopter", script=script)
    session.tick(5.0)
    assert session.snapshot().v_WB == pytest.approx([v_x, v_y, 0.0], abs=0.02)
    session.tick(4.0)
    flight = session.recording()
    assert np.abs(flight.p_WB[:, 2] - HEIGHT).max() < 0.1
    assert np.degrees(flight.tilt.max()) < 20.0
    assert np.abs(flight.w_WB[:, 2]).max() < 0.1
    assert flight.v_WB[-1] == pytest.approx(np.zeros(3), abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("hexacopter", (1, 4)),
        ("octocopter", (1, 2)),
        ("octocopter", (1, 4)),
        ("coaxial_x8", (1, 5)),
    ],
)
def test_without_some_pairs_it_still_hovers(sessions, name, numbers):
    flight = flown_without(sessions[name], *numbers, duration=5.0)
    assert np.abs(flight.p_WB - [0.0, 0.0, HEIGHT]).max() < 0.02
    assert np.abs(flight.w_WB[:, 2]).max() < 0.02


@pytest.mark.slow
def test_where_yaw_must_go_it_turns_and_keeps_its_place(sessions):
    """Rotors 1 and 3 turn alike. Of all thrusts of the others that hover, none turns it less."""
    flight = flown_without(sessions["octocopter"], 1, 3, duration=5.0)
    assert np.abs(flight.p_WB - [0.0, 0.0, HEIGHT]).max() < 0.02
    vehicle = flight.vehicle
    lift, roll, pitch, yaw = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[2:]
    most = [rotor.max_thrust for rotor in vehicle.rotors]
    most[0] = most[2] = 0.0
    hover = [vehicle.mass * 9.81, 0.0, 0.0]
    bounds = [(0.0, thrust) for thrust in most]
    least = linprog(yaw, A_eq=[lift, roll, pitch], b_eq=hover, bounds=bounds)
    assert least.fun > 0.0
    late = np.searchsorted(flight.time, [AT + 1.0, AT + 4.0])
    gained = np.diff(flight.w_WB[late, 2])
    assert gained == pytest.approx(3.0 * least.fun / vehicle.inertia[2, 2], rel=0.01)


@pytest.mark.slow
def test_a_quadrotor_without_a_rotor_turns_ever_faster_before_it_falls():
    """By hand: the two beside the stopped one carry the weight, and turn the same way.

    So it goes on to turn with moment_constant m g / I_zz, less what the air takes. Before, the two
    that ran down and the two that ran up have turned it against their change of momentum.
    """
    session = in_the_air("dh_drone")
    flight = flown_without(session, 1, duration=10.0)
    vehicle = flight.vehicle
    spin = vehicle.rotors[1].moment_constant * vehicle.mass * 9.81 / vehicle.inertia[2, 2]
    early = np.searchsorted(flight.time, [AT + 0.2, AT + 0.3])
    rates = np.abs(flight.w_WB[early, 2])
    arm = np.hypot(*vehicle.rotors[1].p_BR[:2])
    drags = [rotor.rotor_drag_coefficient for rotor in vehicle.rotors] * flight.rotor_speeds[
        early[0]
    ]
    air = drags.sum() * arm**2 / vehicle.inertia[2, 2] * rates.mean()
    assert rates[1] - rates[0] == pytest.approx(0.1 * (spin - air), rel=0.02)
    change = flight.rotor_speeds[early[0]] - vehicle.hover_speeds
    turns = [rotor.direction * rotor.inertia for rotor in vehicle.rotors]
    kicked = abs(np.dot(turns, change)) / vehicle.inertia[2, 2]
    assert rates[0] == pytest.approx(kicked + 0.2 * spin, rel=0.2)
    assert np.abs(flight.p_WB[: early[1]] - [0.0, 0.0, HEIGHT]).max() < 0.02
    assert np.isfinite(flight.q_WB).all()


@pytest.mark.slow
def test_what_cannot_be_carried_falls_and_nothing_breaks_off():
    """By hand: two rotors of a drone that lifts 1.3 times its weight with four."""
    flight = flown_without(in_the_air("sluggish_quad"), 2, duration=6.0)
    assert flight.time[-1] == 8.0
    assert np.isfinite(flight.q_WB).all()
    assert flight.p_WB[-1, 2] < 1.0


def test_a_rotor_that_works_again_is_used_again(sessions):
    session = sessions["hexacopter"]
    flown_without(session, 1, duration=2.0)
    session.set("rotor_1", 1.0)
    session.tick(2.0)
    flight = session.recording()
    assert flight.thrusts[-1] == pytest.approx(np.full(6, flight.vehicle.mass * 9.81 / 6.0), 1e-3)
    assert abs(flight.w_WB[-1, 2]) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    "shares",
    [[0.9] * 8, [0.9, 1.0] * 4, [0.95] + [1.0] * 7, [1.0, 0.8, 0.9, 1.0, 1.0, 1.0, 0.85, 1.0]],
    ids=["all", "every other one", "one", "three"],
)
def test_weak_rotors_let_it_sink_turn_and_stand_off_as_the_gains_say(sessions, shares):
    """Hover needs the wrench (m g, 0, 0, 0) of the thrusts that act, B S f, so the law must ask
    for w = inverse(B S B⁺) (m g, 0, 0, 0). A PD law asks for more than it needs where something
    is amiss: too low by dz, turning at r, and, for moments, tilted against a wanted force that
    leans by phi, which it does at a distance from the place to hold.
    """
    session = sessions["octocopter"]
    session.reset()
    for number, share in enumerate(shares, start=1):
        session.set(f"rotor_{number}", share)
    session.tick(12.0)
    vehicle = session.vehicle
    effects = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[2:]
    acting = effects @ np.diag(shares) @ np.linalg.pinv(effects)
    asked = np.linalg.solve(acting, [vehicle.mass * 9.81, 0.0, 0.0, 0.0])
    lift = asked[0] / vehicle.mass
    sink = (lift - 9.81) / (session.get("kp_position_z") * session.get("kp_velocity_z"))
    turn = asked[3] / (vehicle.inertia[2, 2] * session.get("kp_yaw_rate"))
    lean = asked[1:3] / np.diag(vehicle.inertia)[:2]
    sine = np.hypot(*lean / [session.get("kp_roll"), session.get("kp_pitch")]) / 2.0
    pull = lift * math.tan(2.0 * math.asin(sine))
    way = pull / (session.get("kp_position_xy") * session.get("kp_velocity_x"))
    seen = session.snapshot()
    assert seen.p_WB[2] == pytest.approx(HEIGHT - sink, abs=1e-3)
    assert seen.w_WB[2] == pytest.approx(-turn, abs=1e-4)
    assert np.hypot(*seen.p_WB[:2]) == pytest.approx(way, rel=0.02, abs=1e-6)


def test_a_share_is_one_of_thrust_at_the_same_speed(sessions):
    session = sessions["octocopter"]
    session.reset()
    session.set("rotor_4", 0.6)
    session.tick(5.0)
    flight = session.recording()
    constants = np.array([rotor.motor_constant for rotor in flight.vehicle.rotors])
    whole = constants * flight.rotor_speeds[-1] ** 2
    assert flight.thrusts[-1] / whole == pytest.approx([1, 1, 1, 0.6, 1, 1, 1, 1], abs=1e-4)


def test_a_flight_may_begin_with_a_weak_rotor_and_begins_so_again():
    session = in_the_air("dh_drone", {"rotor_2": 0.9})
    assert session.get("rotor_2") == 0.9
    session.set("rotor_2", 0.5)
    session.reset()
    assert [session.get(f"rotor_{number}") for number in (1, 2, 3, 4)] == [1.0, 0.9, 1.0, 1.0]


def test_a_rotor_that_the_vehicle_has_not_got_is_refused():
    said = "rotor_9 cannot be set: dh_drone has 4 rotors"
    with pytest.raises(WorkbenchError, match=said):
        in_the_air("dh_drone", {"rotor_9": 0.0})
    session = in_the_air("dh_drone")
    with pytest.raises(WorkbenchError, match=said):
        session.set("rotor_9", 0.0)
    with pytest.raises(WorkbenchError, match="rotor_1 is 1.1: keep it within 0 .. 1$"):
        session.set("rotor_1", 1.1)
