"""What `workbench frames` says of the shipped drone."""

import json
import math

import pytest

from workbench.commands.cli import main
from workbench.common.resources import find_model, find_scenario
from workbench.plant.loading import load_vehicle
from workbench.scenario.configured import read_configured_world
from workbench.scenario.scenario import Scenario
from workbench.scenario.scenario_file import load_scenario
from workbench.session.session import Session


def said(capsys, *words: str) -> str:
    assert main(["frames", *words]) == 0
    return capsys.readouterr().out


def read_json(capsys, *words: str):
    return json.loads(said(capsys, *words, "--json"))


def test_the_tree_has_world_links_and_sensors(capsys):
    lines = said(capsys).splitlines()
    assert "world" in lines
    height = load_vehicle(find_model("dh_drone")).ground_clearance
    assert f"└─ base_link (0 0 {height:.4g}, flies)" in lines
    assert any(line.lstrip("│├└─ ").startswith("camera_optical (") for line in lines)


def test_the_tree_as_json_is_the_message(capsys):
    data = read_json(capsys)
    found = {each["child"]: each for each in data["transforms"]}
    assert data["time"] == 0.0
    assert found["base_link"]["parent"] == "world"
    assert found["lidar"]["parent"] == "lidar_link"
    assert len(found["lidar"]["p"]) == 3
    assert len(found["lidar"]["q"]) == 4


def test_a_transform_at_rest(capsys):
    vehicle = load_vehicle(find_model("dh_drone"))
    (camera,) = (sensor for sensor in vehicle.sensors if sensor.name == "camera")
    data = read_json(capsys, "world", "camera_optical")
    x, y, z = camera.p_BS
    assert (data["in"], data["frame"]) == ("world", "camera_optical")
    assert data["position"] == pytest.approx([x, y, z + vehicle.ground_clearance])
    assert data["quaternion"] == pytest.approx([0.5, -0.5, 0.5, -0.5])
    assert data["roll_pitch_yaw"] == pytest.approx([-math.pi / 2, 0.0, -math.pi / 2])


def test_people_get_metres_and_degrees(capsys):
    lines = [line.split() for line in said(capsys, "camera", "camera_optical").splitlines()]
    assert ["roll", "pitch", "yaw", "-90.000000", "0.000000", "-90.000000", "deg"] in lines
    assert [
        "quaternion",
        "w",
        "x",
        "y",
        "z",
        "0.500000",
        "-0.500000",
        "0.500000",
        "-0.500000",
    ] in lines


def test_at_a_time_of_a_flight_it_is_where_it_has_flown(capsys):
    session = Session(load_scenario(find_scenario("square")))
    session.tick(3.0)
    data = read_json(capsys, "world", "base_link", "--scenario", "square", "--at-time", "3")
    now = session.snapshot()
    assert data["time"] == 3.0
    assert data["position"] == list(now.p_WB)
    assert data["quaternion"] == pytest.approx(now.q_WB)
    assert math.dist(data["position"], [0, 0, 1.5]) > 0.5


def test_another_model_has_its_own_frames(capsys, tmp_path):
    text = said(capsys, "--model", "tests/drones/hexacopter.urdf.xacro")
    assert "camera_optical" not in text


def test_parts_of_a_world_are_frames_and_move_with_time(capsys):
    data = read_json(capsys, "--world", "moving_obstacle")
    parents = {each["child"]: each["parent"] for each in data["transforms"]}
    assert len(parents) > len(read_json(capsys)["transforms"])
    world = read_configured_world(Scenario(world="moving_obstacle"))
    (name, *_) = (obstacle.name for obstacle in world.moving)
    assert parents[name] == "world"
    words = ("world", name, "--world", "moving_obstacle", "--scenario", "hover", "--at-time", "0.5")
    now = read_json(capsys, *words)["position"]
    assert now == pytest.approx(world.pose(name, 0.5).translation())
    assert now != pytest.approx(world.pose(name, 0.0).translation())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["world", "lidr"], "unknown frame 'lidr': did you mean 'lidar'"),
        (["lidr", "world"], "unknown frame 'lidr': did you mean 'lidar'"),
        (["world"], "1 frames are named"),
        (["world", "lidar", "camera"], "3 frames are named"),
        (["world", "lidar", "--at-time", "3"], "--scenario and --at-time go together"),
        (["world", "lidar", "--scenario", "hover"], "--scenario and --at-time go together"),
        (["world", "lidar", "--scenario", "hover", "--at-time", "-1"], "--at-time is -1 s"),
        (["world", "lidar", "--scenario", "hover", "--at-time", "1e6"], "1e+06 s: hover lasts"),
        (["world", "lidar", "--scenario", "hover", "--at-time", "nan"], "--at-time is nan s"),
        (["world", "lidar", "--scenario", "gone", "--at-time", "1"], "gone"),
        (["--world", "gone"], "unknown world 'gone'"),
        (["--model", "gone"], "unknown model 'gone'"),
    ],
)
def test_bad_input_is_one_sentence(words, sentence, capsys):
    assert main(["frames", *words]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
