"""Whatever fails, the old file stays, and nothing else is left behind."""

import errno
import os
import signal
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import atomic_file, write_atomically


def test_a_file_is_written_and_written_over(tmp_path):
    path = tmp_path / "a.yaml"
    write_atomically(path, "one\n")
    write_atomically(path, "zwölf\n")
    assert path.read_text(encoding="utf-8") == "zwölf\n"
    assert list(tmp_path.iterdir()) == [path]


FAILING = {"open": os, "fdopen": os, "fsync": os, "link": os, "replace": Path}
"""Each step of a write, and what does it."""


@pytest.mark.parametrize("step", FAILING)
def test_the_old_file_stays_when_a_step_fails(tmp_path, monkeypatch, step):
    path = tmp_path / "a.yaml"
    path.write_text("old")

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(FAILING[step], step, fail)
    with pytest.raises(WorkbenchError, match=r"a\.yaml: cannot be written: No space left"):
        write_atomically(path, "new")
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_killed_process_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("old")
    child = os.fork()
    if not child:
        with atomic_file(path) as stream:
            stream.write(b"half")
            stream.flush()
            os.kill(os.getpid(), signal.SIGKILL)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_filesystem_without_nameless_files_is_written_to(tmp_path, monkeypatch):
    path, plain = tmp_path / "a.yaml", os.open

    def without(place, flags, *rest, **named):
        if flags & os.O_TMPFILE == os.O_TMPFILE:
            raise OSError(errno.EOPNOTSUPP, "Operation not supported")
        return plain(place, flags, *rest, **named)

    monkeypatch.setattr(os, "open", without)
    write_atomically(path, "one")
    with pytest.raises(KeyboardInterrupt), atomic_file(path) as stream:
        stream.write(b"half")
        raise KeyboardInterrupt
    assert path.read_text() == "one"
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
