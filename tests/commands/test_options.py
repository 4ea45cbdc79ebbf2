"""Options arrive where they belong, with values of which no two are equal; nothing flies."""

import dataclasses
from pathlib import Path
from types import SimpleNamespace

import pytest

from workbench.commands import regress, serve
from workbench.commands.chosen_vehicle import chosen_scenario, with_sensors
from workbench.commands.cli import _parser
from workbench.design import pin, pin_log
from workbench.design.regress import running
from workbench.link.server.config import ServerConfig
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.scenario.sensors_config import SensorsConfig


def parsed(*words):
    return _parser().parse_args([str(word) for word in words])


@pytest.fixture
def files(write):
    """Files of a vehicle that need not be read, by the option that names them."""
    return {
        "--rotors": write("mine.rotors.yaml", "rotors: []\n"),
        "--gains": write("mine.yaml", "gains: {}\n"),
        "--world": write("mine.world.yaml", "title: mine\n"),
    }


def own_scenario(files):
    """A scenario that states everything itself."""
    vehicle = VehicleConfig(
        "dh_drone", {"mass": "2.1"}, {"own": "own_folder"}, str(files["--rotors"]),
        gains=str(files["--gains"]), variation=Variation(mass=1.05, rotor_lag=1.2),
    )  # fmt: skip
    return Scenario(
        vehicle=vehicle, world=str(files["--world"]), controller="pd", estimator="ekf",
        sensors=SensorsConfig(use=["gps"], seed=7),
    )  # fmt: skip


def test_options_go_before_what_a_scenario_states(files, write):
    own = own_scenario(files)
    rotors, world = write("new.rotors.yaml", ""), write("new.yaml", "title: new\n")
    gains = write("new_gains.yaml", "gains: {}\n")
    args = parsed(
        *("fly", "hover", "--arg", "arm:=0.3", "--package", "new=new_folder"),
        *("--rotors", rotors, "--gains", gains, "--world", world, "--controller", "pid"),
        *("--estimator", "complementary", "--vary", "mass=1.1", "--vary", "control_delay=2"),
        *("--sensors", "imu, lidar", "--seed", "3", "--no-noise"),
    )
    found = with_sensors(chosen_scenario(args, own), args)
    vehicle = found.vehicle
    assert (vehicle.model, vehicle.args) == ("dh_drone", {"mass": "2.1", "arm": "0.3"})
    assert vehicle.packages == {"own": "own_folder", "new": "new_folder"}
    assert (vehicle.rotors, vehicle.gains) == (str(rotors), str(gains))
    assert vehicle.variation == Variation(mass=1.1, rotor_lag=1.2, control_delay=2)
    assert isinstance(vehicle.variation.control_delay, int)
    assert (found.world, found.controller, found.estimator) == (str(world), "pid", "complementary")
    assert (found.sensors.use, found.sensors.seed) == (["imu", "lidar"], 3)
    assert found.sensors.noise is False


def test_without_options_a_scenario_stays_as_it_is(files):
    args = parsed("fly", "hover")
    found = with_sensors(chosen_scenario(args, own_scenario(files)), args)
    assert found == own_scenario(files)


def test_another_model_drops_what_is_of_the_one_before(files):
    args = parsed("fly", "hover", "--model", "gimbal", "--arg", "mass:=2")
    assert chosen_scenario(args, own_scenario(files)).vehicle == VehicleConfig(
        "gimbal", {"mass": "2"}
    )


def test_a_server_is_configured_as_its_options_say(tmp_path):
    certificate, key, tokens = (tmp_path / name for name in ("a.pem", "b.pem", "tokens.txt"))
    args = parsed(
        *("serve", "--host", "0.0.0.0", "--port", "5001", "--web", "--web-port", "5002"),
        *("--tls-cert", certificate, "--tls-key", key, "--token-file", tokens, "--watch-only"),
    )
    assert serve._config(args) == ServerConfig(
        host="0.0.0.0", port=5001, token_file=str(tokens), tls_cert=str(certificate),
        tls_key=str(key),
        allow_commands=False, web=True, web_port=5002,
    )  # fmt: skip
    assert serve._config(parsed("serve")).allow_commands


def test_a_pinned_step_is_flown_as_its_options_say(monkeypatch, capsys):
    asked = []

    def pin_step(spec, scenario, values, way, amplitude, **options):
        asked.append((spec, values, way, amplitude, options))
        paths = {name: Path(name) for name in ("spec", "gains", "baseline")}
        return SimpleNamespace(**paths, loops=0, limits=3, curves=2, to_json=dict)

    monkeypatch.setattr(pin, "pin_step", pin_step)
    for words, way, amplitude, options in (
        ((), "x", 1.0, {}),
        (("--axis", "yaw", "--amplitude", "0.25", "--duration", "4"), "yaw", 0.25, {"duration": 4}),
        (("--load", "gust_z", "--duration", "4", "--acts", "2"), "gust_z", 1.0,
         {"duration": 4, "acts": 2}),
        (("--no-margins", "--force"), "x", 1.0, {"margins": False, "overwrite": True}),
    ):  # fmt: skip
        args = parsed("pin", "mine.workbench.yaml", "--set", "kp_roll=120", *words)
        assert regress.run_pin(args) == 0
        *found, given = asked.pop()
        assert found == [Path("mine.workbench.yaml"), {"kp_roll": 120.0}, way, amplitude]
        own = {"duration": None, "acts": None, "margins": True, "overwrite": False}
        assert {name: given[name] for name in own} == own | options, words


def test_a_pinned_log_is_read_as_its_options_say(monkeypatch, capsys, tmp_path):
    asked = []

    def pinned(spec, vehicle, log, loop, read, *, overwrite):
        asked.append((vehicle.model, log, loop, overwrite))
        return SimpleNamespace(spec=spec, limits=3, left_out={}, to_json=dict)

    monkeypatch.setattr(pin_log, "pin_log", pinned)
    monkeypatch.setattr(running, "regress", lambda specs, read_log: [])
    args = parsed(
        *("pin", "mine.workbench.yaml", "--from-log", "flight.csv", "--mapping", "columns.yaml"),
        *("--log-number", "2", "--order", "3,1,2,4", "--span", "5", "9", "--loop", "roll_rate"),
        *("--model", "gimbal", "--force"),
    )
    assert regress.run_pin(args) == 0
    ((model, log, loop, overwrite),) = asked
    assert (model, loop, overwrite) == ("gimbal", "roll_rate", True)
    wanted = {"file": "flight.csv", "mapping": "columns.yaml", "number": 2}
    wanted |= {"order": [3, 1, 2, 4], "span": [5.0, 9.0]}
    assert {name: dataclasses.asdict(log)[name] for name in wanted} == wanted
