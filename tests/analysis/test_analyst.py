"""The analyst in real processes: the newest wins, nobody waits, nothing is left."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import wait
from pathlib import Path

import pytest

from workbench.analysis.analyst import Analyst
from workbench.analysis.queries import (
    DrawMap,
    FindRanges,
    Judge,
    Predict,
    RequestedStep,
    Sensitivities,
    Tune,
)
from workbench.analysis.replies import Judged, Mapped, Predicted
from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import SupersededError
from workbench.scenario.scenario import Scenario, VehicleConfig

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
STEP = RequestedStep("x", 2.0, 1.5)
HARD = ("x.rise_time <= 0.1", "pitch.phase_margin >= 70deg")


@pytest.fixture(scope="module")
def analyst():
    analyst = Analyst(Scenario(), {"kp_roll": 200.0})
    yield analyst
    analyst.close()


@pytest.fixture
def own():
    """An analyst of the test's own, and what it told of its search."""
    told = []
    analyst = Analyst(Scenario(), {}, told.append)
    yield analyst, told
    analyst.close()


def running(pid):
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def margins_of(judged):
    """Return what tells an answer of some gains from one of others."""
    return [(each.name, each.gain_margin, each.phase_margin) for each in judged.loops]


def wait_until(condition):
    end = time.monotonic() + ENOUGH
    while not condition():
        assert time.monotonic() < end, "nothing happens"
        time.sleep(0.01)


def test_each_question_gets_its_reply(analyst):
    asked = [
        (FindRanges({}), dict),
        (DrawMap({}, "kp_pitch", "kd_pitch", "overshoot", STEP), Mapped),
        (Predict({"kd_pitch": 25.0}, STEP), Predicted),
        (Judge({"kp_roll": 180.0}), Judged),
    ]
    replies = [(analyst.ask(question), kind) for question, kind in asked]
    for reply, kind in replies:
        assert isinstance(reply.result(ENOUGH), kind)
    assert margins_of(replies[3][0].result()) != margins_of(analyst.ask(Judge({})).result(ENOUGH))
    assert analyst.pids[1] is None  # nothing slow was asked


def test_of_a_kind_that_waits_the_newest_wins(analyst):
    analyst.ask(Judge({})).result(ENOUGH)
    replies = [analyst.ask(Judge({"kp_roll": 100.0 + n})) for n in range(200)]
    wait(replies, ENOUGH)
    last = replies[-1].result()
    again = analyst.ask(Judge({"kp_roll": 299.0})).result(ENOUGH)
    assert margins_of(last) == margins_of(again)
    dropped = [each for each in replies if isinstance(each.exception(), SupersededError)]
    answered = [each for each in replies if each.exception() is None]
    assert len(dropped) + len(answered) == 200
    assert len(dropped) > 100  # they came much faster than they can be answered


def test_bad_questions_are_refused_with_a_sentence_and_the_next_is_answered(analyst):
    for question, said in (
        (Judge({"kp_roll": float("nan")}), "give it a number"),
        (Judge({"kp_rol": 1.0}), "did you mean 'kp_roll'"),
        (Judge(None), "the analyst failed: "),
        (Predict({}, RequestedStep("x", 0.0, 1.0)), "the amplitude is 0"),
        (Judge({"kp_roll": threading.Lock()}), "the request cannot be sent to a process"),
        ("margins?", "'margins\\?' is not a question"),
    ):
        with pytest.raises(WorkbenchError, match=said):
            analyst.ask(question).result(ENOUGH)
    assert analyst.ask(Judge({})).result(ENOUGH).stable


def test_asking_never_waits(analyst):
    """Not for a process that stands still either: a wait for it would have no end."""
    analyst.ask(Judge({})).result(ENOUGH)
    analyst.ask(Predict({}, STEP)).result(ENOUGH)
    stopped = [pid for pid in analyst.pids if pid is not None]
    for pid in stopped:
        os.kill(pid, signal.SIGSTOP)
    try:
        for number in range(500):
            judged = analyst.ask(Judge({"kp_roll": 100.0 + number}))
            predicted = analyst.ask(Predict({"kp_roll": 100.0 + number}, STEP))
        assert not judged.done() and not predicted.done()
    finally:
        for pid in stopped:
            os.kill(pid, signal.SIGCONT)
    gains = {"kp_roll": 599.0}
    last = judged.result(ENOUGH), predicted.result(ENOUGH)
    assert margins_of(last[0]) == margins_of(analyst.ask(Judge(gains)).result(ENOUGH))
    again = analyst.ask(Predict(gains, STEP)).result(ENOUGH)
    assert (last[1].response == again.response).all()


def test_a_killed_process_is_a_sentence_and_the_next_question_starts_another(analyst):
    analyst.ask(Judge({})).result(ENOUGH)
    first = analyst.pids[0]
    os.kill(first, signal.SIGSTOP)
    pending = analyst.ask(Judge({}))
    os.kill(first, signal.SIGKILL)
    with pytest.raises(WorkbenchError, match="the analyst's process was killed"):
        pending.result(ENOUGH)
    assert analyst.ask(Judge({})).result(ENOUGH).stable
    assert analyst.pids[0] != first


def test_after_some_deaths_in_a_row_no_further_process_is_started(own):
    analyst, _ = own
    for _ in range(3):
        pending = analyst.ask(Judge({}))
        while analyst.pids[0] is None or not running(analyst.pids[0]):
            time.sleep(0.001)
        os.kill(analyst.pids[0], signal.SIGKILL)
        with pytest.raises(WorkbenchError, match="was killed"):
            pending.result(ENOUGH)
    with pytest.raises(WorkbenchError, match="has failed 3 times: .*: open the scenario again"):
        analyst.ask(Judge({})).result(ENOUGH)


@pytest.mark.slow
def test_a_search_is_stopped_and_keeps_its_best(own):
    analyst, told = own
    tuned = analyst.ask(Tune({}, HARD))
    wait_until(lambda: told)
    analyst.stop()
    reply = tuned.result(ENOUGH)
    assert reply.stopped
    assert not reply.met
    assert set(reply.gains) >= {"kp_velocity_x", "kp_pitch"}
    assert 0.0 <= told[0].share <= 1.0
    assert analyst.ask(Sensitivities({}, STEP)).result(ENOUGH)  # what is asked later is not stopped


@pytest.mark.slow
def test_nothing_waits_for_a_search_or_is_stopped_with_it(own):
    analyst, told = own
    tuned = analyst.ask(Tune({}, HARD))
    wait_until(lambda: told)
    weighed = analyst.ask(Sensitivities({}, STEP))
    assert weighed.result(ENOUGH)
    assert not tuned.done()
    weighed = analyst.ask(Sensitivities({}, STEP))
    analyst.stop()
    assert weighed.result(ENOUGH)
    assert tuned.result(ENOUGH).stopped


@pytest.mark.parametrize(
    "searching",
    [False, pytest.param(True, marks=pytest.mark.slow)],
    ids=["before a search", "within a search"],
)
def test_closing_leaves_nothing(searching):
    threads, sockets = set(threading.enumerate()), open_sockets()
    told = []
    analyst = Analyst(Scenario(), {}, told.append)
    asked = [analyst.ask(Judge({})), analyst.ask(Tune({}, HARD))]
    wait_until(lambda: told if searching else None not in (analyst.pids[0], analyst.pids[2]))
    pids = [pid for pid in analyst.pids if pid is not None]
    analyst.close()
    assert not any(running(pid) for pid in pids)
    assert set(threading.enumerate()) <= threads
    assert open_sockets() <= sockets
    with pytest.raises(WorkbenchError, match="closed"):
        asked[1].result(ENOUGH)
    with pytest.raises(WorkbenchError, match="closed"):
        analyst.ask(Judge({})).result(ENOUGH)
    analyst.close()  # twice does no harm


def open_sockets() -> set[str]:
    """Return the sockets of this process by their inodes, as file descriptors are given again."""
    found = set()
    for fd in Path("/proc/self/fd").iterdir():
        try:
            found.add(str(fd.readlink()))
        except OSError:  # the one that lists them
            continue
    return {each for each in found if each.startswith("socket:")}


@pytest.mark.slow
@pytest.mark.parametrize(
    "condition",
    ["analyst.pids[2]", "told"],
    ids=["before a search", "within a search"],
)
def test_it_ends_with_its_caller(condition):
    """A caller that is killed leaves no process behind."""
    code = (
        "import time\n"
        "from workbench.analysis.analyst import Analyst\n"
        "from workbench.analysis.queries import Tune\n"
        "from workbench.scenario.scenario import Scenario\n"
        "told = []\n"
        "analyst = Analyst(Scenario(), {}, told.append)\n"
        f"analyst.ask(Tune({{}}, {HARD!r}))\n"
        f"while not {condition}: time.sleep(0.01)\n"
        "print(analyst.pids[2], flush=True)\n"
        "time.sleep(600)\n"
    )
    caller = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid = int(caller.stdout.readline())
    caller.kill()
    caller.wait()
    caller.stdout.close()
    end = time.monotonic() + ENOUGH
    while running(pid):
        assert time.monotonic() < end, "the process goes on"
        time.sleep(0.01)


def test_a_vehicle_that_is_not_there_is_a_sentence():
    analyst = Analyst(Scenario(vehicle=VehicleConfig(model="no_drone")), {})
    try:
        for question in (Judge({}), Predict({}, STEP)):
            with pytest.raises(WorkbenchError, match="unknown model 'no_drone'"):
                analyst.ask(question).result(ENOUGH)
    finally:
        analyst.close()


def test_it_is_light_where_it_is_asked():
    """Neither Drake nor what compiles or plots is loaded by who asks."""
    code = (
        "import sys, workbench.analysis.analyst, workbench.analysis.replies\n"
        "import workbench.gui.analysis\n"
        "print(sorted({'pydrake', 'numba', 'scipy', 'control', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
