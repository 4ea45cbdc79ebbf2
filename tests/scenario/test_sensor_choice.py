"""Oracle: periods in physics steps, counted by hand."""

import argparse
import dataclasses
import logging

import pytest

from workbench.commands.chosen_vehicle import with_model
from workbench.common.errors import WorkbenchError
from workbench.live.choice import Choice
from workbench.plant.sensors import CORE_SENSORS, NO_NOISE, Noise
from workbench.scenario.scenario import Rates, Scenario, SensorsConfig
from workbench.scenario.scenario_file import load_scenario
from workbench.scenario.sensor_choice import choose_sensors, log_absent_sensors, without_noise

KINDS = tuple(each.kind for each in CORE_SENSORS)
"""The shipped drone has one of each."""
STEP = 1 / 1024
NAMES = ["lidar", "gps", "camera", "imu", "barometer", "range_finder", "magnetometer"]
"""Of the vehicle's sensors, in its order."""


@pytest.fixture
def choose(vehicle):
    """Return a function of what a scenario says under `sensors`."""

    def chosen(vehicle=vehicle, physics_step=STEP, **config):
        rates = Rates(physics_step=physics_step)
        return choose_sensors(vehicle, Scenario(rates=rates, sensors=SensorsConfig(**config)))

    return chosen


def names(choices) -> list[str]:
    return [choice.sensor.name for choice in choices]


def test_the_vehicle_has_a_sensor_of_each_kind(vehicle):
    assert [sensor.name for sensor in vehicle.sensors] == NAMES
    assert {sensor.kind for sensor in vehicle.sensors} == set(KINDS)


@pytest.mark.parametrize(
    ("use", "chosen"),
    [
        ([], []),
        (["imu"], ["imu"]),
        (["depth_camera"], ["camera"]),  # by kind
        (["camera"], ["camera"]),  # by name
        (["camera", "depth_camera"], ["camera"]),  # once
        (["range_finder", "imu", "gps"], ["gps", "imu", "range_finder"]),  # in the vehicle's order
        (["all"], NAMES),
        (["all", "imu"], NAMES),
    ],
)
def test_names_kinds_and_all_choose(choose, use, chosen):
    assert names(choose(use=use)) == chosen


def test_a_kind_chooses_every_sensor_of_it(choose, vehicle):
    (lidar,) = (sensor for sensor in vehicle.sensors if sensor.kind == "lidar")
    rear = dataclasses.replace(lidar, name="rear")
    two = dataclasses.replace(vehicle, sensors=(*vehicle.sensors, rear))
    assert names(choose(two, use=["lidar"])) == ["lidar", "rear"]
    assert names(choose(two, use=["rear"])) == ["rear"]
    front, back = choose(two, use=["lidar"], rates={"lidar": 4.0, "rear": 2.0})
    assert (front.asked_rate, back.asked_rate) == (4.0, 2.0)


@pytest.mark.parametrize("rate", [200.0, 10.0, 30.0, 1024.0, 700.0, 0.01])
def test_a_sensor_keeps_its_rate(choose, rate):
    (choice,) = choose(use=["imu"], rates={"imu": rate})
    assert choice.asked_rate == rate
    assert choice.period == 1.0 / rate


def test_a_described_rate_beyond_the_physics_is_that_of_the_physics(choose, vehicle):
    quick = dataclasses.replace(
        vehicle, sensors=(dataclasses.replace(vehicle.sensors[0], rate=5e3),)
    )
    (choice,) = choose(quick, use=["all"])
    assert choice.period == STEP
    (choice,) = choose(quick, use=["all"], physics_step=0.0005)
    assert choice.period == 0.0005


def test_a_name_goes_before_its_kind_and_both_before_the_description(choose):
    config = {"use": ["all"], "rates": {"depth_camera": 7.0, "camera": 8.0, "gps": 5.0}}
    config["latency"] = {"depth_camera": 0.1, "camera": 0.2, "lidar": 0.05}
    chosen = {choice.sensor.name: choice for choice in choose(**config)}
    assert {name: choice.asked_rate for name, choice in chosen.items()} == {
        "lidar": 10.0,
        "gps": 5.0,
        "camera": 8.0,
        "imu": 200.0,
        "barometer": 50.0,
        "range_finder": 50.0,
        "magnetometer": 50.0,
    }
    latencies = {name: choice.latency for name, choice in chosen.items() if choice.latency}
    assert latencies == {"camera": 0.2, "lidar": 0.05}


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_description_leaves_open_is_usual(choose, vehicle, kind):
    (sensor,) = (sensor for sensor in vehicle.sensors if sensor.kind == kind)
    silent = dataclasses.replace(vehicle, sensors=(dataclasses.replace(sensor, rate=0.0),))
    (choice,) = choose(silent, use=[kind])
    assert choice.asked_rate == choice.sensor.usual_rate > 0.0


def test_a_rate_of_almost_nothing_is_refused_where_it_is_used(choose, vehicle):
    slow = dataclasses.replace(vehicle.sensors[0], rate=1e-9)
    odd = dataclasses.replace(vehicle, sensors=(slow,))
    assert choose(odd, use=[]) == ()
    with pytest.raises(WorkbenchError, match=r"'lidar' takes 1e-09 samples .*sensors\.rates"):
        choose(odd, use=["all"])
    (choice,) = choose(odd, use=["all"], rates={"lidar": 5.0})
    assert choice.asked_rate == 5.0


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"use": ["lidr"]}, ("sensors.use", "'lidr'", "did you mean 'lidar'")),
        ({"use": ["imu", "radar"]}, ("sensors.use", "'radar'", "depth_camera", "all")),
        ({"use": [""]}, ("sensors.use", "''")),
        ({"rates": {"gsp": 5.0}}, ("sensors.rates", "'gsp'", "'gps'")),
        ({"latency": {"imus": 0.1}}, ("sensors.latency", "'imus'", "'imu'")),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(choose, config, words):
    with pytest.raises(WorkbenchError) as caught:
        choose(**config)
    said = str(caught.value)
    assert not [word for word in words if word not in said]
    assert "\n" not in said


@pytest.mark.parametrize(
    "config", [{"use": ["imu"]}, {"use": ["all", "imu"]}, {"rates": {"front": 5.0}}]
)
def test_a_vehicle_without_sensors_says_so(choose, vehicle, config):
    blind = dataclasses.replace(vehicle, sensors=())
    with pytest.raises(WorkbenchError, match=r"dh_drone has no sensors: add some to .*drone\.urdf"):
        choose(blind, **config)
    assert choose(blind) == ()
    assert choose(blind, use=["all"]) == ()  # all that it has


def test_a_rate_of_a_kind_that_the_vehicle_lacks_is_told_and_does_nothing(choose, vehicle, caplog):
    imu = tuple(each for each in vehicle.sensors if each.kind == "imu")
    plain = dataclasses.replace(vehicle, sensors=imu)
    given = {"rates": {"imu": 50.0, "gps": 5.0}, "latency": {"lidar": 0.1}}
    (choice,) = choose(plain, use=["all"], **given)
    assert (choice.sensor.kind, choice.asked_rate) == ("imu", 50.0)
    with caplog.at_level(logging.INFO, "workbench"):
        log_absent_sensors(plain, SensorsConfig(**given))
    assert [record.getMessage() for record in caplog.records] == [
        "sensors.rates of gps does nothing: dh_drone has no such sensor",
        "sensors.latency of lidar does nothing: dh_drone has no such sensor",
    ]


def test_another_vehicle_has_the_sensors_and_rates_of_kinds_from_app_and_command_alike(
    tmp_path, caplog
):
    """Those of a sensor by its name were of the scenario's own vehicle."""
    path = tmp_path / "own.yaml"
    path.write_text(
        "sensors: {use: [imu, front, all], rates: {imu: 50, front: 5}, "
        "latency: {gps: 0.2, front: 0.1}}"
    )
    with caplog.at_level(logging.INFO, "workbench"):
        app = Choice(str(path), model="tricopter").load()
    assert [record.getMessage().partition(" is left out")[0] for record in caplog.records] == [
        "sensors.use of front",
        "sensors.rates of front",
        "sensors.latency of front",
    ]
    asked = argparse.Namespace(model="tricopter", arg=(), package=(), rotors="")
    command = with_model(load_scenario(path), asked)
    assert app.sensors == command.sensors
    assert app.sensors.use == ["imu", "all"]
    assert (app.sensors.rates, app.sensors.latency) == ({"imu": 50}, {"gps": 0.2})
    assert Choice(str(path)).load().sensors.rates == {"imu": 50, "front": 5}


def noises(sensor) -> list[Noise]:
    values = [getattr(sensor, field.name) for field in dataclasses.fields(sensor)]
    flat = [part for value in values for part in (value if isinstance(value, tuple) else (value,))]
    return [part for part in flat if isinstance(part, Noise)]


def loud(sensor):
    """Return a sensor with noise wherever it may have some."""
    noise = Noise(mean=1.0, stddev=2.0, bias_stddev=3.0)
    new = {}
    for field in dataclasses.fields(sensor):
        value = getattr(sensor, field.name)
        if isinstance(value, Noise):
            new[field.name] = noise
        elif isinstance(value, tuple) and value and isinstance(value[0], Noise):
            new[field.name] = (noise,) * len(value)
    return dataclasses.replace(sensor, **new)


def test_without_noise_nothing_else_is_lost(choose, vehicle):
    everything = dataclasses.replace(vehicle, sensors=tuple(map(loud, vehicle.sensors)))
    counts = {"imu": 6, "gps": 4, "magnetometer": 3}
    for choice, sensor in zip(
        choose(everything, use=["all"], noise=False), everything.sensors, strict=True
    ):
        assert noises(choice.sensor) == [NO_NOISE] * counts.get(sensor.kind, 1)
        assert loud(choice.sensor) == sensor
    assert [choice.sensor for choice in choose(everything, use=["all"])] == [*everything.sensors]
    assert without_noise(without_noise(sensor)) == without_noise(sensor)


def test_more_waiting_samples_than_memory_should_hold_are_refused(vehicle):
    config = SensorsConfig(use=["lidar"], rates={"lidar": 1000.0}, latency={"lidar": 10.0})
    with pytest.raises(WorkbenchError, match="'lidar': 10000 samples would wait .* less latency"):
        choose_sensors(vehicle, Scenario(sensors=config))


def test_a_rate_beyond_the_physics_is_refused(vehicle):
    config = SensorsConfig(use=["imu"], rates={"imu": 5000.0})
    with pytest.raises(WorkbenchError, match="'imu' is asked for 5000 .* allows 1024"):
        choose_sensors(vehicle, Scenario(sensors=config))
