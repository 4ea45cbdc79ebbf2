"""Files of limited size: reading takes the memory that the file needs, whatever limit was set."""

import os

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import open_plain, read_plain, write_in_folder


def test_a_limit_beyond_all_memory_is_no_request_for_it(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    assert read_plain(path, most=2**62) == b"abc"
    assert read_plain(path, first=2**62) == b"abc"
    assert read_plain(path, first=2) == b"ab"
    assert read_plain("/proc/self/stat", most=10_000).startswith(str(os.getpid()).encode())


def test_what_is_no_plain_file_of_that_size_is_a_sentence(tmp_path, case):
    path, pipe = tmp_path / "a", tmp_path / "pipe"
    path.write_bytes(bytes(2000))
    os.mkfifo(pipe)
    for file, most, said in (
        (path, 1000, "is larger than 1 kB"),
        (pipe, None, "is a pipe or a device"),
        (tmp_path, None, "is a folder"),
        (tmp_path / "none", None, "no such file"),
        ("a\0b", None, "cannot be read: .*embedded null"),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said), open_plain(file, most):
            pass


def test_a_file_is_written_into_new_folders_or_a_sentence_names_the_one_that_cannot_be(tmp_path):
    path = write_in_folder(tmp_path / "a" / "b" / "c.txt", "text")
    assert path.read_text(encoding="utf-8") == "text"
    with pytest.raises(WorkbenchError, match=r"c\.txt: cannot be made: "):
        write_in_folder(path / "d.txt", "text")
