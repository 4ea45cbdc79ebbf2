"""What a scenario names is read, and its world's remarks are said."""

import logging

import pytest

from workbench.commands.chosen_vehicle import chosen_scenario
from workbench.commands.cli import Parser
from workbench.commands.options import add_vehicle_options
from workbench.common.errors import WorkbenchError
from workbench.common.resources import worlds_dir
from workbench.plant.remarks import DescriptionRemark
from workbench.plant.worlds.world import EMPTY_WORLD, World
from workbench.scenario.configured import (
    MAX_LOGGED_REMARKS,
    log_world_remarks,
    read_configured_world,
    warn_of_start_contact,
)
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.scenario.scenario_file import load_scenario

WORLD = "obstacles: [{name: post, shape: {sphere: 1}}]"


@pytest.fixture
def scenario(tmp_path):
    """Write a scenario that names a world, and load it."""

    def load(name: str) -> Scenario:
        path = tmp_path / "scenario.yaml"
        path.write_text(f"title: x\nworld: {name}\n")
        return load_scenario(path)

    return load


def test_without_a_word_the_world_is_empty():
    world = read_configured_world(Scenario())
    assert (world.name, world.names) == ("empty", ())
    assert world.source == worlds_dir() / "empty.yaml"


def test_a_scenario_names_a_shipped_world(scenario):
    assert read_configured_world(scenario("room")).name == "room"


def test_a_world_beside_the_scenario_is_found(scenario, tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "yard.yaml").write_text(WORLD)
    assert read_configured_world(scenario("sub/yard.yaml")).names == ("post",)


def test_a_world_that_is_not_there_is_said_with_file_and_line(scenario):
    with pytest.raises(WorkbenchError, match=r"scenario.yaml:2: unknown world 'rooom': did you"):
        scenario("rooom")


def test_packages_of_the_vehicle_serve_the_world(tmp_path):
    (tmp_path / "shed").mkdir()
    (tmp_path / "shed" / "more.yaml").write_text("directives: []")
    path = tmp_path / "world.yaml"
    path.write_text("directives:\n- add_directives: {file: 'package://tools/more.yaml'}")
    vehicle = VehicleConfig(packages={"tools": str(tmp_path / "shed")})
    assert read_configured_world(Scenario(vehicle=vehicle, world=str(path))).names == ()


def test_the_command_line_names_a_world():
    parser = Parser()
    add_vehicle_options(parser)
    assert chosen_scenario(parser.parse_args(["--world", "room"]), Scenario()).world == "room"
    assert chosen_scenario(parser.parse_args([]), Scenario(world="room")).world == "room"


def test_remarks_are_said_one_by_one_and_then_summed_up(caplog):
    remarks = [
        DescriptionRemark("missing", EMPTY_WORLD.source, f"model '{i}'", "gone") for i in range(9)
    ]
    ignored = DescriptionRemark("ignored", EMPTY_WORLD.source, "a lamp", "out")
    with caplog.at_level(logging.INFO):
        log_world_remarks(World(EMPTY_WORLD.source, "w", remarks=(ignored, *remarks)))
    assert caplog.messages[:MAX_LOGGED_REMARKS] == [
        f"empty: model '{i}': gone" for i in range(MAX_LOGGED_REMARKS)
    ]
    assert caplog.messages[MAX_LOGGED_REMARKS:] == [
        "empty: and so on, 9 missing, 1 not used in all"
    ]
    caplog.clear()
    log_world_remarks(EMPTY_WORLD)
    assert caplog.messages == []


@pytest.mark.parametrize(
    ("clearance", "distance", "said"),
    [
        (-0.7, -0.3, ["the flight begins inside 'box': let it start at another position"]),
        (-0.1, 0.3, ["the flight begins 0.3 m from 'box', within the drone's own reach of 0.4 m"]),
        (0.0, 0.4, []),
        (5.0, 5.4, []),
    ],
)
def test_a_start_in_an_obstacle_is_said(caplog, clearance, distance, said):
    with caplog.at_level(logging.INFO):
        warn_of_start_contact("box", clearance, distance)
    assert caplog.messages == said
