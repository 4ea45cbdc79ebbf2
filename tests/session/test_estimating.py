"""Flights on an estimate: equal to the bit however they are cut, from a checkpoint on, replayed."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.sensors import Imu, Noise
from workbench.plant.variation import Variation
from workbench.scenario.configured import warn_of_gyro_bias
from workbench.scenario.scenario import Action, Scenario, SensorsConfig, VehicleConfig
from workbench.session.session import Session

MOVES = [
    Action(at=0.5, velocity=[1.0, 0.5, 0.2], yaw_rate=0.3),
    Action(at=1.0, set={"gps_fault": 3}),
]


def scenario(estimator="ekf", **changes):
    vehicle = VehicleConfig(args={"gps_noise": "0.3"}, variation=Variation(sensing_delay=0.003))
    return Scenario(estimator=estimator, vehicle=vehicle, script=MOVES, duration=100.0, **changes)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_slices_of_any_size_make_the_same_flight(estimator):
    one, other = Session(scenario(estimator)), Session(scenario(estimator))
    one.tick(2.0)
    for _ in range(200):
        other.tick(0.01)
    assert one.state().tobytes() == other.state().tobytes()


@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_it_goes_on_from_a_checkpoint_to_the_bit(estimator):
    session = Session(scenario(estimator))
    session.tick(1.3)
    checkpoint = session.checkpoint()
    session.tick(1.0)
    other = Session(scenario(estimator))
    other.begin_from(checkpoint)
    other.tick(1.0)
    assert other.state().tobytes() == session.state().tobytes()


def test_another_seed_is_another_flight():
    flown = {}
    for seed in (0, 1):
        session = Session(scenario(sensors=SensorsConfig(seed=seed)))
        session.tick(1.0)
        flown[seed] = session.state()
    assert np.abs(flown[0] - flown[1]).max() > 1e-4


def test_settings_of_the_estimator_that_flies_are_live():
    session = Session(scenario())
    session.set("ekf_gps_position", 5.0)
    assert session.get("ekf_gps_position") == 5.0
    assert "complementary_kp" not in session.parameters()
    with pytest.raises(WorkbenchError, match="--estimator complementary"):
        session.set("complementary_kp", 1.0)


def test_a_drone_without_imu_cannot_estimate():
    drones = Path(__file__).parents[1] / "drones"
    vehicle = VehicleConfig(model=str(drones / "tilted_quad.urdf.xacro"))
    with pytest.raises(WorkbenchError, match="has no IMU"):
        Session(Scenario(estimator="ekf", vehicle=vehicle))
    with pytest.raises(WorkbenchError, match="unknown estimator .kalman.: known are"):
        Session(Scenario(estimator="kalman"))


@pytest.mark.parametrize(
    ("estimator", "bias", "settings", "said"),
    [
        ("complementary", 0.05, {}, "by up to 5.7° about each axis, for some 25 s: let the drone"),
        ("complementary", 0.05, {"complementary_ki": 0.0}, "for good, as complementary_ki is 0"),
        ("complementary", 0.005, {}, ""),
        ("ekf", 0.05, {}, ""),
    ],
)
def test_a_gyro_bias_that_tilts_the_complementary_filter_is_told(
    vehicle, caplog, estimator, bias, settings, said
):
    biased = tuple(
        dataclasses.replace(sensor, angular_velocity=(Noise(bias_mean=bias),) * 3)
        if isinstance(sensor, Imu)
        else sensor
        for sensor in vehicle.sensors
    )
    values = {"complementary_kp": 0.5, "complementary_ki": 0.02} | settings
    with caplog.at_level("INFO", "workbench"):
        warn_of_gyro_bias(
            dataclasses.replace(vehicle, sensors=biased), Scenario(estimator=estimator), values
        )
    assert said in caplog.text
    assert bool(caplog.text) == bool(said)
