"""Shipped names and paths; how worlds are found."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_world, list_worlds, worlds_dir


def fault(name: str) -> str:
    with pytest.raises(WorkbenchError) as caught:
        find_world(name)
    return str(caught.value)


@pytest.mark.parametrize("name", list_worlds())
def test_a_shipped_world_is_found_by_its_name(name):
    assert find_world(name) == worlds_dir() / f"{name}.yaml"


def test_a_path_is_a_world_too(tmp_path):
    path = tmp_path / "yard.sdf"
    path.write_text("x")
    assert find_world(str(path)) == path


def test_an_unknown_world_is_named_with_those_near_it():
    said = fault("rom")
    assert said.startswith("unknown world 'rom': did you mean 'room'? known are empty, ")
    assert said.endswith("; nor is it a file")


def test_a_path_that_leads_nowhere_and_a_folder_are_no_worlds(tmp_path):
    missing = tmp_path / "none.sdf"
    assert fault(str(missing)) == f"{missing}: no such file, and no shipped world either"
    assert fault(str(tmp_path)) == f"{tmp_path}: is a folder: give the world's file in it"


def test_a_shipped_name_comes_before_a_folder_of_that_name(tmp_path, monkeypatch):
    (tmp_path / "room").mkdir()
    monkeypatch.chdir(tmp_path)
    assert find_world("room") == worlds_dir() / "room.yaml"
