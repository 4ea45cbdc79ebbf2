"""Files appear together, or not at all."""

import stat

import pytest

from workbench.commands.outputs import Outputs
from workbench.common.errors import WorkbenchError


def names(folder):
    return sorted(path.name for path in folder.rglob("*"))


def test_files_appear_together_at_the_end(tmp_path):
    with Outputs() as outputs:
        for name in ("a.csv", "b.png"):
            partial = outputs.add(tmp_path / "sub" / name)
            assert partial.suffix == (tmp_path / name).suffix
            partial.write_text(name)
        assert not (tmp_path / "sub" / "a.csv").exists()
    assert names(tmp_path / "sub") == ["a.csv", "b.png"]
    assert outputs.files == [tmp_path / "sub" / "a.csv", tmp_path / "sub" / "b.png"]


def test_a_failure_leaves_neither_files_nor_folders(tmp_path):
    with pytest.raises(KeyboardInterrupt), Outputs() as outputs:
        outputs.add(tmp_path / "sub" / "deep" / "a.csv").write_text("half")
        raise KeyboardInterrupt
    assert names(tmp_path) == []


def test_a_failure_leaves_what_was_there_before(tmp_path):
    (tmp_path / "a.csv").write_text("old")
    with pytest.raises(WorkbenchError), Outputs() as outputs:
        outputs.add(tmp_path / "a.csv").write_text("new")
        outputs.add(tmp_path / "a.csv" / "b.csv")
    assert (tmp_path / "a.csv").read_text() == "old"
    assert names(tmp_path) == ["a.csv"]


def test_a_file_has_the_mode_of_any_other(tmp_path):
    with Outputs() as outputs:
        outputs.add(tmp_path / "a.csv").write_text("")
    (tmp_path / "b.csv").write_text("")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("a.csv", "b.csv")]
    assert modes[0] == modes[1]


def test_a_folder_in_a_files_place_is_refused(tmp_path):
    with pytest.raises(WorkbenchError, match="is a folder"), Outputs() as outputs:
        outputs.add(tmp_path)


def test_two_files_in_one_place_are_refused(tmp_path):
    with pytest.raises(WorkbenchError, match="two different files"), Outputs() as outputs:
        outputs.add(tmp_path / "a.png")
        outputs.add(tmp_path / "a.png")
    assert names(tmp_path) == []
