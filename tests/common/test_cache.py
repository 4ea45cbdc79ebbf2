"""Where the folder lies is the XDG base directory specification's word."""

import os
import stat
import tempfile
from importlib.metadata import PackageNotFoundError, version

import pytest

from workbench.common.cache import cache_folder, release
from workbench.common.errors import WorkbenchError


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def blocked(tmp_path, monkeypatch, temporary):
    """Let the cache's place be taken by a file."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))


def test_it_is_made_where_the_user_keeps_caches(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("a") == tmp_path / "drake-drone-workbench" / "a"
    assert cache_folder("a").is_dir()


@pytest.mark.parametrize("variable", ["", None])
def test_without_a_word_it_is_below_the_home(tmp_path, monkeypatch, variable):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    if variable is not None:
        monkeypatch.setenv("XDG_CACHE_HOME", variable)
    assert cache_folder("a") == tmp_path / ".cache" / "drake-drone-workbench" / "a"


def test_what_is_in_it_stays(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (cache_folder("a") / "file").write_text("kept")
    assert (cache_folder("a") / "file").read_text() == "kept"


def test_where_it_cannot_be_written_a_private_folder_serves(blocked, temporary):
    folder = cache_folder("a")
    assert folder.is_dir()
    assert folder.is_relative_to(temporary)
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700
    assert cache_folder("a") == folder


def test_a_folder_closed_to_the_user_does_not_serve(tmp_path, monkeypatch, temporary):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    closed = cache_folder("a")
    can = os.access  # root may write everywhere, so the answer is given here
    monkeypatch.setattr(os, "access", lambda path, mode: path != closed and can(path, mode))
    assert cache_folder("a").is_relative_to(temporary)


@pytest.mark.parametrize("trap", ["open", "link"])
def test_a_folder_that_somebody_else_laid_out_is_not_used(blocked, temporary, tmp_path, trap):
    laid_out = temporary / f"drake-drone-workbench-{os.getuid()}"
    if trap == "open":
        laid_out.mkdir()
        laid_out.chmod(0o777)
    else:
        (tmp_path / "theirs").mkdir(mode=0o700)
        laid_out.symlink_to(tmp_path / "theirs")
    folder = cache_folder("a")
    assert folder.is_relative_to(temporary)
    assert not folder.is_relative_to(laid_out)


def test_where_nothing_can_be_written_it_says_so(blocked, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(WorkbenchError, match="set XDG_CACHE_HOME"):
        cache_folder("a")


def test_a_release_is_that_of_the_metadata(case):
    for name in ("numba", "numpy", "xacro"):
        with case(name):
            assert release(name) == f"{name}-{version(name)}.dist-info"
    with pytest.raises(PackageNotFoundError):
        release("no_such_package")


def test_a_release_with_what_is_left_of_another_is_that_of_the_metadata(tmp_path, monkeypatch):
    (tmp_path / "half_way").mkdir()
    (tmp_path / "half_way" / "__init__.py").write_text("")
    for number in ("1.0", "2.0"):
        (tmp_path / f"half_way-{number}.dist-info").mkdir()
        text = f"Metadata-Version: 2.1\nName: half_way\nVersion: {number}\n"
        (tmp_path / f"half_way-{number}.dist-info" / "METADATA").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    assert release("half_way") == version("half_way")
