"""The worlds that the docs show are read as they stand."""

import math
import re
from pathlib import Path

import pytest

from workbench.common.resources import list_worlds, worlds_dir
from workbench.plant.worlds.reading import read_world
from workbench.plant.worlds.world import World

PAGE = Path(__file__).parents[2] / "docs" / "worlds.md"


def shown(language: str, path: Path) -> World:
    text = PAGE.read_text(encoding="utf-8")
    found = re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)
    assert found
    path.write_text(found[1], encoding="utf-8")
    return read_world(path, {"worlds": str(worlds_dir())})


def test_the_yaml_file_is_read(tmp_path):
    world = shown("yaml", tmp_path / "yard.yaml")
    assert (world.title, world.names) == ("A yard", ("post", "crate::crate", "ball"))
    assert world.pose("ball", 10.0).translation().tolist() == [4.0, 0.0, 1.5]
    assert world.pose("crate::crate", 0.0).translation().tolist() == [6.0, 2.0, 1.0]
    assert world.home.altitude == 488.0


def test_the_gazebo_world_is_read(tmp_path):
    world = shown("xml", tmp_path / "yard.sdf")
    assert (world.title, world.names, world.remarks) == ("yard", ("wall::link",), ())
    assert world.home.latitude == pytest.approx(math.radians(47.4))


def test_the_shipped_worlds_that_are_named_are_there():
    named = {"empty", "room", "obstacle_field", "moving_obstacle"}
    assert named <= set(list_worlds())
    assert all(f"`{name}`" in PAGE.read_text(encoding="utf-8") for name in named)
