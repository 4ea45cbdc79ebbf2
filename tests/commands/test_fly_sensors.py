"""`workbench fly --sensors`: the table of what they did, and what cannot be had."""

import csv

import pytest

from workbench.commands.chosen_vehicle import with_sensors
from workbench.commands.cli import Parser
from workbench.commands.options import add_sensor_options
from workbench.scenario.scenario import Scenario, SensorsConfig

NAMES = ["lidar", "gps", "camera", "imu", "barometer", "range_finder", "magnetometer"]


def table(said) -> dict[str, list[str]]:
    """Return the rows of the sensors' table by name."""
    _, _, rows = said.out.partition("\n\n")
    heading, *lines = rows.splitlines()
    assert heading.split() == ["sensor", "kind", "asked", "Hz", "delivered", "Hz", "age", "ms"]
    return {line.split()[0]: line.split()[1:] for line in lines}


def fly(run, out, *options):
    said = run("fly", "hover", "--duration", "0.5", "--output", out, "--no-plots", *options)
    assert said.code == 0, said.err
    return said


def test_without_sensors_there_is_no_table(run, out):
    assert "\n\n" not in fly(run, out).out
    assert fly(run, out, "--json").json["sensors"] == []


def test_all_sensors_are_listed_with_the_rates_they_were_asked_for_and_delivered(run, out):
    rows = table(fly(run, out, "--sensors", "all"))
    assert list(rows) == NAMES
    assert rows["imu"][:3] == ["imu", "200", "200.00"]
    assert rows["gps"][:3] == ["gps", "10", "10.00"]
    assert rows["camera"][:4] == ["depth", "camera", "30", "30.00"]
    assert rows["range_finder"][:4] == ["range", "finder", "50", "50.00"]
    assert all(0 <= int(row[-1]) <= 100 for row in rows.values())


def test_some_are_chosen_by_name_or_kind(run, out):
    rows = table(fly(run, out, "--sensors", "imu, depth_camera"))
    assert list(rows) == ["camera", "imu"]


def test_a_scenarios_sensors_are_used_and_may_be_switched_off(run, out, write):
    scenario = write(
        "s.yaml", "duration: 0.25\nsensors: {use: [gps], rates: {gps: 4}, latency: {gps: 1}}\n"
    )
    command = ("fly", scenario, "--output", out, "--no-plots")
    assert table(run(*command)) == {"gps": ["gps", "4", "4.00", "-"]}  # none delivered yet
    assert run(*command, "--sensors", "").out.count("\n\n") == 0


def test_json_has_what_each_did(run, out):
    sensors = fly(run, out, "--sensors", "gps,imu", "--json", "--set", "gps_fault=3").json[
        "sensors"
    ]
    gps, imu = sensors
    assert (gps["name"], gps["kind"], gps["asked_rate"], gps["rate"]) == ("gps", "gps", 10.0, 0.0)
    assert (gps["age"], gps["fault"]) == (None, 3)
    assert imu["rate"] == pytest.approx(200.0)
    assert 0.0 < imu["age"] < 0.005 + 1e-9
    assert imu["fault"] == 0


def test_sensors_and_seeds_do_not_change_a_flight_in_still_air(run, write, out):
    """Samples of a sensor end steps of the integrator: 1.1 um and 0.008 rad/s of a rotor here."""
    moving = write("s.yaml", "duration: 0.5\nscript: [{at: 0.1, velocity: [1, 0.5, 0.2]}]\n")
    logs = []
    for options in ((), ("--sensors", "imu,lidar", "--seed", "4"), ("--no-noise",)):
        assert run("fly", moving, "--output", out, "--no-plots", *options).code == 0
        logs.append((out / "s.csv").read_text(encoding="utf-8"))
    assert logs[0] == logs[2]
    alone, sensing = (list(csv.DictReader(log.splitlines())) for log in logs[:2])
    for row, other in zip(alone, sensing, strict=True):
        for name, value in row.items():
            size = 2e-6 if name.startswith("p_W") else 0.01
            assert float(other[name]) == pytest.approx(float(value), abs=size), name


@pytest.mark.parametrize(
    ("options", "changes"),
    [
        ([], {}),
        (["--sensors", "imu, lidar"], {"use": ["imu", "lidar"]}),
        (["--sensors", ""], {"use": []}),
        (["--seed", "0"], {"seed": 0}),
        (["--no-noise"], {"noise": False}),
    ],
)
def test_options_go_before_what_the_scenario_says(options, changes):
    given = {"use": ["gps"], "rates": {"gps": 4.0}, "seed": 5, "noise": True}
    parser = Parser()
    add_sensor_options(parser)
    scenario = Scenario(sensors=SensorsConfig(**given))
    found = with_sensors(scenario, parser.parse_args(options))
    assert found.sensors == SensorsConfig(**{**given, **changes})


def test_the_seed_is_that_of_the_turbulence(run, out):
    logs = []
    for seed in (1, 1, 2):
        fly(run, out, "--seed", seed, "--set", "turbulence=15")
        logs.append((out / "hover.csv").read_bytes())
    assert logs[0] == logs[1] != logs[2]


def test_a_world_gives_a_least_clearance(run, out):
    said = fly(run, out, "--world", "room")
    (line,) = (line for line in said.out.splitlines() if line.startswith("least clearance"))
    assert 3.4 < float(line.split()[2]) < 3.8
    assert "least clearance" not in fly(run, out).out


def test_bad_input_is_a_sentence_and_leaves_nothing(case, refused, out):
    for options, words in [
        (["--sensors", "nonsense"], ("sensors.use", "'nonsense'", "range_finder")),
        (["--sensors", "imu,lidr"], ("'lidr'", "did you mean 'lidar'?")),
        (["--seed", "-1"], ("sensors.seed", "0 or more")),
        (["--seed", "many"], ("--seed", "'many'")),
        (["--world", "rooom"], ("'rooom'", "did you mean 'room'?")),
        (["--set", "imu_fault=1"], ("imu_fault", "--sensors imu")),
        (["--set", "imu_fault=4", "--sensors", "imu"], ("imu_fault", "0 .. 3")),
        (["--set", "rotor_5=0"], ("rotor_5", "4 rotors")),
        (["--model", "no_such_model", "--sensors", "imu"], ("no_such_model",)),
        (["--sensors", "imu", "--arg", "imu:=false"], ("'imu'", "known are")),
    ]:
        with case(options, words):
            said = refused("fly", "hover", *options, "--output", out)
            assert not [word for word in words if word not in said]
            assert not out.parent.exists()


@pytest.mark.parametrize(
    ("sensors", "words"),
    [
        ("{rates: {imu: 0}}", ("sensors.rates.imu", "0.01")),
        ("{rates: {imu: .nan}}", ("sensors.rates.imu",)),
        ("{latency: {gps: -1}}", ("sensors.latency.gps",)),
        ("{seed: -3}", ("sensors.seed",)),
        ("{use: lidar}", ("sensors.use", "a list")),
    ],
)
def test_a_scenario_with_impossible_sensors_is_named_with_its_line(
    refused, out, write, sensors, words
):
    path = write("bad.yaml", f"title: x\nsensors: {sensors}\n")
    said = refused("fly", path, "--output", out)
    assert f"{path}:2: " in said
    assert not [word for word in words if word not in said]
    assert not out.parent.exists()


def test_an_unknown_sensor_among_the_rates_is_answered_with_the_nearest(refused, out, write):
    path = write("bad.yaml", "sensors: {use: [imu], rates: {imuu: 5}}\n")
    said = refused("fly", path, "--output", out)
    assert "sensors.rates" in said
    assert "did you mean 'imu'?" in said
    assert not out.parent.exists()
