"""Batches of flights; the oracles are compiled flights one by one, and the full diagram."""

import math
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.rollout.agreement import random_trials
from workbench.design.rollout.batch import Batch
from workbench.design.rollout.candidates import start_state
from workbench.dynamics.air.settings import calm_air
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import wrench_matrix
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.open_loop import fly_open_loop
from workbench.session.session import Session

CLOSE = 1e-9


def test_each_flies_as_the_engine_flies_it_to_the_bit(engine, vehicle):
    """Random gains, half of them thrown, some saturated and lost; in one call and in many."""
    trials = random_trials(vehicle, engine.gains, 40, 3)
    starts = np.array([start_state(vehicle, each.start) for each in trials])
    commands = np.array([each.command for each in trials])
    wanted = engine.fly_from([each.gains for each in trials], starts, commands, duration=1.0)
    batch = Batch(len(trials))
    batch.starts[:] = starts
    for name in trials[0].gains:
        batch.parameters[name][:] = [each.gains[name] for each in trials]
    batch.reset()
    batch.setpoint.velocity[:], batch.setpoint.yaw_rate[:] = commands[:, :3], commands[:, 3]
    for periods in (1, 2, 61, 64):
        batch.step(periods)
    lost = np.isfinite(wanted.diverged_at)
    assert np.array_equal(batch.lost, lost)
    assert np.array_equal(batch.state[~lost], wanted.states[~lost, -1])
    assert np.isfinite(batch.state).all()
    assert (batch.time == 1.0).all()
    assert "40 dh_drone with pd" in repr(batch)


@pytest.mark.slow
def test_each_flies_as_on_the_diagram(engine):
    """Commands that come and go, so that places are held, wind, gusts, pushes and a weak rotor.

    But for turbulence, which the diagram draws once a control period, not at each step.
    """
    flights = [
        ([2.0, 0.0, 0.4], 0.3, {"wind_x": 3.0}),
        ([-1.0, 1.5, 0.0], 0.0, {"rotor_2": 0.7}),
        ([0.0, 0.0, 0.0], 0.4, {"kp_velocity_x": 3.0}),
    ]
    batch = Batch(3, seed=5)
    sessions = []
    for k, (velocity, yaw_rate, settings) in enumerate(flights):
        scenario = Scenario()
        scenario.sensors.seed = 5 + k
        session = Session(scenario)
        for name, value in settings.items():
            session.set(name, value)
            batch.parameters[name][k] = value
        session.tick(0.25)
        session.command(velocity, yaw_rate)
        session.tick(0.75)
        session.push([0.0, 3.0, 1.0], [0.1, 0.0, 0.0], 0.2, [0.03, 0.0, 0.0])
        session.gust([1.0, 0.0, 0.5], 0.5)
        session.tick(0.5)
        session.command([0.0, 0.0, 0.0], 0.0)
        session.tick(1.5)
        sessions.append(session)
    batch.step(32)
    batch.setpoint.velocity[:] = [each[0] for each in flights]
    batch.setpoint.yaw_rate[:] = [each[1] for each in flights]
    batch.step(96)
    batch.push(force=[0.0, 3.0, 1.0], point=[0.1, 0.0, 0.0], duration=0.2, torque=[0.03, 0, 0])
    batch.gust(velocity=[1.0, 0.0, 0.5], duration=0.5)
    batch.step(64)
    batch.setpoint.velocity[:] = batch.setpoint.yaw_rate[:] = 0.0
    batch.step(192)
    for k, session in enumerate(sessions):
        assert batch.state[k] == pytest.approx(session.state(), abs=CLOSE)
        recording = session.recording()
        assert batch.rotor_speeds[k] == pytest.approx(recording.rotor_speeds[-1], abs=1e3 * CLOSE)
        assert batch.mode[k] == recording.mode[-1]
    first = sessions[0]
    first.go_to([1.0, -1.0, 2.0])
    first.tick(1.0)
    batch.setpoint.position[0], batch.setpoint.follow[0] = (1.0, -1.0, 2.0), 1.0
    batch.step(128)
    assert batch.state[0] == pytest.approx(first.state(), abs=CLOSE)


def lively(batch: Batch) -> None:
    batch.parameters["turbulence"][:] = 5.0
    batch.setpoint.velocity[:, 0] = 1.0


def test_a_reset_leaves_the_others_and_begins_anew_to_the_bit():
    """At a period at which neither flight mode nor slow parts of laws are due."""
    batch, other, new = Batch(40, seed=1), Batch(40, seed=1), Batch(40, seed=1)
    for each in (batch, other, new):
        lively(each)
    again = np.zeros(40, dtype=bool)
    again[[3, 17, 39]] = True
    for each in (batch, other):
        each.step(37)
    batch.reset(again)
    assert (batch.time[again] == 0.0).all() and (batch.setpoint.velocity[again] == 0.0).all()
    batch.setpoint.velocity[:, 0] = 1.0
    for each in (batch, other, new):
        each.step(50)
    assert np.array_equal(batch.state[~again], other.state[~again])
    assert np.array_equal(batch.state[again], new.state[again])
    assert np.array_equal(batch.rotor_speeds[again], new.rotor_speeds[again])
    batch.reset([3], seeds=[2])  # as number 1 has it
    batch.reset(1)
    batch.setpoint.velocity[:, 0] = 1.0
    batch.step(20)
    assert np.array_equal(batch.state[3], batch.state[1])
    assert not np.array_equal(batch.state[3], batch.state[17])


def test_a_flight_alone_is_the_one_among_a_thousand_and_threads_do_not_matter():
    many = Batch(1024, seed=7, threads=2)
    lively(many)
    many.step(30)
    for k in (0, 16, 1023):
        one = Batch(1, seed=7 + k, threads=1)
        lively(one)
        one.step(30)
        assert np.array_equal(one.state[0], many.state[k])
    assert len(np.unique(many.state[:, 4])) == 1024


def test_rotors_may_be_commanded(tmp_path):
    """As on a diagram that plays the same thrusts."""
    config, count = VehicleConfig(variation=Variation(mass=1.02)), 32
    batch = Batch(2, config, actions="rotors")
    batch.parameters["drag_area"][:] = calm_air(batch.vehicle).drag_area  # gains round it
    constants = np.array([rotor.motor_constant for rotor in batch.vehicle.rotors])
    hover = constants * np.array(batch.vehicle.hover_speeds) ** 2
    thrusts = hover * np.random.default_rng(0).uniform(0.8, 1.2, (count, 4))
    thrusts[0] = hover  # in which it begins
    times = [k / 128 for k in range(count)]
    table = tmp_path / "thrusts.csv"
    lines = [
        ",".join(map(repr, [time, *row])) for time, row in zip(times, thrusts.tolist(), strict=True)
    ]
    table.write_text("\n".join(lines), encoding="utf-8")
    start = ScenarioStart(position=[0.0, 0.0, 1.5])
    flown = fly_open_loop(Scenario(vehicle=config, start=start, duration=count / 128), table)
    for row in thrusts:
        batch.rotor_commands[:] = np.sqrt(row / constants)
        batch.step()
    for mine, theirs in (
        (batch.attitude / np.linalg.norm(batch.attitude, axis=1, keepdims=True), flown.q_WB),
        (batch.position, flown.p_WB),
        (batch.angular_velocity, flown.w_WB),
        (batch.velocity, flown.v_WB),
    ):
        assert mine[1] == pytest.approx(theirs[-1], abs=CLOSE)
    assert np.abs(flown.w_WB[-1]).max() > 0.1


@pytest.mark.slow  # it compiles for fifteen seconds
def test_a_wrench_is_allocated():
    """Compare a wrench with the rotor commands that numpy's pseudo-inverse makes of it."""
    by_wrench, by_rotors = (Batch(3, actions=actions) for actions in ("wrench", "rotors"))
    vehicle = by_wrench.vehicle
    assert by_wrench.wrench[0] == pytest.approx([vehicle.mass * GRAVITY, 0, 0, 0], rel=1e-3)
    assert by_rotors.rotor_commands == pytest.approx(np.tile(vehicle.hover_speeds, (3, 1)))
    by_wrench.wrench[1] += [0.5, 0.02, -0.01, 0.005]
    effects = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[2:]
    thrusts = by_wrench.wrench @ np.linalg.pinv(effects).T
    by_rotors.rotor_commands[:] = np.sqrt(thrusts / [r.motor_constant for r in vehicle.rotors])
    for each in (by_wrench, by_rotors):
        each.step(32)
    assert by_wrench.state == pytest.approx(by_rotors.state, abs=1e-9)
    assert abs(by_wrench.velocity[1]).max() > 0.05
    assert abs(by_wrench.velocity[0]).max() < 1e-6


def test_one_that_is_lost_stands_still_and_the_others_fly_on():
    batch, other = Batch(20), Batch(20)
    batch.setpoint.velocity[4, 0] = np.nan
    batch.state[5, 6] = 0.3  # a drop into the ground
    batch.velocity[5, 2] = -20.0
    for each in (batch, other):
        each.step(20)
    lost = np.isin(np.arange(20), [4, 5])
    assert np.array_equal(batch.lost, lost)
    assert np.array_equal(batch.state[4], batch.starts[4])
    assert batch.position[5, 2] < batch.vehicle.ground_clearance
    assert np.array_equal(batch.state[~lost], other.state[~lost])
    before = batch.state[lost].copy()
    batch.setpoint.velocity[:] = 0.0
    for each in (batch, other):
        each.step(3)
    assert np.array_equal(batch.state[lost], before)
    batch.reset(lost)
    other.reset(lost)
    for each in (batch, other):
        each.step(20)
    assert not batch.lost.any()
    assert np.array_equal(batch.state, other.state)


@pytest.mark.slow
def test_a_law_of_the_users_own_flies_and_one_that_designs_does_so_for_each(tmp_path):
    source = Path(load_controller("pd").file).read_text(encoding="utf-8")
    own = tmp_path / "own.py"
    own.write_text(source, encoding="utf-8")
    one, other = Batch(3, controller=str(own)), Batch(3)
    for name, values in other.parameters.items():
        one.parameters[name][:] = values  # the vehicle's, for which only shipped laws have a rule
    for each in (one, other):
        lively(each)
        each.step(20)
    assert np.array_equal(one.state, other.state)
    name = "q_level_velocity"
    changed, plain = (Batch(2, controller="lqi") for _ in range(2))
    own = plain.parameters[name][0]
    changed.parameters[name][1] = 1.3 * own
    new = Batch(2, controller="lqi", parameters={name: [own, 1.3 * own]})
    for each in (changed, plain, new):
        lively(each)
        each.step(40)
    assert np.array_equal(changed.state, new.state)
    assert np.array_equal(changed.state[0], plain.state[0])
    assert not np.array_equal(changed.state[1], plain.state[1])


def test_what_makes_no_batch_is_said(case):
    batch = Batch(4)
    short = Variation(), Variation()
    table = [
        (lambda: Batch(0), "count of a batch is 0"),
        (lambda: Batch(2.5), "count of a batch is 2.5"),
        (lambda: Batch(4, seed=-1), "seed of a batch is -1"),
        (lambda: Batch(4, "no_drone"), "no_drone"),
        (lambda: Batch(4, controller="no_law"), "no_law"),
        (lambda: Batch(4, actions="thrust"), "thrust.*wrench"),
        (lambda: Batch(4, parameters={"kp": 1.0}), "kp"),
        (lambda: Batch(4, parameters={"kp_roll": [1.0, 2.0]}), "kp_roll.*4 of them"),
        (lambda: Batch(4, variations=short), "2 variations for 4"),
        (lambda: Batch(4, start=ScenarioStart(mode="off")), "in the air alone"),
        (lambda: batch.step(-1), "periods of a batch is -1"),
        (lambda: batch.reset([4]), "batch of 4"),
        (lambda: batch.reset([True]), "batch of 4"),
        (lambda: batch.reset([1, 2], seeds=[1]), "1 seeds for 2 flights"),
        (lambda: batch.reset([1, 2], seeds=1), "1 seeds for 2 flights"),
        (lambda: Batch(4, parameters={"kp_roll": math.nan}), "kp_roll.*finite"),
        (lambda: Batch(4, parameters=[1.0]), "values by name"),
        (lambda: batch.push(force=[1.0, 0.0]), "push is .*3 finite"),
        (lambda: batch.push(force=[math.nan, 0.0, 0.0]), "push is .*3 finite"),
        (lambda: batch.push(force=[1.0, 0.0, 0.0], duration=-1.0), "push_duration.* -1"),
        (lambda: batch.gust(velocity=[1.0, 0.0, math.inf]), "gust is .*3 finite"),
        (lambda: batch.parameters["wind_u"], "'wind_u'.*wind_x"),
        (lambda: setattr(batch, "state", np.zeros((3, 13))), r"state of .*array \(4, 13\)"),
        (lambda: setattr(batch.setpoint, "velocity", "up"), "velocity of a batch is 'up'"),
        (lambda: setattr(batch, "setpoint", np.zeros(4)), "setpoint of a batch cannot be set"),
        (lambda: setattr(batch, "time", 0.0), "time of a batch cannot be set"),
    ]
    for do, said in table:
        with case(said), pytest.raises(WorkbenchError, match=said):
            do()


def test_to_set_an_array_writes_into_it():
    batch = Batch(3)
    speeds = batch.velocity, batch.setpoint.velocity, batch.parameters["wind_x"]
    batch.velocity = [1.0, 0.0, 0.0]
    batch.setpoint.velocity += 2.0
    batch.parameters["wind_x"] = [1.0, 2.0, 3.0]
    for array, column in zip(
        speeds, ([1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [1.0, 2.0, 3.0]), strict=True
    ):
        assert array.reshape(3, -1)[:, 0].tolist() == column
    assert batch.state[:, 10].tolist() == [1.0, 1.0, 1.0]
