"""A worker of the test's own in a real process: what it says, how it dies, what is left of it."""

import os
import signal
import subprocess
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.ipc import child_process
from workbench.ipc.child_process import ChildProcess, start_module
from workbench.ipc.worker_process import SupersededError, WorkerProcess

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
MODULE = "worker_of_the_test"
CODE = """
import os, sys
from multiprocessing.connection import Connection
from workbench.ipc.worker_process import Superseded, WorkerRefusal, WorkerRequest, WorkerResult

caller = Connection(int(sys.argv[1]))
while True:
    try:
        message = caller.recv()
    except EOFError:
        break
    match message:
        case WorkerRequest(number, "refuse"):
            caller.send(WorkerRefusal(number, "there is no such thing"))
        case WorkerRequest(number, "supersede"):
            caller.send(Superseded(number))
        case WorkerRequest(number, "garbage"):
            caller.send_bytes(b"no pickle")
        case WorkerRequest(number, "fail"):
            sys.exit("out of paper")
        case WorkerRequest(number, "wait"):
            pass
        case WorkerRequest(number, what):
            caller.send(("told", what))
            caller.send(WorkerResult(number, [what]))
        case "end":
            break
print("last line")
os._exit(0)
"""


@pytest.fixture
def start(tmp_path, monkeypatch):
    """Begin workers; afterwards neither process, thread nor socket of them may be left."""
    (tmp_path / f"{MODULE}.py").write_text(CODE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    @contextmanager
    def begun(hear=lambda message: None, on_end=str):
        threads, sockets = set(threading.enumerate()), open_sockets()
        worker = WorkerProcess(MODULE, "test", hear, on_end)
        try:
            yield worker
        finally:
            worker.close()
            worker.close()  # twice does no harm
        assert not Path(f"/proc/{worker.pid}").exists()
        assert set(threading.enumerate()) <= threads  # one of an earlier test may end
        assert open_sockets() == sockets

    return begun


def open_sockets() -> int:
    return sum(os.path.realpath(fd).find("socket:") > 0 for fd in Path("/proc/self/fd").iterdir())


def test_requests_are_answered_refused_or_dropped_and_the_rest_is_heard(start):
    heard = []
    with start(heard.append) as worker:
        superseded = worker.do("supersede").exception(ENOUGH)
        assert isinstance(superseded, SupersededError)
        assert not worker.answered
        refused = worker.do("refuse").exception(ENOUGH)
        assert (type(refused), str(refused)) == (WorkbenchError, "there is no such thing")
        answers = [worker.do(number) for number in range(100)]
        assert [each.result(ENOUGH) for each in answers] == [[number] for number in range(100)]
        assert heard == [("told", number) for number in range(100)]
        assert worker.answered and worker.requests == 102
        unsent = worker.do(threading.Lock()).exception(0.0)
        assert isinstance(unsent, WorkbenchError) and "cannot be sent" in str(unsent)
        assert worker.do("next").result(ENOUGH) == ["next"]


def test_a_death_is_a_sentence_and_fails_what_waits(start, case):
    def killed(worker):
        os.kill(worker.pid, signal.SIGKILL)

    def crashed(worker):
        os.kill(worker.pid, signal.SIGABRT)

    table = [
        (killed, "the test's process was killed: by somebody, or because memory ran out"),
        (crashed, "the test's process crashed (Aborted)"),
        (lambda worker: worker.send("end"), "the test's process ended with 0: last line"),
        (lambda worker: worker.do("fail"), "the test's process ended with 1: out of paper"),
        (lambda worker: worker.do("garbage"), "the test's process sent an unreadable answer: "),
        (WorkerProcess.close, "the test is closed"),
        (lambda worker: worker.close(ENOUGH, "end"), "the test is closed"),
    ]
    for end, said in table:
        reasons = []

        def on_end(reason, reasons=reasons):
            reasons.append(reason)
            return f"it is over: {reason}"

        with case(said), start(on_end=on_end) as worker:
            waiting = worker.do("wait")
            worker.do("begun").result(ENOUGH)
            end(worker)
            reason = str(waiting.exception(ENOUGH))
            assert reason == f"it is over: {reasons[0]}"
            assert reasons[0].startswith(said) and len(reasons) == 1
            assert worker.ended == reason
            assert str(worker.do("later").exception(0.0)) == reason


def test_an_answer_may_close_its_worker(start):
    with start() as worker:
        waiting = worker.do("wait")
        worker.do("now").add_done_callback(lambda _: worker.close())
        assert str(waiting.exception(ENOUGH)) == "the test is closed"


def test_without_a_temporary_folder_the_sentence_says_so(monkeypatch):
    def none():
        raise FileNotFoundError(2, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr(child_process.tempfile, "TemporaryFile", none)
    sentence = "no temporary file can be made for the picture: No usable .* set TMPDIR"
    with pytest.raises(WorkbenchError, match=sentence):
        ChildProcess("workbench.commands.drawer", "picture")


def test_closing_does_not_wait_for_a_process_that_stands_still(start):
    with start() as worker:
        worker.do("begun").result(ENOUGH)
        os.kill(worker.pid, signal.SIGSTOP)
        worker.do(b"x" * 10_000_000)  # more than a socket takes
        worker.close(0.01, "end")
        assert worker.ended == "the test is closed"


def test_linear_algebra_has_one_thread_in_a_process_unless_its_caller_says_otherwise(
    tmp_path, monkeypatch
):
    (tmp_path / "threads.py").write_text("import os; print(os.environ['OPENBLAS_NUM_THREADS'])")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    with start_module("threads", stdout=subprocess.PIPE) as process:
        assert process.communicate()[0] == b"1\n"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with start_module("threads", stdout=subprocess.PIPE) as process:
        assert process.communicate()[0] == b"2\n"
