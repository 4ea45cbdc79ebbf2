"""Rotors that are weakened or stopped in flight.

Oracles: equations of equilibrium written otherwise, the pseudo-inverse, a rotor's run-down.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.rotors import wrench_matrix
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

DRONES = Path(__file__).parents[1] / "drones"
HEIGHT = 10.0
AT = 2.0
"""When rotors stop [s]."""


def in_the_air(name: str, settings=None) -> Session:
    """Return a flight hovering in still air; a name without a file is a shipped model."""
    path = DRONES / f"{name}.urdf.xacro"
    config = VehicleConfig(model=str(path) if path.is_file() else name)
    start = ScenarioStart(position=[0.0, 0.0, HEIGHT])
    return Session(Scenario(vehicle=config, start=start), settings)


@pytest.fixture(scope="module")
def sessions():
    return {"octocopter": in_the_air("octocopter")}


def flown_without(session: Session, *numbers: int, duration: float):
    session.reset()
    session.tick(AT)
    for number in numbers:
        session.set(f"rotor_{number}", 0.0)
    session.tick(duration)
    return session.recording()


def test_a_stopped_rotor_runs_down_with_its_time_constant(sessions):
    flight = flown_without(sessions["octocopter"], 3, duration=0.2)
    rotor = flight.vehicle.rotors[2]
    after = flight.time > AT
    lags = (flight.time[after] - AT) / rotor.time_constant_down
    speeds = flight.vehicle.hover_speeds[2] * np.exp(-lags)
    assert flight.rotor_speeds[after, 2] == pytest.approx(speeds, abs=1.0)


def test_the_mixer_does_not_know_of_a_stopped_rotor(sessions):
    """It asks for the smallest thrusts of all rotors that make the wrench, as before."""
    flight = flown_without(sessions["octocopter"], 3, duration=0.2)
    rotors = flight.vehicle.rotors
    effects = wrench_matrix(rotors, flight.vehicle.p_BoBcm_B)[2:]
    asked = np.array([rotor.motor_constant for rotor in rotors]) * flight.commanded_speeds**2
    smallest = asked @ effects.T @ np.linalg.pinv(effects).T
    assert asked == pytest.approx(smallest, rel=1e-9)
    assert asked[-1, 2] > 1.0
    assert flight.thrusts[-1, 2] < 0.1


@pytest.mark.slow
def test_a_quadrotor_without_a_rotor_turns_over_and_falls_and_nothing_breaks_off():
    flight = flown_without(in_the_air("dh_drone"), 2, duration=6.0)
    assert flight.time[-1] == AT + 6.0
    assert np.isfinite(flight.q_WB).all()
    assert np.degrees(flight.tilt.max()) > 90.0
    assert flight.p_WB[-1, 2] < 1.0


def test_a_rotor_that_works_again_is_used_again(sessions):
    session = sessions["octocopter"]
    flown_without(session, 1, duration=2.0)
    session.set("rotor_1", 1.0)
    session.tick(4.0)
    flight = session.recording()
    assert flight.thrusts[-1] == pytest.approx(np.full(8, flight.vehicle.mass * 9.81 / 8.0), 1e-3)
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
    session.tick(2.0)
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
