"""Compiled flights beside those of the full diagram, saturated and thrown ones among them.

They are integrated otherwise: in steps of 1/1024 s of second order, the diagram by `runge_kutta5`.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.design.rollout import agreement as module
from workbench.design.rollout.agreement import Trial, agreement, random_trials
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.senses import make_senses
from workbench.gains.gains import flight_gains
from workbench.plant.variation import Variation
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import (
    Scenario,
    SensorsConfig,
    Start,
    VehicleConfig,
    flown_controller,
)

TESTS = Path(__file__).resolve().parents[2]
DRONES, SHARED = TESTS / "drones", TESTS.parent / "../shared/models"
PUBLISHED = {
    "rotors_description/urdf/hummingbird.xacro": {"namespace": "hummingbird"},
    "gym_pybullet_drones/cf2x.urdf": {},
    "px4_gazebo_models/x500/model.sdf": {},
}
EFFECTS = [TESTS / "oracles" / name for name in ("uneven_quad.urdf", "effects.rotors.yaml")]
VELOCITY, ANGULAR_VELOCITY = 1e-2, 5e-2
"""Asked of an engine whose winners are then flown on the diagram [m/s, rad/s]."""
USUAL = 3e-3
"""Most of flights that saturate no rotor, and the largest median [m/s]."""
THROWN = 6e-2
"""Most of flights that saturate on an estimate, which differs then, too [m/s]."""
DURATION = 1.5
"""Of a trial: what is thrown has come to rest by then [s]."""
TILTED = str(DRONES / "tilted_quad.urdf.xacro")


def compare(config: VehicleConfig, count: int, seed: int):
    vehicle = configured_vehicle(config)
    trials = random_trials(vehicle, flight_gains(vehicle), count, seed)
    return agreement(Scenario(vehicle=config), trials, duration=DURATION)


def assert_agrees(found):
    assert found.velocity.max() < VELOCITY
    assert found.angular_velocity.max() < ANGULAR_VELOCITY
    assert np.median(found.velocity) < USUAL
    assert found.velocity[~found.saturated].max(initial=0.0) < USUAL


@pytest.mark.parametrize(
    ("count", "seed"),
    [(12, 0), *(pytest.param(50, seed, marks=pytest.mark.slow) for seed in range(4))],
)
def test_sets_of_gains_fly_as_on_the_diagram(count, seed):
    found = compare(VehicleConfig(), count, seed)
    assert_agrees(found)
    assert found.saturated.sum() > 0.4 * count
    assert found.lost.sum() < 0.2 * count


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "args"),
    [
        ("tilted_quad", {"forward": "5"}),
        *(pytest.param(name, {}, marks=pytest.mark.slow) for name in ("coaxial_x8", "h_quad")),
    ],
)
def test_so_do_drones_of_other_layouts(name, args):
    assert_agrees(compare(VehicleConfig(str(DRONES / f"{name}.urdf.xacro"), args), 10, 9))


@pytest.mark.parametrize(
    "around",
    [
        {"gyro_lowpass": 40.0, "gyro_notch": 120.0, "gyro_rate": 300.0, "derivative_lowpass": 10.0},
        {"gyro_lowpass": 25.0, "gyro_lowpass_order": 1.0, "setpoint_lowpass": 3.0},
        {"command_steps": 300.0},
    ],
    ids=["gyro", "setpoint", "commands"],
)
def test_so_do_drones_with_filters(around):
    """Late sensing, too, which sees what the filters gave then."""
    config = VehicleConfig(variation=Variation(sensing_delay=0.003))
    vehicle = configured_vehicle(config)
    plain = random_trials(vehicle, flight_gains(vehicle), 4, 5)
    trials = [replace(trial, gains={**trial.gains, **around}) for trial in plain]
    assert_agrees(agreement(Scenario(vehicle=config), trials, duration=0.5))
    engine = RolloutEngine(vehicle)
    one, other = engine.fly([{}, around], "x", 2.0, duration=1.0).velocity_W
    assert np.abs(one - other).max() > 1e-4


OWN = TESTS / "estimation" / "lag.py"


ESTIMATORS = ("ekf", "complementary", pytest.param(str(OWN), id="own"))


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_so_do_drones_on_an_estimate(estimator):
    assert_flies_on(estimator, 4, 3.0, 20)


@pytest.mark.usefixtures("interpreted_blocks")
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_so_do_drones_on_an_estimate_for_a_tenth_of_a_second_as_python(estimator):
    assert_flies_on(estimator, 3, 0.1, 5)


def assert_flies_on(estimator, count, duration, alone) -> None:
    """Compare flights with all noises, filters, a gyro of its own rate, and late sensing.

    Args:
        estimator: that they fly on.
        count: of flights that are compared with the diagram.
        duration: of each [s].
        alone: so many are flown without the first three of them, too, and are the same.
    """
    config = VehicleConfig(variation=Variation(sensing_delay=0.003, mass=1.1))
    # rates at which compiled flights can sample as well, at whole physics steps
    rates = {"gps": 8.0, "barometer": 64.0, "magnetometer": 64.0, "range_finder": 64.0}
    sensors = SensorsConfig(rates=rates)
    scenario = Scenario(vehicle=config, estimator=estimator, sensors=sensors)
    vehicle = configured_vehicle(config)
    around = {"gyro_lowpass": 60.0, "gyro_rate": 300.0, "accel_lowpass": 40.0}
    around["accel_lowpass_order"] = 1.0
    if estimator == "ekf":
        around["ekf_gate"] = 3.0
    plain = random_trials(vehicle, flight_gains(vehicle), count, 5)
    trials = [
        replace(trial, gains={**trial.gains, **(around if number % 4 < 2 else {})})
        for number, trial in enumerate(plain)
    ]
    found = agreement(scenario, trials, duration=duration)
    assert found.velocity.max() < THROWN
    assert found.velocity[~found.saturated].max(initial=0.0) < USUAL
    senses = make_senses(vehicle, scenario)
    law = flown_controller(scenario)
    one = RolloutEngine(vehicle, controller=law, senses=senses, threads=1)
    gains = [{"kp_roll": 100.0 + k} for k in range(alone)]
    starts = np.tile(start_state(vehicle, Start(position=[0.0, 0.0, 10.0])), (alone, 1))
    commands = np.tile([2.0, 0.0, 0.0, 0.0], (alone, 1))
    seeds = list(range(alone))
    whole, later = (
        one.fly_from(gains[k:], starts[k:], commands[k:], duration=0.1, seeds=seeds[k:]).states
        for k in (0, 3)
    )
    assert np.array_equal(later, whole[3:])
    assert np.abs(np.diff(whole, axis=0)).max(axis=(1, 2)).min() > 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("dh_drone", 0.0),
        (TILTED, 0.3),
        *(
            pytest.param(name, known, marks=pytest.mark.slow)
            for name, known in (("dh_drone", 0.3), (TILTED, 0.0), ("dh_drone", 0.2), (TILTED, 0.2))
        ),
    ],
)
def test_so_do_drones_with_a_payload(name, known):
    """Beside the middle: rotors that lean have another thrust frame for a law that knows."""
    carried = {
        "payload_mass": 0.3,
        "payload_x": 0.06,
        "payload_y": -0.03,
        "payload_z": -0.1,
        "payload_size_x": 0.2,
        "payload_size_z": 0.1,
        "known_payload_mass": known,
    }
    config = VehicleConfig(name)
    vehicle = configured_vehicle(config)
    trials = [
        replace(trial, gains={**trial.gains, **carried})
        for trial in random_trials(vehicle, flight_gains(vehicle), 6, 4)
    ]
    assert_agrees(agreement(Scenario(vehicle=config), trials, duration=DURATION))


@pytest.mark.slow
@pytest.mark.parametrize("compensation", [0.0, pytest.param(0.7, marks=pytest.mark.slow)])
def test_so_does_a_drone_with_all_effects(tmp_path, compensation):
    """From 50 m, and near the ground; the battery empties, and what it supplies falls."""
    gains = tmp_path / "gains.yaml"
    gains.write_text(f"gains: {{sag_compensation: {compensation}}}\n", encoding="utf-8")
    config = VehicleConfig(str(EFFECTS[0]), rotors=str(EFFECTS[1]), gains=str(gains))
    found = compare(config, 6, 9)
    assert_agrees(found)
    low = [
        Trial({"max_height": 100.0}, Start(position=[0.0, 0.0, height]), (*level, 0.3))
        for height, *level in ((3.0, 1.0, 0.5, 0.2), (6.0, -4.0, 2.0, -0.5), (2.0, 0.0, 0.0, 0.0))
    ]
    found = agreement(Scenario(vehicle=config), low, duration=DURATION)
    assert not found.lost.any()
    assert found.velocity.max() < USUAL


@pytest.mark.slow
@pytest.mark.parametrize("path", PUBLISHED)
def test_so_do_the_published_vehicles(path):
    if not SHARED.is_dir():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    assert_agrees(compare(VehicleConfig(str(SHARED / path), PUBLISHED[path]), 20, 9))


def test_a_difference_would_be_seen(monkeypatch):
    """An engine that takes the drone for a hundredth heavier."""
    trial = Trial({"max_height": 100.0}, Start(position=[0.0, 0.0, 50.0]), (6.0, 0.0, 0.0, 0.0))
    assert agreement(Scenario(), [trial], duration=1.0).velocity[0] < USUAL
    monkeypatch.setattr(
        module,
        "RolloutEngine",
        lambda vehicle, *_, own, **_more: RolloutEngine(
            vehicle, variation=Variation(mass=1.01), own=own
        ),
    )
    assert agreement(Scenario(), [trial], duration=1.0).velocity[0] > VELOCITY


def test_trials_follow_from_their_seed_and_half_of_them_are_thrown():
    vehicle = configured_vehicle(VehicleConfig())
    own = flight_gains(vehicle)
    trials = random_trials(vehicle, own, 6, 1)
    assert trials == random_trials(vehicle, own, 6, 1)
    assert trials != random_trials(vehicle, own, 6, 2)
    thrown = [any(each.start.angular_velocity) for each in trials]
    assert thrown == [False, True] * 3
