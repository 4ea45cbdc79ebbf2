"""Oracle: the same flights on Drake's diagram, saturated and thrown ones among them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.installed import readable
from workbench.control.installed_laws import installed_laws
from workbench.design.rollout import agreement as module
from workbench.design.rollout.agreement import (
    TRIAL_CEILING_M,
    AgreementTrial,
    agreement,
    random_trials,
)
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.gains.gain_choice import flight_gains
from workbench.plant.sensors import Imu
from workbench.plant.variation import Variation
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Rates, Scenario, ScenarioStart, VehicleConfig
from workbench.setup import make_setup

TESTS = Path(__file__).resolve().parents[2]
DRONES, SHARED = TESTS / "drones", TESTS.parent / "../shared/models"
PUBLISHED = {
    "rotors_description/urdf/hummingbird.xacro": {"namespace": "hummingbird"},
    "gym_pybullet_drones/cf2x.urdf": {},
    "px4_gazebo_models/x500/model.sdf": {},
}
EFFECTS = [TESTS / "oracles" / name for name in ("uneven_quad.urdf", "effects.rotors.yaml")]
CLOSE = 1e-9
"""[m, rad, m/s, rad/s]"""
DURATION = 1.25
"""Of a trial: gust and push are over by then [s]."""
AIR = {"wind_x": 3.0, "wind_y": -2.0, "wind_z": 0.5, "drag_area": 0.03, "air_density": 1.0}
TURBULENCE = {"wind_x": 3.0, "wind_y": 1.0, "turbulence": 8.0}
GUST = {"gust_x": 5.0, "gust_start": 0.3, "gust_duration": 0.9}
PUSH = {
    "push_y": 3.0,
    "push_at_z": 0.1,
    "push_torque_x": 0.1,
    "push_torque_y": -0.2,
    "push_torque_z": 0.02,
    "push_start": 0.3005,
}
GYRO = {"gyro_lowpass": 40.0, "gyro_notch": 120.0, "gyro_rate": 300.0, "derivative_lowpass": 10.0}
SETPOINT = {"gyro_lowpass": 25.0, "gyro_lowpass_order": 1.0, "setpoint_lowpass": 3.0}
PAYLOAD = {
    "payload_mass": 0.3,
    "payload_x": 0.06,
    "payload_y": -0.03,
    "payload_z": -0.1,
    "payload_size_x": 0.2,
    "known_payload_mass": 0.2,
}
LATE = Variation(sensing_delay=0.003)


def fly(scenario: Scenario, count=2, seed=9, settings=None, duration=DURATION):
    """Fly random trials with some settings in both ways."""
    vehicle = configured_vehicle(scenario.vehicle)
    law = flown_controller(scenario)
    own = flight_gains(vehicle, scenario.vehicle.gains, controller=law)
    trials = [
        replace(trial, gains={**trial.gains, **(settings or {})})
        for trial in random_trials(vehicle, own, count, seed, law)
    ]
    return agreement(scenario, trials, duration=duration)


def assert_agrees(found):
    for name in ("position", "attitude", "velocity", "angular_velocity"):
        assert getattr(found, name).max() < CLOSE, name


def test_sets_of_gains_fly_as_on_the_diagram():
    found = fly(Scenario(), 8, 0)
    assert_agrees(found)
    assert found.saturated.mean() > 0.4
    assert found.lost.mean() < 0.2


@pytest.mark.slow
def test_so_do_many_for_long():
    assert_agrees(fly(Scenario(), 20, 1, duration=5.0))


@pytest.mark.parametrize(
    ("settings", "variation"),
    [
        (AIR | GUST | PUSH, Variation()),
        (TURBULENCE, Variation()),
        (GYRO, LATE),
        (SETPOINT, LATE),
        ({"command_steps": 300.0, "rotor_2": 0.9}, Variation()),
        ({"rotor_3": 0.0}, Variation()),
        (PAYLOAD, Variation(mass=1.2, inertia=0.7, rotor_lag=1.5)),
        ({}, Variation(control_delay=1, sensing_delay=0.003, command_delay=0.004)),
        ({}, Variation(command_delay=0.011)),
    ],
    ids=["air", "turbulence", "gyro", "setpoint", "commands", "lost", "payload", "late", "later"],
)
def test_so_do_drones_in_all_that_is_around_them(settings, variation):
    config = VehicleConfig(variation=variation)
    assert_agrees(fly(Scenario(vehicle=config), settings=settings))


@pytest.mark.parametrize(
    "rates",
    [
        Rates(physics_step=1 / 2048, control_period=1 / 256),
        Rates(physics_step=0.001, control_period=0.006, mode_period=0.1),
    ],
    ids=str,
)
def test_so_do_drones_at_other_rates(rates):
    """At the second one the flight mode is updated between control updates."""
    assert_agrees(fly(Scenario(rates=rates)))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in installed_laws() if name != "pd"])
def test_so_do_drones_with_other_laws(name):
    """With gains of their own: with others some swing without end, and rounding grows."""
    scenario = Scenario(controller=name)
    vehicle, law = configured_vehicle(scenario.vehicle), flown_controller(scenario)
    own = flight_gains(vehicle, controller=law)
    thrown = random_trials(vehicle, own, 2, 3, law)
    trials = [replace(each, gains={"max_height": TRIAL_CEILING_M}) for each in thrown]
    assert_agrees(agreement(scenario, trials, duration=5.0))


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "complementary", str(TESTS / "estimation/lag.py")])
def test_so_do_drones_on_an_estimate(estimator):
    """With all noises, filters, a gyro of its own rate, and late sensing, in any company."""
    config = VehicleConfig(variation=Variation(sensing_delay=0.003, mass=1.1))
    scenario = Scenario(vehicle=config, estimator=estimator)
    filters = {"gyro_lowpass": 60.0, "gyro_rate": 300.0, "accel_lowpass": 40.0}
    gate = {"ekf_gate": 3.0} if estimator == "ekf" else {}
    assert_agrees(fly(scenario, 2, 5, filters | gate | {"accel_lowpass_order": 1.0}, 3.0))
    assert_agrees(fly(scenario, 2, 5, TURBULENCE, 3.0))
    setup, alone = make_setup(scenario).varied(Variation()), 20
    vehicle, one = setup.vehicle, RolloutEngine.of(setup, threads=1)
    gains = [{"kp_roll": 100.0 + k} for k in range(alone)]
    starts = np.tile(start_state(vehicle, ScenarioStart(position=[0.0, 0.0, 10.0])), (alone, 1))
    commands, seeds = np.tile([2.0, 0.0, 0.0, 0.0], (alone, 1)), list(range(alone))
    whole, later = (
        one.fly_from(gains[k:], starts[k:], commands[k:], duration=0.1, seeds=seeds[k:]).states
        for k in (0, 3)
    )
    assert np.array_equal(later, whole[3:])
    assert np.abs(np.diff(whole, axis=0)).max(axis=(1, 2)).min() > 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "args"), [("tilted_quad", {"forward": "5"}), ("coaxial_x8", {}), ("h_quad", {})]
)
def test_so_do_drones_of_other_layouts(name, args):
    config = VehicleConfig(str(DRONES / f"{name}.urdf.xacro"), args)
    assert_agrees(fly(Scenario(vehicle=config), 2))
    assert_agrees(fly(Scenario(vehicle=config), settings=PAYLOAD))


@pytest.mark.parametrize("compensation", [pytest.param(0.0, marks=pytest.mark.slow), 0.7])
def test_so_does_a_drone_with_all_effects(tmp_path, compensation):
    """From 50 m, and near the ground; the battery empties, and what it supplies falls."""
    gains = tmp_path / "gains.yaml"
    gains.write_text(f"gains: {{sag_compensation: {compensation}}}\n", encoding="utf-8")
    config = VehicleConfig(str(EFFECTS[0]), rotors=str(EFFECTS[1]), gains=str(gains))
    scenario = Scenario(vehicle=config)
    assert_agrees(fly(scenario, 4))
    low = [
        AgreementTrial(
            {"max_height": 100.0}, ScenarioStart(position=[0.0, 0.0, height]), (*level, 0.3)
        )
        for height, *level in ((3.0, 1.0, 0.5, 0.2), (6.0, -4.0, 2.0, -0.5), (2.0, 0.0, 0.0, 0.0))
    ]
    found = agreement(scenario, low, duration=DURATION)
    assert not found.lost.any()
    assert_agrees(found)


@pytest.mark.slow
@pytest.mark.parametrize("path", readable(PUBLISHED))
def test_so_do_the_published_vehicles(path):
    if not SHARED.is_dir():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    config = VehicleConfig(str(SHARED / path), PUBLISHED[path])
    assert_agrees(fly(Scenario(vehicle=config), 4, duration=5.0))
    if any(isinstance(each, Imu) for each in configured_vehicle(config).sensors):
        assert_agrees(fly(Scenario(vehicle=config, estimator="ekf"), 2, duration=5.0))


def test_a_difference_would_be_seen(monkeypatch):
    """An engine that takes the drone for a millionth heavier."""
    trial = AgreementTrial(
        {"max_height": 100.0}, ScenarioStart(position=[0.0, 0.0, 50.0]), (6.0, 0.0, 0.0, 0.0)
    )
    assert_agrees(agreement(Scenario(), [trial], duration=1.0))
    heavier = Variation(mass=1.0 + 1e-6)
    monkeypatch.setattr(
        module.RolloutEngine,
        "of",
        lambda setup: RolloutEngine(setup.vehicle, variation=heavier, own=setup.values),
    )
    assert agreement(Scenario(), [trial], duration=1.0).velocity[0] > 100.0 * CLOSE


def test_trials_follow_from_their_seed_and_half_of_them_are_thrown():
    vehicle = configured_vehicle(VehicleConfig())
    own = flight_gains(vehicle)
    trials = random_trials(vehicle, own, 6, 1)
    assert trials == random_trials(vehicle, own, 6, 1)
    assert trials != random_trials(vehicle, own, 6, 2)
    thrown = [any(each.start.angular_velocity) for each in trials]
    assert thrown == [False, True] * 3
