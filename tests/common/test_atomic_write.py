"""Whatever fails, the old file stays, and nothing else is left behind."""

import os
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically


def test_a_file_is_written_and_written_over(tmp_path):
    path = tmp_path / "a.yaml"
    write_atomically(path, "one\n")
    write_atomically(path, "zwölf\n")
    assert path.read_text(encoding="utf-8") == "zwölf\n"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("step", ["write", "fsync", "replace"])
def test_the_old_file_stays_when_a_step_fails(tmp_path, monkeypatch, step):
    path = tmp_path / "a.yaml"
    path.write_text("old")

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    if step == "fsync":
        monkeypatch.setattr(os, "fsync", fail)
    elif step == "replace":
        monkeypatch.setattr(Path, "replace", fail)
    else:
        monkeypatch.setattr(Path, "open", fail)
    with pytest.raises(WorkbenchError, match=r"a\.yaml: cannot be written: No space left"):
        write_atomically(path, "new")
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_target_of_a_link_is_replaced_and_the_link_stays(tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    target, link = folder / "real.yaml", tmp_path / "link.yaml"
    target.write_text("old")
    link.symlink_to(target)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_permissions_are_kept_and_a_new_file_has_the_usual_ones(tmp_path):
    old, new, usual = (tmp_path / name for name in ("old", "new", "usual"))
    old.write_text("old")
    old.chmod(0o640)
    usual.write_text("usual")
    write_atomically(old, "x")
    write_atomically(new, "x")
    assert old.stat().st_mode & 0o777 == 0o640
    assert new.stat().st_mode == usual.stat().st_mode


def test_a_place_that_is_not_there_is_a_sentence(tmp_path):
    with pytest.raises(WorkbenchError, match="cannot be written: No such file or directory"):
        write_atomically(tmp_path / "gone" / "a.yaml", "x")
