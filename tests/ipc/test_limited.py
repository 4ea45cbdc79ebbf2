"""Each bound is broken once, by a child that does nothing else."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.ipc import limited
from workbench.ipc.limited import LimitedError, run_limited, run_trusted

CHILD = """
import os, resource, signal, subprocess, sys, time
from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import serve_one_request

def work(request):
    {body}

if __name__ == "__main__":
    serve_one_request(work)
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a function's body on a request."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    def run_body(body: str, request: object = None, seconds: float = 5.0, by=run_limited, **more):
        (tmp_path / "its_child.py").write_text(CHILD.format(body=body))
        return by("its_child", request, seconds=seconds, megabytes=1000, **more)

    return run_body


@pytest.fixture
def failure(run):
    """Return why a function's body gives no answer."""

    def reason(body: str, **how):
        with pytest.raises(LimitedError) as caught:
            run(body, **how)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    return reason


@pytest.mark.parametrize(
    "request_", [None, 3, "grün \udcff \U0001f681", {"a": [1.5, True]}, "a\nb"]
)
def test_an_answer_comes_back_as_it_was(run, request_):
    assert run("return [request]", request_) == [request_]


def test_what_the_function_refuses_is_said_in_its_words(run):
    with pytest.raises(WorkbenchError, match=r"^a\.xml:3: is no drone$") as caught:
        run("raise WorkbenchError('a.xml:3: is no drone')")
    assert not isinstance(caught.value, LimitedError)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise ValueError('two\\nlines')", "two lines"),
        ("raise ValueError", "ValueError"),
        ("sys.exit('enough')", "ended with 1: enough"),
        ("return {1, 2}", "set is not JSON"),
        ("return work(request)", "nested too deeply"),
        ("return 'a' * 1_500_000_000", "more than 1000 MB of memory"),
        ("return 'a' * 130_000_000", "more than 128 MB"),
        ("f = open('large', 'wb'); f.seek(2 * 10**8); f.write(b'a'); f.close()", "too large"),
        ("os.write(2, b'first\\nlast words'); os._exit(3)", "ended with 3: last words"),
        ("os._exit(0)", "answer cannot be read"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "crashed (Segmentation fault)"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "was killed"),
    ],
)
def test_the_lack_of_an_answer_has_a_reason(failure, tmp_path, monkeypatch, body, said):
    monkeypatch.chdir(tmp_path)
    assert said in failure(body, writes=[tmp_path])


def test_a_message_is_short(failure):
    assert len(failure("raise ValueError('a ' * 10**6)")) < 400


def test_computing_time_is_bounded(failure):
    assert failure("while True: pass", seconds=1.0) == "it took more than 1 s"


def test_time_that_passes_idly_is_bounded_too(failure, monkeypatch):
    monkeypatch.setattr(limited, "_WALL_TIME_FACTOR", 0.0)
    monkeypatch.setattr(limited, "_START_ALLOWANCE_S", 0.5)
    assert failure("time.sleep(100_000)") == "it did not end within 0.5 s"


def test_what_the_child_started_ends_with_it(failure, tmp_path, monkeypatch):
    note = tmp_path / "pid"

    class WhenNoted(threading.Timer):
        """Time is up as soon as the child's own child runs."""

        def run(self) -> None:
            wait_for(lambda: note.exists() and note.read_text())
            self.function(*self.args)

    monkeypatch.setattr(limited.threading, "Timer", WhenNoted)
    body = f"open({str(note)!r}, 'w').write(str(subprocess.Popen(['sleep', '60']).pid))"
    assert "was killed" in failure(f"{body}; time.sleep(60)", by=run_trusted)
    status = Path(f"/proc/{note.read_text()}/stat")
    try:  # whoever inherits it needs a moment to bury it
        wait_for(lambda: not status.exists() or status.read_text().split()[2] == "Z")
    except TimeoutError:
        os.kill(int(note.read_text()), signal.SIGKILL)
        raise


def wait_for(condition) -> None:
    end = time.monotonic() + 30
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("it did not come to pass")
        time.sleep(0.01)


@pytest.mark.parametrize("body", ["while True: pass", "time.sleep(600)"])
def test_a_child_ends_with_its_caller_however_that_ends(tmp_path, monkeypatch, body):
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    pid = f"open({str(tmp_path / 'begun')!r}, 'w').write(str(os.getpid()))"
    (tmp_path / "its_child.py").write_text(CHILD.format(body=f"{pid}\n    {body}"))
    call = "run_trusted('its_child', None, seconds=600.0, megabytes=1000)"
    caller = subprocess.Popen(
        [sys.executable, "-c", f"from workbench.ipc.limited import run_trusted; {call}"]
    )
    begun = tmp_path / "begun"
    wait_for(lambda: begun.exists() and begun.read_text())
    caller.kill()
    caller.wait()
    wait_for(lambda: not Path(f"/proc/{begun.read_text()}").exists())


def test_noise_neither_spoils_the_answer_nor_reaches_the_terminal(run, capfd):
    body = "print('a'); os.write(1, b'b'); print('c', file=sys.stderr); os.system('echo d')"
    assert run(f"{body}; return 7") == 7
    assert capfd.readouterr() == ("", "")


def test_no_core_is_dumped(run):
    assert run("return resource.getrlimit(resource.RLIMIT_CORE)") == [0, 0]


def test_a_file_of_the_users_folder_is_not_imported(run, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "json.py").write_text("raise SystemExit('wrong json')")
    monkeypatch.chdir(tmp_path / "here")
    assert run("return 7") == 7


def test_a_module_that_is_not_there_is_named():
    with pytest.raises(LimitedError, match="no_such_module"):
        run_limited("no_such_module", None, seconds=1.0, megabytes=1000)


def test_a_full_disk_is_a_reason(run, monkeypatch):
    def full():
        raise OSError("no space left")

    monkeypatch.setattr(limited.tempfile, "TemporaryFile", full)
    with pytest.raises(LimitedError, match="no process can be started for it: no space left"):
        run("return 7")
