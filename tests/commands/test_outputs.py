"""Files appear together, or not at all."""

import stat
from pathlib import Path

import pytest

from workbench.commands.outputs import Outputs
from workbench.common.errors import WorkbenchError
from workbench.session.session import Session

SPEC = """cases:
- name: step
  axis: z
  amplitude: 0.2
  duration: 0.5
  baseline: {v_z: {absolute: 0.1}}
"""


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


def test_a_sentence_about_a_temporary_file_names_the_target(tmp_path):
    """Of what writes in the block, and of the end, where files get their names."""
    target = tmp_path / "table.csv"

    def tell(partial):
        raise WorkbenchError(f"{partial}: cannot be written: full")

    def end(partial):
        partial.unlink()

    for write, reason in ((tell, "full"), (end, "No such file or directory")):
        with pytest.raises(WorkbenchError) as raised, Outputs() as outputs:
            write(outputs.add(target))
        assert str(raised.value) == f"{target}: cannot be written: {reason}"


def test_a_place_where_nothing_can_be_written_is_refused_before_any_flight(
    refused, tmp_path, monkeypatch, case
):
    """In a folder that is a file; `record` and `regress` make folders of their own. Those that read
    a log look for the place before they look for the log.
    """

    def flies(*_):
        raise AssertionError("it has flown")

    monkeypatch.setattr(Session, "tick", flies)
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    Path("file.workbench.yaml").write_text(SPEC)
    Path("file.baseline").write_text("in the way")
    before = sorted(tmp_path.iterdir())
    for words in (
        "record file/new.workbench.yaml",
        "record file/new.workbench.yaml --from-log flight.mcap --loop roll",
        "regress file.workbench.yaml -j 1 --update",
        "step --output file",
        "fly hover --log file/a.mcap --no-plots",
        "sweep kp_roll=100..110:2 --output file",
        "log gone.mcap --html file/a.html",
        "export gone.mcap --output file",
        "plot gone.mcap --save file/a.png",
        "plot gone.mcap --step-response roll --save file/a.png",
        "estimate gone.mcap --output file",
    ):
        with case(words):
            assert "cannot be written: Not a directory" in refused(*words.split())
            assert sorted(tmp_path.iterdir()) == before
