"""Oracle: the files as written, and the dataclasses that they stand for."""

import dataclasses

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_scenario, list_scenarios
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Gust,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.scenario.scenario_check import check_scenario
from workbench.scenario.scenario_file import load_scenario, save_scenario
from workbench.session.session import Session

TEXT = """title: a test
vehicle:
  model: dh_drone
  args: {mass: '2.0'}
rates:
  control_period: 0.00390625
start:
  mode: "off"
  position: [1, 2, 3]
duration: 5
script:
- at: 1
  request: take_off
  height: 2
- at: 4
  velocity: [1, 0, 0.5]
  yaw_rate: 0.1
  set: {kp_roll: 99}
  gust: {velocity: [3, 0, 0], duration: 2}
  push: {force: [0, 4, 0], point: [0.1, 0, 0]}
figure_eight:
  laps: 3
"""


@pytest.fixture
def write(tmp_path):
    def write_scenario(text: str):
        path = tmp_path / "scenario.yaml"
        path.write_text(text)
        return path

    return write_scenario


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        load_scenario(path)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said


def test_a_file_is_read_and_what_it_leaves_out_is_the_default(write):
    assert load_scenario(write(TEXT)) == Scenario(
        title="a test",
        vehicle=VehicleConfig(model="dh_drone", args={"mass": "2.0"}),
        rates=Rates(control_period=1 / 256),
        start=ScenarioStart(mode="off", position=[1.0, 2.0, 3.0]),
        duration=5.0,
        script=[
            Action(at=1.0, request="take_off", height=2.0),
            Action(
                at=4.0,
                velocity=[1.0, 0.0, 0.5],
                yaw_rate=0.1,
                set={"kp_roll": 99.0},
                gust=Gust(velocity=[3.0, 0.0, 0.0], duration=2.0),
                push=Push(force=[0.0, 4.0, 0.0], point=[0.1, 0.0, 0.0], duration=0.1),
            ),
        ],
        figure_eight=FigureEight(laps=3),
    )


def test_what_is_saved_is_loaded_again(write, tmp_path):
    scenario = load_scenario(write(TEXT))
    path = tmp_path / "again.yaml"
    save_scenario(scenario, path)
    assert load_scenario(path) == scenario


SENSORS = """duration: 5
world: room
sensors:
  use: [imu, lidar]
  rates: {imu: 100, lidar: 5}
  latency:
    lidar: 0.05
  seed: 7
  noise: false
"""


def test_sensors_and_world_are_read_and_saved(write, tmp_path):
    scenario = load_scenario(write(SENSORS))
    assert scenario == Scenario(
        duration=5.0,
        world="room",
        sensors=SensorsConfig(
            use=["imu", "lidar"],
            rates={"imu": 100.0, "lidar": 5.0},
            latency={"lidar": 0.05},
            seed=7,
            noise=False,
        ),
    )
    save_scenario(scenario, tmp_path / "again.yaml")
    assert load_scenario(tmp_path / "again.yaml") == scenario


def test_sensors_that_cannot_be_had_are_named_with_their_line(case, write):
    for old, new, line, words in [
        ("world: room", "world: rooom", 2, ("'rooom'", "did you mean 'room'")),
        ("sensors:", "sensor:", 3, ("'sensor'", "'sensors'")),
        ("[imu, lidar]", "all", 4, ("sensors.use", "a list")),
        ("[imu, lidar]", "[imu, 3]", 4, ("sensors.use.1", "text")),
        ("imu: 100", "imu: 0", 5, ("sensors.rates.imu", "0.01")),
        ("imu: 100", "imu: -5", 5, ("sensors.rates.imu",)),
        ("imu: 100", "imu: .nan", 5, ("sensors.rates.imu",)),
        ("imu: 100", "imu: .inf", 5, ("sensors.rates.imu", "a finite number")),
        ("imu: 100", "imu: fast", 5, ("sensors.rates.imu", "a number")),
        ("lidar: 0.05", "lidar: -1", 7, ("sensors.latency.lidar", "0 .. 10 s")),
        ("lidar: 0.05", "lidar: 11", 7, ("sensors.latency.lidar",)),
        ("lidar: 0.05", "lidar: .nan", 7, ("sensors.latency.lidar",)),
        ("seed: 7", "seed: -1", 8, ("sensors.seed", "0 or more")),
        ("seed: 7", "seed: 1.5", 8, ("sensors.seed", "whole number")),
        ("noise: false", "noise: 0", 9, ("sensors.noise", "true or false")),
        ("noise: false", "nois: false", 9, ("'nois'", "'noise'")),
    ]:
        with case(old, new, line, words):
            assert SENSORS.count(old) == 1
            path = write(SENSORS.replace(old, new))
            said = fault(path)
            assert not [word for word in words if word not in said]
            assert said.startswith(f"{path}:{line}: ")


def test_only_what_differs_is_saved(tmp_path):
    path = tmp_path / "short.yaml"
    save_scenario(Scenario(title="b", duration=3.0), path)
    assert set(path.read_text().splitlines()) == {"title: b", "duration: 3.0"}


def test_every_number_is_saved_to_the_bit(tmp_path):
    odd = Scenario(duration=1.0 / 3.0, rates=Rates(physics_step=2.0**-16))
    odd.start.velocity = [1e-7, -1e5 / 3.0, 0.1 + 0.2]
    save_scenario(odd, tmp_path / "odd.yaml")
    assert load_scenario(tmp_path / "odd.yaml") == odd


def test_saving_where_nothing_can_be_written_is_refused(tmp_path):
    with pytest.raises(WorkbenchError, match="gone"):
        save_scenario(Scenario(title="b"), tmp_path / "gone" / "a.yaml")


def test_what_cannot_be_flown_is_named_with_its_line(case, write):
    for old, new, line, words in [
        ("title", "titel", 1, ("'titel'", "did you mean 'title'")),
        ("  model", "  modle", 3, ("'modle'", "'model'")),
        ("  mode:", "  mod:", 8, ("'mod'", "'mode'")),
        ("  request: ", "  requst: ", 13, ("'requst'", "'request'")),
        ("  laps", "  lap", 22, ("'lap'", "'laps'")),
        ("  control_period", "  controll", 6, ("'controll'",)),
        ("duration: 5", "duration: 0", 10, ("duration", "positive")),
        ("duration: 5", "duration: -1", 10, ("duration",)),
        ("duration: 5", "duration: .nan", 10, ("duration",)),
        ("duration: 5", "duration: .inf", 10, ("duration",)),
        ('mode: "off"', "mode: flying", 8, ("start.mode", "hovering")),
        ("[1, 2, 3]", "[1, 2]", 9, ("start.position", "three")),
        ("[1, 2, 3]", "[1, 2, .nan]", 9, ("start.position", "finite")),
        ("take_off", "takeoff", 13, ("script.0.request", "take_off")),
        (
            "request: take_off",
            "controller: lqr",
            13,
            ("unknown controller 'lqr': did you mean 'lqi'? known are",),
        ),
        (
            "request: take_off",
            "controller: lqr@speed=0,0.5",
            13,
            ("unknown controller 'lqr': did you mean 'lqi'? known are",),
        ),
        ("request: take_off", "controller: lqr.py", 13, ("lqr.py is Python code",)),
        ("at: 4", "at: -1", 15, ("script.1.at",)),
        ("at: 4", "at: .nan", 15, ("script.1.at",)),
        ("at: 4", "at: .inf", 15, ("script.1.at",)),
        ("[1, 0, 0.5]", "[1, 0]", 16, ("script.1.velocity",)),
        ("[1, 0, 0.5]", "[1, 0, .inf]", 16, ("script.1.velocity",)),
        ("yaw_rate: 0.1", "yaw_rate: .nan", 17, ("script.1.yaw_rate",)),
        ("duration: 2}", "duration: 0}", 19, ("script.1.gust.duration",)),
        ("duration: 2}", "duration: .nan}", 19, ("script.1.gust.duration",)),
        ("duration: 2}", "period: 2}", 19, ("'period'",)),
        ("[3, 0, 0]", "[3, 0]", 19, ("script.1.gust.velocity",)),
        ("[3, 0, 0]", "[3, 0, 51]", 19, ("gust_z is 51", "-50 .. 50 m/s")),
        ("duration: 2}", "duration: 4000}", 19, ("gust_duration is 4000",)),
        ("[0, 4, 0]", "[0, 4000, 0]", 20, ("push_y is 4000", "-1000 .. 1000 N")),
        ("[0.1, 0, 0]", "[11, 0, 0]", 20, ("push_at_x is 11", "-10 .. 10 m")),
        ("[0.1, 0, 0]", "[0, 0, 0], duration: 0.0001", 20, ("push_duration is 0.0001",)),
        ("[0, 4, 0]", "[0, .inf, 0]", 20, ("script.1.push.force",)),
        ("[0.1, 0, 0]", "[.nan, 0, 0]", 20, ("script.1.push.point",)),
        ("height: 2", "end_script: true", 14, ("script.0.end_script", "who flies")),
        ("height: 2", "height: -1", 14, ("script.0.height",)),
        ("height: 2", "height: .nan", 14, ("script.0.height",)),
        ("height: 2", "height: .inf", 14, ("script.0.height",)),
        ("{kp_roll: 99}", "{kp_rol: 99}", 18, ("'kp_rol'", "'kp_roll'")),
        ("{kp_roll: 99}", "{kp_roll: -99}", 18, ("kp_roll", "2500")),
        ("laps: 3", "laps: 0", 22, ("figure_eight.laps",)),
        ("laps: 3", "period: 0", 22, ("figure_eight.period",)),
        ("laps: 3", "period: -2", 22, ("figure_eight.period",)),
        ("laps: 3", "length: .nan", 22, ("figure_eight.length",)),
        ("laps: 3", "width: .inf", 22, ("figure_eight.width",)),
        ("laps: 3", "center: [0, 0]", 22, ("figure_eight.center",)),
        ("0.00390625", "0.005", 6, ("rates.control_period", "multiple")),
        ("0.00390625", "0", 6, ("rates.control_period",)),
        ("control_period: 0.00390625", "physics_step: 0", 6, ("rates.physics_step",)),
        ("control_period: 0.00390625", "physics_step: 0.1", 6, ("rates.physics_step",)),
        ("control_period: 0.00390625", "record_period: .nan", 6, ("rates.record_period",)),
    ]:
        with case(old, new, line, words):
            assert old in TEXT
            path = write(TEXT.replace(old, new))
            said = fault(path)
            assert not [word for word in words if word not in said]
            assert said.startswith(f"{path}:{line}: ")


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("duration: 5", "duration: long", 10),
        ("duration: 5", "duration:", 10),
        ("[1, 2, 3]", "north", 9),
        ("laps: 3", "laps: 1.5", 22),
        ("{mass: '2.0'}", "{mass: 2.0}", 4),
        ('  mode: "off"\n  position: [1, 2, 3]', "  [1, 2]", 7),
        ("yaw_rate: 0.1", "yaw_rate: [1]", 17),
    ],
)
def test_a_value_of_the_wrong_kind_is_named_with_its_line(write, old, new, line):
    assert old in TEXT
    path = write(TEXT.replace(old, new))
    assert fault(path).startswith(f"{path}:{line}: ")


def test_what_is_built_in_python_is_checked_too():
    check_scenario(Scenario())
    with pytest.raises(WorkbenchError, match="^duration must be"):
        check_scenario(Scenario(duration=0.0))
    with pytest.raises(WorkbenchError, match="^script.0.at must be"):
        check_scenario(Scenario(script=[Action(at=-1.0)]))

    with pytest.raises(WorkbenchError, match="^script.0.push.force: push_x is 2000 N"):
        check_scenario(Scenario(script=[Action(push=Push(force=[2000.0, 0.0, 0.0]))]))


def test_sensors_of_other_types_are_a_sentence(case):
    for sensors, words in [
        ({}, "sensors is {}, and should be a SensorsConfig"),
        (SensorsConfig(use="imu"), "sensors.use is 'imu', and should be a list of names"),
        (SensorsConfig(use=[3]), "sensors.use is [3], and should be a list of names"),
        (SensorsConfig(rates=[1.0]), "sensors.rates is [1.0], and should be numbers by name"),
        (SensorsConfig(rates={"imu": "fast"}), "sensors.rates.imu must be a finite number"),
        (SensorsConfig(latency=None), "sensors.latency is None"),
        (SensorsConfig(latency={"imu": "x"}), "sensors.latency.imu must be within"),
        (SensorsConfig(seed="x"), "sensors.seed is 'x', and should be a whole number"),
        (SensorsConfig(seed=1.5), "sensors.seed is 1.5"),
        (SensorsConfig(noise="maybe"), "sensors.noise is 'maybe', and should be true or false"),
        (SensorsConfig(keep="x"), "sensors.keep is 'x'"),
    ]:
        with case(sensors, words):
            with pytest.raises(WorkbenchError) as caught:
                check_scenario(Scenario(sensors=sensors))
            assert words in str(caught.value)


def test_shipped_scenarios_can_be_flown(case):
    for name in list_scenarios():
        with case(name):
            scenario = load_scenario(find_scenario(name))
            assert scenario.title
            session = Session(dataclasses.replace(scenario, duration=min(scenario.duration, 0.5)))
            session.run()
            assert session.time == min(scenario.duration, 0.5)


def test_scenarios_are_shipped_for_what_the_command_promises():
    promised = {
        "hover",
        "paper-steps",
        "square",
        "figure-eight",
        "take-off-and-land",
        "full-speed",
    }
    assert promised <= set(list_scenarios())
