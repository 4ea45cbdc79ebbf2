"""What runs otherwise on macOS, by its conditions: no test of ours has run there."""

import json
import os
import socket
import subprocess
import sys

import pytest

from workbench.commands.gui import check_display
from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.design.executor.executor import available_cores
from workbench.link.server.acceptor import KEEPALIVE_IDLE_S, TCP_OPTIONS, _set_up


def test_cores_are_counted_where_no_process_is_bound_to_some(monkeypatch):
    assert available_cores() == len(os.sched_getaffinity(0))
    monkeypatch.delattr(os, "sched_getaffinity")
    assert available_cores() == os.cpu_count()


def test_a_file_is_written_where_none_is_without_a_name(monkeypatch, tmp_path):
    monkeypatch.delattr(os, "O_TMPFILE")
    write_atomically(tmp_path / "gains.yaml", "kp: 1\n")
    assert [(it.name, it.read_text()) for it in tmp_path.iterdir()] == [("gains.yaml", "kp: 1\n")]


def test_a_connection_has_the_options_that_there_are(monkeypatch):
    monkeypatch.delattr(socket, "TCP_USER_TIMEOUT")
    with socket.socket() as end:
        _set_up(end)
        assert end.getsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE) == KEEPALIVE_IDLE_S
        assert not end.getblocking()
    assert all(name.startswith("TCP_") for name in TCP_OPTIONS)


def test_the_screen_of_macos_needs_no_name(monkeypatch):
    with pytest.raises(WorkbenchError, match="DISPLAY is not set"):
        check_display({})
    monkeypatch.setattr(sys, "platform", "darwin")
    check_display({})


@pytest.mark.parametrize(("system", "answer"), [("linux", "error"), ("darwin", "answer")])
def test_a_reader_of_files_runs_where_memory_has_no_limit(system, answer):
    code = f"""
import sys; sys.platform = {system!r}
from workbench.ipc.limited import serve_one_request
serve_one_request(lambda size: len(bytearray(size)))
"""
    request = {"caller": os.getpid(), "seconds": 10, "megabytes": 900, "bounds": None}
    done = subprocess.run(
        [sys.executable, "-c", code],
        input=json.dumps(request | {"request": 1_000_000_000}),
        capture_output=True,
        text=True,
        check=True,
    )
    assert list(json.loads(done.stdout)) == [answer]
